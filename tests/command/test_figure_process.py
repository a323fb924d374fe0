"""Figures are drawn by a second process, or by the run's own if that one is lost."""

import signal
from pathlib import Path

import pytest
from support.command import TWO_SAVED, call, finish, start, tree, wait_for

from fenics_yeast.output import SHAPES, VOLUME, read_summary

# Without it, a machine of one core would not start the second process.
TWO_CORES = "import os; os.sched_getaffinity = lambda _: {0, 1}\n"
LOST = f"""{TWO_CORES}
from fenics_yeast.command import figure_process as module
draw = module.FigureProcess.draw
def draw_without(self, *parts):
    os.kill(self._process, 9)
    return draw(self, *parts)
module.FigureProcess.draw = draw_without
"""
IN_ONE = "import os; os.sched_getaffinity = lambda _: {0}\n"


@pytest.mark.process
def test_figures_are_the_same_whichever_process_draws_them(here: Path) -> None:
    """The second one, the run's own, and the run's own because the second one was killed."""
    drawn = []
    for number, before in enumerate((TWO_CORES, IN_ONE, LOST)):
        done = finish("run", "small.toml", "--quiet", "--out", f"{number}", before=before)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
        assert tree(here / f"{number}") == TWO_SAVED
        assert read_summary(here / f"{number}").warnings == ()
        drawn.append([(here / f"{number}" / name).read_bytes() for name in (SHAPES, VOLUME)])
    assert drawn[0] == drawn[1] == drawn[2]


@pytest.mark.process
def test_the_second_process_ends_with_a_run_that_is_killed(here: Path) -> None:
    command = ("run", "small.toml", "--quiet", "--set", "numerics.step=0.002")
    process = start(*command, before=TWO_CORES)
    wait_for(lambda: (here / "out" / "small" / "history.csv").exists(), process)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert len(children) == 1
    process.kill()
    assert process.wait() == -signal.SIGKILL
    process.communicate(timeout=20)  # ends when no process has its output open any more


def test_a_figure_that_fails_is_a_warning_in_either_process(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ValueError("no font")

    monkeypatch.setattr("fenics_yeast.figures.draw", fail)
    assert call("run", "small.toml", "--quiet").exit_code == 0
    (warning,) = read_summary(here / "out" / "small").warnings
    assert warning.startswith("figures are missing (ValueError: no font)")
