"""A run that is taken up after any end is the run that nothing disturbed."""

import math
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.ranks import environment, mpirun
from support.same import same
from support.scenes import SMALL

from fenics_yeast import Scene, _dolfinx, simulate
from fenics_yeast.mechanics.ordering import Ordering
from fenics_yeast.output import read_history, read_result, read_summary
from fenics_yeast.simulation import COLUMNS, build_shell
from fenics_yeast.simulation import checkpointer as checkpointer
from fenics_yeast.simulation.checkpoint import Checkpoint, ResumePoint
from fenics_yeast.solve.time_stepper import StepperState

KILLS = 10

SCENE = SMALL.replace("[10, 20]", "[1, 10, 20]")


@pytest.fixture
def here(here: Path) -> Path:
    """The working directory, with a scene in it that saves three times."""
    (here / "small.toml").write_text(SCENE)
    return here


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
