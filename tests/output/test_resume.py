"""A run that is taken up after any end is the run that nothing disturbed."""

import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command import call
from support.ranks import environment, mpirun
from support.scenes import SMALL
from typer.testing import Result

from fenics_yeast import Scene, _dolfinx, simulate
from fenics_yeast.mechanics.ordering import Ordering
from fenics_yeast.output import read_history, read_profiles, read_result, read_summary, restart
from fenics_yeast.simulation import COLUMNS, Observers, Profiles, build_shell
from fenics_yeast.simulation import Result as RunResult
from fenics_yeast.simulation import checkpointer as checkpointer
from fenics_yeast.simulation.checkpoint import FORMAT, Checkpoint, CheckpointError, ResumePoint
from fenics_yeast.simulation.checkpoint import _digest as checkpoint_digest
from fenics_yeast.simulation.transient import Transient
from fenics_yeast.solve.time_stepper import StepperState

KILLS = 10

SCENE = SMALL.replace("[10, 20]", "[1, 10, 20]")


@pytest.fixture
def here(here: Path) -> Path:
    """The working directory, with a scene in it that saves three times."""
    (here / "small.toml").write_text(SCENE)
    return here


def same(one: RunResult, other: RunResult) -> None:
    """All but the time that it took is the same, to the last digit."""
    assert one.history.rows == other.history.rows
    assert (one.status, one.message) == (other.status, other.message)
    assert one.newton_iterations == other.newton_iterations
    assert one.rejected_steps == other.rejected_steps
    same_profiles(one.profiles, other.profiles)


def same_profiles(some: Profiles, others: Profiles) -> None:
    ours, theirs = some.arrays(), others.arrays()
    assert ours.keys() == theirs.keys()
    assert all(np.array_equal(ours[name], theirs[name]) for name in ours)


# --- the state ----------------------------------------------------------------------------

CHANGES = {
    "adaptive, to a limit point": {"growth.threshold": 0.9, "run.end": 100, "run.save": [40]},
    "explicit": {
        "run": {"end": 10, "save": [5, 10]},
        "numerics": {"preset": "paper", "elements": 60, "integrator": "forward-euler",
                     "step": "adaptive", "tolerance": 1e-2},
    },
    "fixed": {"numerics": {"preset": "paper", "elements": 60, "step": 4.0}},
    "changing turgor, spans of growth": {
        "turgor.pressure": {"time": [0, 30, 40], "value": [0.2, 0.2, 0.02]},
        "growth.from": 10, "run": {"end": 60, "save": [20, 60]},
    },
    "following the tip": {
        "growth.zone.half_angle": 60, "growth.polarity": {"width": "1 um", "follow": "tip"},
        "run": {"end": 5, "save": [5]},
    },
    "elastic, to a limit pressure": {
        "growth": None, "run": {"end": 5, "save": [1, 5]}, "turgor.ramp": 3.0,
        "turgor.pressure": 3.0,
    },
    "membrane": {"wall.bending": False, "run": {"end": 30, "save": [30]}},
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", CHANGES)
def test_every_step_can_be_taken_up(
    cell_scene: Scene, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps of all kinds, with failures and an end of another kind still ahead."""
    monkeypatch.setattr(checkpointer, "_EVERY", 0.0)
    monkeypatch.setattr(checkpointer, "_SHARE", math.inf)
    scene = cell_scene.with_values({"numerics": {"preset": "default"}, **CHANGES[case]})
    kept: list[Checkpoint] = []
    whole = simulate(scene, keep=kept.append)
    assert len(kept) > 4
    for checkpoint in kept[:: len(kept) // 4]:
        read = Checkpoint.from_bytes(checkpoint.to_bytes())
        recorder = read.recorder
        start = ResumePoint(
            read,
            tuple(whole.history.rows[: recorder.rows]),
            whole.profiles.all[: recorder.profiles],
        )
        again = simulate(scene, start=start)
        assert recorder.rows < len(whole.history) or checkpoint is kept[-1]
        same(again, whole)


def test_dofs_are_ordered_by_component_and_place(cell_scene: Scene) -> None:
    """Each place has its own rank in the order, and goes there and back."""
    for changes in ({}, {"wall.bending": False}):
        shell = build_shell(cell_scene.with_values({"numerics.elements": 40, **changes}))
        components, S = _dolfinx.dof_places(shell.space)
        assert len({*zip(components, S.round(12), strict=True)}) == len(shell.w.x.array)
        assert set(components) == ({0, 1, 2, 3} if shell.bending else {0, 1})
        shell.w.x.array[:] = 10.0 * components + S
        layout = Ordering(shell.space, shell.growing_points)
        eps_g = shell.growth.get()
        state = StepperState(0.0, shell.w.x.array.copy(), eps_g, None, None, (), ())
        ordered = layout.ordered(state)
        assert np.all(np.diff(ordered.w) > 0)
        np.testing.assert_array_equal(layout.local(ordered).w, state.w)


def test_saved_times_that_are_one_share_their_profile(cell_scene: Scene) -> None:
    scene = cell_scene.with_values(
        {"numerics": {"preset": "paper", "elements": 20}, "run.end": 1.0}
    )
    times = [1e-9, 0.5, 0.5 * (1 + 1e-15), 1.0]
    result = simulate(scene.with_values({"run.save": times}))
    assert len(result.profiles) == 3
    for t in times:
        assert result.profiles.at(t).time == pytest.approx(t, rel=1e-12)


# --- killed -------------------------------------------------------------------------------

# Checkpoints often, so that many are half-written when the process is killed.
COMMAND = """\
import os, sys
from pathlib import Path
from mpi4py import MPI
from fenics_yeast.simulation import checkpointer as keeper
keeper._EVERY, keeper._SHARE = 0.01, 1.0
if MPI.COMM_WORLD.rank == 0:
    Path("pid").write_text(str(os.getpid()))
from fenics_yeast.command.main import main
main()
"""
END = 12
LONG = ("--set=numerics.step=0.05", f"--set=run.end={END}", f"--set=run.save=[1, {END}]")


class Runs:
    """Runs of the long scene into folders, on a number of ranks."""

    def __init__(self, here: Path, ranks: int) -> None:
        self.here, self.ranks = here, ranks
        (here / "command.py").write_text(COMMAND)

    def start(self, folder: str, *options: str) -> subprocess.Popen[bytes]:
        command = [*mpirun(self.ranks), sys.executable, "command.py", "run", "small.toml", *LONG]
        (self.here / "pid").unlink(missing_ok=True)
        return subprocess.Popen(
            [*command, "--out", folder, "--quiet", *options],
            env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip

    def finish(self, folder: str, *options: str) -> None:
        process = self.start(folder, *options)
        _, errors = process.communicate(timeout=300)
        assert process.returncode == 0, errors.decode()

    def kill(self, folder: str, rows: float, *options: str) -> bool:
        """Kill a run after some new rows and part of the next; False if it was too late."""
        path = self.here / folder / "history.csv"
        before = path.stat().st_ino if path.exists() else None
        process = self.start(folder, *options)
        deadline = time.monotonic() + 200
        begun = None
        while begun is None or path.read_bytes().count(b"\n") < begun + rows:
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.002)
            if begun is None and path.exists() and path.stat().st_ino != before:
                begun = path.read_bytes().count(b"\n")
        time.sleep(0.01 * (rows % 1))
        killed = process.poll() is None
        if killed:
            os.kill(int((self.here / "pid").read_text()), signal.SIGKILL)
        process.communicate(timeout=60)
        return killed and process.returncode != 0


@pytest.fixture
def moments() -> Iterator[float]:
    """Numbers of rows after which to kill."""
    source = random.Random(1)
    return iter(lambda: source.uniform(1, 16), None)


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.ranks)])
def test_killed_ten_times_a_run_is_that_of_no_kill(
    here: Path, ranks: int, moments: Iterator[float]
) -> None:
    runs = Runs(here, ranks)
    runs.finish("whole")  # which also compiles all forms
    reached = []
    options: tuple[str, ...] = ()
    for _ in range(KILLS):
        assert runs.kill("killed", next(moments), *options)
        reached.append(read_history(here / "killed").time_min[-1])  # which reads
        assert read_summary(here / "killed") is None
        options = ("--resume",)
    assert reached[-1] > reached[0] and reached[-1] < END
    runs.finish("killed", "--resume")
    whole, killed = (read_result(here / name) for name in ("whole", "killed"))
    same(killed, whole)
    assert (here / "killed" / "history.csv").read_bytes() == (
        here / "whole" / "history.csv"
    ).read_bytes()
    assert not list((here / "killed").glob("*.part"))


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.ranks
def test_a_checkpoint_is_that_of_any_number_of_ranks(here: Path) -> None:
    """Sums are rounded in another order: as many digits agree as in test_mpi."""
    runs = {ranks: Runs(here, ranks) for ranks in (1, 2)}
    runs[1].finish("whole")
    whole = read_result(here / "whole")
    for first, then in ((1, 2), (2, 1)):
        folder = f"{first}-{then}"
        assert runs[first].kill(folder, 60)
        runs[then].finish(folder, "--resume")
        resumed = read_result(here / folder)
        for name in COLUMNS:
            ours, theirs = (getattr(r.history, name) for r in (resumed, whole))
            if name != "newton_iterations":
                np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9, err_msg=name)


# --- the command --------------------------------------------------------------------------


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
