"""`run --resume`: what it says, what it continues and what it refuses."""

import random
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command import call
from support.same import same
from support.scenes import SMALL
from typer.testing import Result

from fenics_yeast import Scene, simulate
from fenics_yeast.output import read_history, read_profiles, read_result, read_summary, restart
from fenics_yeast.simulation import Observers
from fenics_yeast.simulation import checkpointer as checkpointer
from fenics_yeast.simulation.checkpoint import FORMAT, Checkpoint, CheckpointError
from fenics_yeast.simulation.checkpoint import _digest as checkpoint_digest
from fenics_yeast.simulation.transient import Transient

SCENE = SMALL.replace("[10, 20]", "[1, 10, 20]")


@pytest.fixture
def here(here: Path) -> Path:
    """The working directory, with a scene in it that saves three times."""
    (here / "small.toml").write_text(SCENE)
    return here


def run(*arguments: str) -> Result:
    return call("run", "small.toml", *arguments)


def refused(result: Result, *words: str) -> None:
    assert result.exit_code == 2, result.output
    assert result.stderr.startswith("error: out/small") and result.stderr.count("\n") == 1
    for word in words:
        assert word in result.stderr


@pytest.fixture
def finished(here: Path) -> Path:
    assert run("--quiet").exit_code == 0
    return here / "out" / "small"


def test_a_finished_run_says_so_and_stays_as_it_is(finished: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in finished.rglob("*")}
    result = run("--resume")
    assert result.exit_code == 0 and result.stderr == ""
    assert "out/small: already complete; reached 20 min" in result.stdout
    assert {path: path.stat().st_mtime_ns for path in finished.rglob("*")} == before


def test_a_lost_equilibrium_says_so_with_its_exit_status(here: Path) -> None:
    soft = ("--set", "growth.threshold=0.9", "--set", "run.end=100", "--set", "run.save=[40]")
    first = run("--quiet", *soft)
    again = run("--quiet", "--resume", *soft)
    assert (first.exit_code, again.exit_code) == (3, 3)
    assert again.stderr == first.stderr and "no equilibrium" in again.stderr


def test_without_a_checkpoint_a_run_starts_from_the_beginning(here: Path) -> None:
    result = run("--resume")
    assert result.exit_code == 0
    assert result.stdout.startswith("out/small: no checkpoint; starting from")
    assert read_summary(here / "out" / "small").status == "finished"


def test_a_path_starts_from_the_beginning(here: Path) -> None:
    text = SCENE[: SCENE.index("[growth]")]
    (here / "small.toml").write_text(text + "[path]\nuntil = { volume_ratio = 1.1 }\nsteps = 4\n")
    for word in ("an equilibrium path cannot be resumed", "already complete; reached 0.538"):
        result = run("--resume")
        assert result.exit_code == 0 and word in result.stdout


@pytest.mark.slow
def test_a_run_goes_on_to_a_later_end(finished: Path) -> None:
    earlier = read_result(finished)
    result = run("--resume", "--set", "run.end=24", "--set", "run.save=[1, 10, 20, 24]")
    assert result.exit_code == 0, result.output
    assert "resuming from 20 min" in result.stdout
    later = read_result(finished)
    assert later.history.rows[: len(earlier.history)] == earlier.history.rows
    assert later.history.time_min[-1] == 24
    assert [profile.time for profile in read_profiles(finished)] == [1, 10, 20, 24]
    for name in ("loop_s", "total_s", "import_s"):
        assert getattr(later.timings, name) > getattr(earlier.timings, name)
    # And is the run to the later end, of which 20 min is a saved time.
    run("--quiet", "--out", "anew", "--set", "run.end=24", "--set", "run.save=[1, 10, 20, 24]")
    same(later, read_result(finished.parent.parent / "anew"))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["wall.thickness=0.2"], ["a different scene", "wall.thickness was 0.1, is now 0.2"]),
        (["numerics.step=1"], ["a different scene", "numerics.step was 2.0, is now 1.0"]),
        (["run.end=10", "run.save=[10]"], ["already at 20 min"]),
        (["run.end=30", "run.save=[5, 30]"], ["5 min of run.save has passed without a profile"]),
    ],
)
def test_what_the_folder_does_not_hold_is_refused(
    finished: Path, changes: list[str], words: list[str]
) -> None:
    before = {path: path.read_bytes() for path in finished.glob("*.*")}
    refused(run("--resume", *(f"--set={change}" for change in changes)), *words)
    assert {path: path.read_bytes() for path in finished.glob("*.*")} == before


def test_a_title_makes_no_other_scene(finished: Path) -> None:
    (finished.parent.parent / "small.toml").write_text(SCENE.replace("Test bud", "Mine"))
    assert run("--resume", "--quiet").exit_code == 0


def test_a_damaged_checkpoint_is_refused(finished: Path) -> None:
    path = finished / "checkpoint.npz"
    whole = path.read_bytes()
    source = random.Random(2)
    for length in (0, 1, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        refused(run("--resume"), "checkpoint.npz: is damaged")
    harmful = 0
    for _ in range(40):  # a flipped bit is reported, or has no effect
        at = source.randrange(len(whole))
        content = bytearray(whole)
        content[at] ^= 1 << source.randrange(8)
        try:
            read = Checkpoint.from_bytes(bytes(content))
        except CheckpointError as error:
            harmful += 1
            assert str(error) == "is damaged" or "has format" in str(error)
        else:
            assert read.to_bytes() == Checkpoint.from_bytes(whole).to_bytes()
    assert harmful > 20


def test_a_checkpoint_of_another_format_is_refused(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fenics_yeast.simulation.checkpoint.FORMAT", FORMAT + 1)
    refused(run("--resume"), f"has format {FORMAT}, and this version reads format {FORMAT + 1}")


def test_a_history_that_was_cut_behind_its_checkpoint_is_refused(finished: Path) -> None:
    lines = (finished / "history.csv").read_text().splitlines(keepends=True)
    (finished / "history.csv").write_text("".join(lines[:5]))
    (finished / "run.json").unlink()
    refused(run("--resume"), "of history.csv is missing")


def test_a_history_that_was_edited_is_refused(finished: Path) -> None:
    """In any digit of any row before the checkpoint."""
    path = finished / "history.csv"
    lines = path.read_text().splitlines(keepends=True)
    (finished / "run.json").unlink()
    for row, column in ((1, 3), (4, 2), (len(lines) - 1, 6)):
        cells = lines[row].split(",")
        cells[column] = repr(float(cells[column]) * (1 + 1e-15) + 1e-15)
        path.write_text("".join([*lines[:row], ",".join(cells), *lines[row + 1 :]]))
        refused(run("--resume"), "cannot resume: history.csv was changed")


def test_a_checkpoint_that_lacks_a_key_is_refused_by_name(finished: Path) -> None:
    """As it may be if somebody made it: its digest is right."""
    path = finished / "checkpoint.npz"
    with np.load(path) as file:
        arrays = dict(file)
    del arrays["sha256"], arrays["stepper.time"]
    np.savez(path, **arrays, sha256=np.array(checkpoint_digest(arrays)))
    refused(run("--resume"), "checkpoint.npz: lacks stepper.time")


def test_a_new_run_forgets_the_checkpoint_of_the_old_one(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(self: Transient):  # type: ignore[no-untyped-def]
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(Transient, "run", breaks)
    assert run("--quiet").exit_code == 130
    assert not (finished / "checkpoint.npz").exists()


@pytest.mark.slow
def test_an_interrupted_run_goes_on(here: Path) -> None:
    whole = simulate(Scene.load("small.toml"))
    folder = here / "out" / "small"
    for at in (3, 7):  # one after the other

        class Stop:
            def accepted(self, row, at=at):  # type: ignore[no-untyped-def]
                if row.time_min > at:
                    raise KeyboardInterrupt

            def saved(self, profile):  # type: ignore[no-untyped-def]
                return

        with pytest.MonkeyPatch.context() as patch:
            stopped = lambda observers, stop=Stop: Observers([*observers, stop()])  # noqa: E731
            patch.setattr("fenics_yeast.simulation.Observers", stopped)
            assert run("--quiet", *(["--resume"] if at > 3 else [])).exit_code == 130
        assert read_summary(folder).status == "interrupted"
        assert read_result(folder).profiles.all[-1].time == read_history(folder).time_min[-1]
    assert run("--quiet", "--resume").exit_code == 0
    same(read_result(folder), whole)


def test_a_folder_that_was_copied_goes_on_elsewhere(finished: Path) -> None:
    shutil.copytree(finished, "copy")
    past = restart.find_earlier_run(Path("copy"), Scene.load("small.toml"))
    assert past.ended is not None and past.start is not None
    assert len(past.start.rows) == len(past.ended.history)


def test_a_checkpoint_of_another_mesh_is_refused(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As another version may make it from the same scene."""
    read = Checkpoint.from_bytes((finished / "checkpoint.npz").read_bytes())
    state = replace(read.stepper, w=read.stepper.w[:-3])
    (finished / "checkpoint.npz").write_bytes(replace(read, stepper=state).to_bytes())
    (finished / "run.json").unlink()
    refused(run("--resume"), "another mesh")
