"""`fenics-yeast modes`: critical pressures per number of waves, as table and pictures."""

import csv
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.command import call, tree

from fenics_yeast import Scene
from fenics_yeast.output import read_history, read_mode, read_result, read_summary
from fenics_yeast.simulation import buckling_modes

CAPSULE = """
cell = { shape = "capsule", diameter = 5, length = 15 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.2 }
"""


@pytest.mark.slow
def test_linear_buckling_of_a_capsule_is_near_its_bifurcations(tmp_path: Path) -> None:
    """Those of a run are at -0.0152991, -0.0087192 and -0.0137889 MPa."""
    scene = tmp_path / "capsule.toml"
    scene.write_text(CAPSULE)
    out = tmp_path / "modes"
    result = call("modes", str(scene), "--waves", "0:5", "--out", str(out))
    assert result.exit_code == 0, result.stderr
    assert tree(out) == {"modes.csv", "modes.png", "mode.vtu"}
    rows = list(csv.DictReader((out / "modes.csv").read_text().splitlines()))
    found = {int(row["waves"]): float(row["critical_pressure_MPa"]) for row in rows}
    assert list(found) == [0, 1, 2, 3, 4, 5]
    for waves, expected in {2: 0.0152991, 3: 0.0087192, 4: 0.0137889}.items():
        assert -found[waves] == pytest.approx(expected, rel=5e-3)
    assert f"  3 waves: {found[3]:.6g} MPa" in result.stdout
    # Three waves around the waist, and none at the poles.
    mode = meshio.read(out / "mode.vtu")
    x, y, z = mode.points.T
    z = z - (z.min() + z.max()) / 2
    moved = mode.point_data["displacement (µm)"]
    assert 0.45 < np.linalg.norm(moved, axis=1).max() <= 0.5
    assert np.abs(moved[abs(z) > 7]).max() < 0.05
    ring = abs(abs(z) - abs(z).min()) < 1e-6
    angle = np.arctan2(y[ring], x[ring])
    radial = moved[ring, 0] * np.cos(angle) + moved[ring, 1] * np.sin(angle)
    assert abs(np.mean(radial * np.exp(3j * angle))) > 0.9 * radial.max() / 2


def test_a_mode_with_one_wave_is_none_of_a_rigid_motion() -> None:
    """A closed cell could tilt around a point; its first mode does not depend on the mesh."""
    cells = (
        ('shape = "spheroid", diameter = 5, height = 2.5', 0.05, 0.0173),
        ('shape = "capsule", diameter = 5, length = 15', 0.1, 0.2576),
    )
    for cell, h, expected in cells:
        for elements in (60, 120):
            scene = Scene.from_toml(f"""
            cell = {{ {cell} }}
            wall = {{ thickness = {h}, shear_modulus = 40 }}
            turgor = {{ pressure = 0 }}
            numerics = {{ elements = {elements} }}
            """)
            (mode,) = buckling_modes(scene, [1])
            assert mode.pressure == pytest.approx(-expected, rel=3e-3)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--waves", "a:b"), "--waves a:b: expected A:B or A,B,..."),
        (("--waves", "5:2"), "--waves 5:2: expected"),
        (("--set", "wall.bending=false"), "buckling needs a wall with bending stiffness"),
        (("--set", "cell.length=3"), "cell.length = 3"),
    ],
)
def test_what_has_no_modes_is_refused_on_one_line(
    tmp_path: Path, options: tuple[str, ...], said: str
) -> None:
    scene = tmp_path / "capsule.toml"
    scene.write_text(CAPSULE)
    result = call("modes", str(scene), *options, "--out", str(tmp_path / "out"))
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    assert said in result.stderr
    assert not (tmp_path / "out").exists()


DEFLATED = CAPSULE.replace("pressure = 0.2", "pressure = { time = [0, 10], value = [0.1, -0.02] }")


@pytest.mark.slow
def test_a_run_that_stopped_at_a_bifurcation_goes_on_if_it_need_not_stop(tmp_path: Path) -> None:
    """And ends like one that was never to stop there, to the last digit."""
    scene = tmp_path / "capsule.toml"
    scene.write_text(DEFLATED + "run = { end = 10 }\nnumerics = { thickness_points = 2 }\n")
    whole = call("run", str(scene), "--quiet", "--out", str(tmp_path / "whole"))
    assert whole.exit_code == 0
    stop = ("--set", "run.stop_at_bifurcation=true")
    out = ("--quiet", "--out", str(tmp_path / "parts"))
    stopped = call("run", str(scene), *out, *stop)
    assert stopped.exit_code == 3
    assert "stopped at a bifurcation; unstable beyond" in stopped.stderr
    again = call("run", str(scene), *out, *stop, "--resume")
    assert (again.exit_code, again.stderr) == (3, stopped.stderr)
    assert call("run", str(scene), *out, "--resume").exit_code == 0
    one, other = (read_history(tmp_path / name) for name in ("whole", "parts"))
    assert one.rows == other.rows
    waves = read_summary(tmp_path / "parts").bifurcation
    assert waves is not None and waves.waves == 3
    modes = [read_mode(tmp_path / name) for name in ("whole", "parts")]
    for values in zip(*(vars(mode).values() for mode in modes), strict=True):
        np.testing.assert_array_equal(*values)


def test_plot_draws_the_mode_of_a_run_and_a_new_run_removes_it(tmp_path: Path) -> None:
    scene, out = tmp_path / "capsule.toml", tmp_path / "out"
    path = "path = { until = { pressure = -0.012 }, steps = 5 }\n"
    scene.write_text(CAPSULE + path + "numerics = { elements = 16 }\n")
    run = ("run", str(scene), "--quiet", "--out", str(out))
    assert call(*run).exit_code == 0
    drawn = call("plot", str(out))
    assert drawn.exit_code == 0, drawn.stderr
    assert {"mode.npz", "mode.vtu", "figures/mode.png"} <= tree(out)
    mode = meshio.read(out / "mode.vtu")
    moved = np.linalg.norm(mode.point_data["displacement (µm)"], axis=1)
    assert 0.45 < moved.max() <= 0.5
    assert read_result(out).mode is not None
    assert call(*run, "--set", "path.until.pressure=-0.005").exit_code == 0
    assert not {"mode.npz", "mode.vtu", "figures/mode.png"} & tree(out)
    assert read_mode(out) is None
    (out / "mode.npz").write_bytes(b"PK")
    damaged = call("plot", str(out))
    assert damaged.exit_code == 2 and "mode.npz: damaged" in damaged.stderr
