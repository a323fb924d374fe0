"""Runs of a turgid outline: its unloaded shape is found once, kept and reported."""

import json
from pathlib import Path

import numpy as np
import pytest
from support import command
from support.scenes import SMALL
from support.shapes import ellipse

from fenics_yeast import Scene
from fenics_yeast.output import read_history, read_result, read_scene
from fenics_yeast.simulation import discretise

CELL = 'shape = "profile"\nfile = "cell.csv"\ntolerance = 0\noutline_is = "turgid"'
SCENE = SMALL.replace('shape = "sphere"\ndiameter = "5 um"', CELL)


@pytest.fixture
def here(here: Path) -> Path:
    """The working directory, with a turgid outline and its scene in it."""
    np.savetxt(here / "cell.csv", np.column_stack(ellipse(80, 2.5, 3.0)), delimiter=",",
               header="r,z", comments="", fmt="%.10f")  # fmt: skip
    (here / "turgid.toml").write_text(SCENE)
    return here


RUN = ("run", "turgid.toml", "--no-figures", "--out", "out")


@pytest.mark.slow
def test_a_run_keeps_and_reports_the_unloaded_shape(here):
    done = command.call(*RUN)
    assert (done.exit_code, done.stderr) == (0, "")
    note, *_ = done.stdout.splitlines()
    assert note.startswith("unloaded shape found; under turgor it is within ")
    given, kept = Scene.load("turgid.toml"), read_scene(here / "out")
    assert kept == given and kept.cell.unloaded is not None
    summary = json.loads((here / "out" / "run.json").read_text())["unloaded"]
    assert 0 <= summary["residual_distance_um"] < 1e-6
    assert 0.01 < summary["largest_displacement_um"] < 0.1
    result = read_result(here / "out")
    assert vars(result.unloaded) == summary
    # Volumes are relative to that of the unloaded shape.
    curve = discretise(kept).curve
    S = np.linspace(0, curve.length, 20001)
    r, z = curve.radius(S), curve.height(S)
    volume = np.pi / 3 * (np.diff(z) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2)).sum()
    row = result.history.rows[-1]
    assert row.volume_um3 / row.volume_ratio == pytest.approx(volume, rel=2e-4)  # 60 elements


@pytest.mark.slow
def test_what_is_resumed_or_run_again_from_its_directory_has_the_same_shape(here):
    """To the last digit; it is not found again."""
    whole = command.call(*RUN)
    assert whole.exit_code == 0
    parts = ("run", "turgid.toml", "--no-figures", "--out", "parts")
    assert command.call(*parts, "--set", "run.end=10", "--set", "run.save=[10]").exit_code == 0
    done = command.call(*parts, "--resume")
    assert done.exit_code == 0 and "unloaded shape found" not in done.stdout
    again = command.call("run", "out/scene.toml", "--no-figures", "--out", "again")
    assert again.exit_code == 0 and "unloaded shape found" not in again.stdout
    ended = command.call(*RUN, "--resume").stdout
    assert ended.startswith("out: already complete; reached 20 min\n")
    expected = read_history(here / "out").volume_ratio
    for name in ("parts", "again"):
        assert (read_history(here / name).volume_ratio == expected).all()
    other = command.call(*parts, "--resume", "--set", "turgor.pressure=0.3")
    assert other.exit_code == 2 and "different scene (turgor.pressure" in other.stderr


@pytest.mark.slow
def test_an_outline_without_an_unloaded_shape_fails_with_its_reason(here):
    done = command.call(*RUN, "--set", "turgor.pressure=3.6")
    assert done.exit_code == 4
    assert done.stderr.startswith("error: no unloaded shape found for the turgid outline: beyond ")
    summary = json.loads((here / "out" / "run.json").read_text())
    assert summary["status"] == "failed" and done.stderr == f"error: {summary['message']}\n"
    assert "unloaded" not in summary


def test_an_outline_is_turgid_only_under_turgor(here):
    done = command.call("check", "turgid.toml", "--set", "turgor.pressure=0")
    assert done.exit_code == 2
    assert done.stderr == (
        'error: turgid.toml: cell.outline_is = "turgid": expected "unloaded", or a '
        "turgor.pressure other than 0, under which it was seen\n"
    )
    assert command.call("check", "turgid.toml").stdout == "turgid.toml: valid\n"


@pytest.mark.slow
def test_two_ranks_have_the_shape_of_one(here, mpirun):
    script = f"""
from fenics_yeast import Scene
from fenics_yeast.simulation import find_unloaded

found = find_unloaded(Scene.load({str(here / "turgid.toml")!r}))
from mpi4py import MPI
assert len(set(MPI.COMM_WORLD.allgather(found.to_toml()))) == 1
open("found.toml", "w").write(found.to_toml())
"""
    shapes = [Scene.load(mpirun(script, ranks) / "found.toml").cell.unloaded for ranks in (1, 2)]
    assert shapes[0] == shapes[1]
