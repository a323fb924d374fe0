"""How runs of the command end early: exit status, message, what is kept."""

import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import ranks
from support.command import (
    COMMAND,
    FILES,
    TWO_SAVED,
    call,
    finish,
    hear,
    lines,
    start,
    tree,
    wait_for,
)

from fenics_yeast.output import read_history, read_profiles, read_summary
from fenics_yeast.simulation import History, Profiles, Timings, simulation
from fenics_yeast.simulation import Result as RunResult


def test_a_lost_equilibrium_exits_3_with_all_results(here: Path) -> None:
    late = ("--set", "run.end=100", "--set", "run.save=[40]", "--set", "growth.threshold=0.9")
    result = call("run", "small.toml", *late)
    assert result.exit_code == 3
    assert "no equilibrium" in result.stderr and result.stderr.count("\n") == 1
    assert result.stdout.splitlines()[-1] == "no-equilibrium; see out/small"
    folder = here / "out" / "small"
    assert tree(folder) == TWO_SAVED
    assert read_summary(folder).status == "no-equilibrium"
    history, profiles = read_history(folder), read_profiles(folder)
    assert [profile.time for profile in profiles] == [40, history.time_min[-1]]
    assert 70 < history.time_min[-1] < 80


@pytest.mark.parametrize(("status", "code"), [("failed", 4), ("interrupted", 130)])
def test_other_ends_have_their_exit_status(
    here: Path, monkeypatch: pytest.MonkeyPatch, status: str, code: int
) -> None:
    def simulate(*_: object, **__: object) -> RunResult:
        return RunResult(
            History(()), Profiles(()), status, "the reason", 0.0, 1, 0, 0, 0, Timings()
        )  # fmt: skip

    monkeypatch.setattr(simulation, "simulate", simulate)
    result = call("run", "small.toml", "--quiet")
    assert (result.exit_code, result.stdout) == (code, "")
    assert "the reason" in result.stderr and result.stderr.count("\n") == 1
    assert read_summary(here / "out" / "small").status == status


INTERRUPTS = [[signal.SIGINT], [signal.SIGTERM], [signal.SIGHUP], [signal.SIGINT, signal.SIGTERM]]


@pytest.mark.process
@pytest.mark.parametrize("numbers", INTERRUPTS)
def test_an_interrupted_run_exits_130_and_keeps_what_it_has(here: Path, numbers: list[int]) -> None:
    """Ctrl-C, the end of a batch job or of a connection; once more while figures are drawn."""
    slow = ("--set", "numerics.step=0.002", "--set", "run.save=[20]")
    process = start("run", "small.toml", "--quiet", *slow)
    folder = here / "out" / "small"
    wait_for(lambda: lines(folder) > 10, process)
    for number in numbers:
        process.send_signal(number)
        time.sleep(0.03 if number is numbers[0] else 0)
    output, errors = process.communicate(timeout=60)
    assert (process.returncode, output) == (130, "")
    assert errors.startswith("interrupted at ") and errors.count("\n") == 1
    history, profiles = read_history(folder), read_profiles(folder)
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"] == "interrupted"
    assert summary["end_time_min"] == history.time_min[-1] == profiles.all[-1].time
    assert summary["steps"] == len(history) - 1
    assert tree(folder) == FILES if len(numbers) == 1 else tree(folder) <= FILES


@pytest.mark.process
def test_under_nohup_the_end_of_a_connection_is_no_matter(here: Path) -> None:
    command = ["nohup", *COMMAND, "run", "small.toml", "--quiet", "--set", "numerics.step=0.02"]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe)
    folder = here / "out" / "small"
    wait_for(lambda: lines(folder) > 10, process)
    process.send_signal(signal.SIGHUP)
    assert (*process.communicate(timeout=60), process.returncode) == (b"", b"", 0)
    assert read_summary(folder).status == "finished"


@pytest.mark.process
def test_a_script_ends_with_its_connection() -> None:
    """Which MPI's libraries would keep from it."""
    code = "from fenics_yeast import simulate; import os; os.kill(os.getpid(), 1); print('goes on')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, preexec_fn=hear
    )
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGHUP, "", "")


def on_a_small_disk(size: int, *options: str) -> subprocess.CompletedProcess[str]:
    """Run the scene where no file may be larger than so many bytes."""
    before = (
        "import resource; from mpi4py import MPI; import fenics_yeast.command.main\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))"
    )
    return finish("run", "small.toml", "--quiet", *options, before=before)


@pytest.mark.process
def test_a_disk_that_fills_up_ends_the_run_in_a_line(here: Path) -> None:
    """The history then has whole lines only."""
    done = on_a_small_disk(1500)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("error: out/small: cannot be written: ")
    assert done.stderr.endswith("; fix this, then rerun the scene\n")
    assert done.stderr.count("\n") == 1
    folder = here / "out" / "small"
    rows = read_history(folder)
    assert (folder / "history.csv").read_text().count("\n") == len(rows) + 1 > 1
    assert (folder / "history.csv").read_bytes().endswith(b"\n")
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"] == "failed"
    assert "cannot be written" in summary["message"]
    assert summary["steps"] == len(rows) - 1


@pytest.mark.process
def test_where_only_a_figure_does_not_fit_the_run_has_a_warning(here: Path) -> None:
    """Resuming it draws the figure, or says again that it cannot be written."""
    advice = "to create them, run: fenics-yeast plot out/small"
    for options in ((), ("--resume",)):
        done = on_a_small_disk(50_000, *options)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
        summary = read_summary(here / "out" / "small")
        assert summary is not None and summary.status == "finished"
        assert summary.warnings[-1].startswith("figures are missing (out/small: cannot be written")
        assert summary.warnings[-1].endswith(advice)
    resumed = call("run", "small.toml", "--resume")
    assert resumed.exit_code == 0
    assert TWO_SAVED <= tree(here / "out" / "small") | {"surface/0001.vtu"}


@pytest.mark.process
@pytest.mark.parametrize("quiet", [(), ("--quiet",)])
def test_a_full_standard_output_does_not_end_a_run(here: Path, quiet: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        done = finish("run", "small.toml", *quiet, stdout=full)
    assert done.returncode == 0
    warned = "warning: standard output cannot be written: No space left on device; the results"
    assert done.stderr.startswith(warned) or quiet
    assert done.stderr.count("\n") == 1 - len(quiet)
    assert tree(here / "out" / "small") == TWO_SAVED


@pytest.mark.process
def test_a_user_s_settings_of_matplotlib_do_not_cost_figures(here: Path) -> None:
    """TeX that is not installed, fonts that are missing, the back end of a notebook."""
    (here / "matplotlibrc").write_text(
        "text.usetex: True\nfont.family: No Such Font\naxes.formatter.use_mathtext: True\n"
    )
    text = (here / "small.toml").read_text()
    (here / "small.toml").write_text(text.replace('"Test bud"', "'酵母 $x^{2$'"))
    environment = ranks.environment() | {
        "MPLBACKEND": "module://no_such_backend.inline",
        "MATPLOTLIBRC": str(here),
    }
    done = finish("run", "small.toml", "--quiet", env=environment)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert read_summary(here / "out" / "small").warnings == ()
    assert tree(here / "out" / "small") == TWO_SAVED
    done = finish("plot", "out/small", env=environment)
    assert (done.returncode, done.stderr) == (0, "")


def test_interrupted_figures_and_error_bars_leave_the_run_as_it_is(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    bars = "studies.error_bars.estimate_error_bars"
    for part, message in ((bars, "; the error bars were interrupted"),
                          ("figures.draw", "")):  # fmt: skip
        monkeypatch.setattr(f"fenics_yeast.{part}", interrupted)
        result = call("run", "small.toml", "--quiet", "--error-bars")
        assert (result.exit_code, result.stderr) == (130, "interrupted\n")
        summary = json.loads((here / "out" / "small" / "run.json").read_text())
        assert summary["status"] == "finished"
        assert summary["message"] == "reached 20 min" + message


def test_a_run_without_error_bars_says_why_and_prints_no_table(here: Path) -> None:
    small = (here / "small.toml").read_text()
    cell, turgor = small.index("[cell]"), small.index("[turgor]")
    path = "[path]\nuntil = { volume_ratio = 1.1 }\nsteps = 2\n"
    Path("path.toml").write_text(small[cell:turgor] + path)
    result = call("run", "path.toml", "--error-bars")
    assert result.exit_code == 0, result.stderr
    assert "no error bars: an equilibrium path has no saved times" in result.stdout
    assert "time steps" not in result.stdout


def test_an_interrupt_of_the_compilation_leaves_what_the_folder_holds(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And anywhere else where the simulation cannot tell of it: before, or on its way out."""
    real = simulation.simulate

    def interrupted(*arguments: Any, **options: Any) -> None:
        real(*arguments, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(simulation, "simulate", interrupted)
    result = call("run", "small.toml", "--quiet")
    assert (result.exit_code, result.stderr) == (
        130,
        "interrupted at 20 min; rerun with --resume to continue\n",
    )
    folder = here / "out" / "small"
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"] == "interrupted" and summary["end_time_min"] == 20
    assert len(read_history(folder)) == summary["steps"] + 1 > 10
    assert [profile.time for profile in read_profiles(folder)] == [10, 20]


@pytest.mark.process
def test_a_reader_that_goes_away_does_not_end_the_run(here: Path) -> None:
    process = start("run", "small.toml")
    assert process.stdout is not None
    process.stdout.close()
    assert process.wait(60) == 0
    assert read_summary(here / "out" / "small").status == "finished"


FINE = ("--set", "numerics.step=0.04", "--set", "run.save=[1, 10, 20]")


@pytest.mark.process
def test_a_folder_removed_during_the_run_is_made_again(here: Path) -> None:
    folder = here / "out" / "small"
    process = start("run", "small.toml", "--quiet", *FINE)
    wait_for(lambda: lines(folder) > 40, process)
    shutil.rmtree(folder.rename(here / "removed"))  # at once: the run makes it again
    assert process.wait(60) == 0
    times = read_history(folder).time_min
    assert times[0] == 0 and times[-1] == 20 and len(times) > 400
    assert [profile.time for profile in read_profiles(folder)] == [1, 10, 20]
    assert read_summary(folder).status == "finished"


@pytest.mark.process
def test_a_full_disk_leaves_what_fitted(here: Path) -> None:
    done = on_a_small_disk(30_000, *FINE)
    assert done.returncode == 1
    assert done.stderr.startswith("error: out/small: cannot be written: ")
    folder = here / "out" / "small"
    history, profiles = read_history(folder), read_profiles(folder)
    assert len(history) > 100
    assert [profile.time for profile in profiles] == [1]
    assert np.isfinite(history.volume_ratio).all()


@pytest.mark.process
def test_a_solver_that_gives_up_exits_4_with_what_it_has(here: Path) -> None:
    before = (
        "from fenics_yeast.solve.time_stepper import TimeStepper, EquilibriumError\n"
        "attempt = TimeStepper.attempt\n"
        "def gives_up(self, end):\n"
        "    if end > 5: raise EquilibriumError('no luck', 3)\n"
        "    return attempt(self, end)\n"
        "TimeStepper.attempt = gives_up"
    )
    done = finish("run", "small.toml", "--quiet", *FINE, before=before)
    assert done.returncode == 4, done.stderr
    assert done.stderr.startswith("error: no convergence beyond ") and "no luck" in done.stderr
    assert done.stderr.count("\n") == 1
    folder = here / "out" / "small"
    assert read_summary(folder).status == "failed"
    history, profiles = read_history(folder), read_profiles(folder)
    assert 4.9 < history.time_min[-1] <= 5
    assert [profile.time for profile in profiles] == [1, history.time_min[-1]]
