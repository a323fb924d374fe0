"""Error bars compared with errors, by runs that are finer in everything; see `data`."""

import json
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from support.command import call

from fenics_yeast import simulate
from fenics_yeast.output import read_summary
from fenics_yeast.output.folder import OutputFolder
from fenics_yeast.scene import StaticPath, Until
from fenics_yeast.simulation import Timings
from fenics_yeast.studies import error_bars as module
from fenics_yeast.studies.error_bars import estimate_error_bars, refinements

pytestmark = pytest.mark.slow

PARTS = ("time_steps", "mesh", "thickness_points", "shear_penalty")

# Case of the table, and changes to the cell of the tables; all with 3 integration points.
SCENES = {
    "default preset": ("base", {}),
    "low threshold": ("low threshold", {"growth.threshold": 0.9}),
    "soft wall": ("soft wall", {"wall.shear_modulus": 20.0}),
    "thick wall": ("thick wall", {"wall.thickness": 0.2, "turgor.pressure": 0.4}),
    "wide zone": ("wide zone", {"growth.zone.half_angle": 40.0}),
    "stiff exponent": ("stiff exponent", {"wall.ogden_exponent": 6.0}),
    "few elements": (
        "base",
        {"numerics.order": 2, "numerics.elements": 8, "numerics.grading": "uniform"},
    ),
    "long steps": ("base", {"numerics.integrator": "sdirk2", "numerics.step": 8.0}),
    "first order": ("base", {"numerics.integrator": "forward-euler", "numerics.step": 0.5}),
    "soft shear": ("base", {"numerics.shear_penalty": 1.0}),
}


@pytest.fixture(scope="module")
def estimated(cell_scene, read_table):
    """Return error bars and errors of a scene at the times of the table; each runs once."""
    table = read_table("fine_volumes.csv")

    @cache
    def estimate(name: str) -> SimpleNamespace:
        case, changes = SCENES[name]
        rows = [row for row in table if row["case"] == case]
        exact = {float(row["time_min"]): float(row["volume_ratio"]) for row in rows}
        times = {"run.end": max(exact), "run.save": list(exact)}
        scene = cell_scene.with_values(times | {"numerics.thickness_points": 3} | changes)
        result = simulate(scene)
        errors = [abs(result.history.at(t).volume_ratio - v) for t, v in exact.items()]
        return SimpleNamespace(bars=estimate_error_bars(scene, result), errors=np.array(errors))

    return estimate


@pytest.mark.parametrize("name", SCENES)
def test_errors_are_within_the_error_bars(estimated, name):
    """The error is at most twice the bar, and the bar no more than twenty times the error."""
    found = estimated(name)
    assert found.bars.message == ""
    assert np.all(found.errors <= 2 * found.bars.total)
    assert np.all(found.bars.total <= 20 * found.errors)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("default preset", "thickness_points"),
        ("few elements", "mesh"),
        ("long steps", "time_steps"),
        ("soft shear", "shear_penalty"),
    ],
)
def test_a_coarse_part_has_the_larger_error_bar(estimated, name, part):
    """Compared with that of the default preset."""
    bars, default = estimated(name).bars, estimated("default preset").bars
    if name == "default preset":
        assert getattr(bars, part)[-1] > 0.9 * bars.total[-1]
        return
    assert getattr(bars, part)[-1] > 20 * getattr(default, part)[-1]
    for other in set(PARTS) - {part}:
        assert getattr(bars, other)[-1] < 3 * getattr(default, other)[-1] + 1e-4


def test_errors_of_the_default_preset_against_other_programs_are_within_its_bars(
    cell_scene, read_table
):
    """Five integration points compared with nine in two independent programs."""
    rows = [row for row in read_table("volumes.csv") if row["case"] == "base"]
    exact = {
        float(row["time_min"]): float(row["volume_ratio"])
        for row in rows
        if row["thickness_points"] == "9" and float(row["time_min"]) >= 40
    }
    scene = cell_scene.with_values({"run.save": list(exact), "numerics.thickness_points": 5})
    result = simulate(scene)
    bars = estimate_error_bars(scene, result)
    errors = [abs(result.history.at(t).volume_ratio - v) for t, v in exact.items()]
    assert list(bars.time_min) == list(exact)
    assert np.all(errors <= 2 * bars.total)
    assert np.all(bars.total <= 20 * np.array(errors))


def test_each_refinement_changes_one_setting(cell_scene):
    """The number of elements, which follows the tolerance, stays when that is refined."""
    for refinement in refinements(cell_scene):
        before = cell_scene.numerics.model_dump()
        after = cell_scene.with_values(refinement.changes).numerics.model_dump()
        changed = {key for key in before if before[key] != after[key]}
        settings = {"time_steps": "tolerance", "mesh": "elements"}
        assert changed == {settings.get(refinement.part, refinement.part)}


def test_a_setting_at_its_limit_is_compared_with_a_coarser_one(cell_scene):
    most = {"numerics.thickness_points": 24, "numerics.elements": 100_000}
    scene = cell_scene.with_values(most)
    finer = {refinement.part: refinement for refinement in refinements(scene)}
    for part, key in (("thickness_points", "thickness_points"), ("mesh", "elements")):
        changed = getattr(scene.with_values(finer[part].changes).numerics, key)
        assert changed < getattr(scene.numerics, key)
        assert finer[part].scale > 0


def test_parts_without_error_are_not_refined(cell_scene):
    """Without growth time steps have no error; an infinite shear penalty has none."""
    scene = cell_scene.with_values({"growth": None, "run": None})
    scene = scene.with_values({"numerics.shear_penalty": float("inf"), "numerics.order": 2})
    bars = estimate_error_bars(scene, simulate(scene))
    assert list(bars.time_min) == [0.0]
    assert bars.time_steps[0] == bars.shear_penalty[0] == 0
    assert 0 < bars.total[0] < 1e-4


def test_a_refined_run_that_loses_equilibrium_is_reported(cell_scene):
    """Long implicit steps lose it later than short ones."""
    changes = {
        "numerics.integrator": "backward-euler",
        "numerics.step": 4.0,
        "numerics.thickness_points": 3,
        "run.end": 93.6,
        "run.save": [80.0, 93.6],
    }
    scene = cell_scene.with_values(changes)
    result = simulate(scene)
    assert result.status == "finished"
    bars = estimate_error_bars(scene, result)
    assert "time steps refined: no equilibrium beyond 93.5" in bars.message
    assert "no equilibrium" in bars.message
    assert not np.isnan(bars.total[0])
    assert np.isnan(bars.time_steps[1]) and np.isnan(bars.total[1])
    assert not np.isnan(bars.thickness_points[1])


def test_saved_times_that_the_run_did_not_reach_have_no_error_bars(cell_scene):
    changes = {"growth.zone.half_angle": 40.0, "run.end": 60.0, "run.save": [20.0, 60.0]}
    scene = cell_scene.with_values(changes | {"numerics.thickness_points": 3})
    result = simulate(scene)
    assert result.status == "no-equilibrium"
    bars = estimate_error_bars(scene, result)
    assert list(bars.time_min) == [20.0]
    assert bars.message == ""


def test_an_equilibrium_path_has_no_error_bars(cell_scene):
    path = StaticPath(until=Until(volume_ratio=1.1), steps=2)
    scene = cell_scene.with_values({"growth": None, "run": None, "path": path})
    bars = estimate_error_bars(scene, simulate(scene))
    assert len(bars.total) == 0
    assert "an equilibrium path has no saved times" in bars.message


def test_an_interrupted_refined_run_raises_an_interrupt(cell_scene, monkeypatch):
    scene = cell_scene.with_values({"run.end": 1.0, "numerics.thickness_points": 3})
    result = simulate(scene)
    stopped = SimpleNamespace(status="interrupted")
    monkeypatch.setattr(module, "simulate", lambda *_, **__: stopped)
    with pytest.raises(KeyboardInterrupt):
        estimate_error_bars(scene, result)


def test_error_bars_are_written_to_and_read_from_the_summary(cell_scene, tmp_path):
    """Unknown values are null."""
    scene = cell_scene.with_values({"run.end": 1.0, "numerics.thickness_points": 3})
    result = simulate(scene)
    found = estimate_error_bars(scene, result)
    object.__setattr__(found, "mesh", np.array([np.nan]))
    object.__setattr__(result, "error_bars", found)
    with OutputFolder(tmp_path, scene) as folder:
        folder.finish(result, Timings())
    written = json.loads((tmp_path / "run.json").read_text())["error_bars"]
    assert list(written) == ["time_min", *PARTS, "total", "message"]
    assert written["mesh"] == written["total"] == [None]
    read = read_summary(tmp_path).error_bars
    assert read.time_steps == found.time_steps and np.isnan(read.total[0])


def test_the_command_shows_the_error_bars(cell_scene, tmp_path):
    """On the screen, in run.json and in the figure, which `plot` draws again."""
    values = {"preset": "paper", "elements": 60, "step": 2.0}
    scene = cell_scene.with_values({"numerics": values, "run.end": 20.0, "run.save": [10.0, 20.0]})
    (tmp_path / "small.toml").write_text(scene.to_toml())
    out = tmp_path / "out"
    command = ["run", str(tmp_path / "small.toml"), "--out", str(out)]
    figure = out / "figures" / "volume.png"

    assert call(*command).exit_code == 0
    assert "error_bars" not in json.loads((out / "run.json").read_text())
    without = figure.read_bytes()

    done = call(*command, "--error-bars")
    assert done.exit_code == 0
    written = json.loads((out / "run.json").read_text())["error_bars"]
    assert written["time_min"] == [10.0, 20.0]
    assert written["total"] == pytest.approx(np.sum([written[part] for part in PARTS], axis=0))
    lines = [line.split() for line in done.stdout.splitlines()]
    assert ["20", *(f"{written[name][1]:.1e}" for name in (*PARTS, "total"))] in lines
    with_bars = figure.read_bytes()
    assert with_bars != without

    assert call("plot", str(out)).exit_code == 0
    assert figure.read_bytes() == with_bars
