"""The command: exit status, what it prints and where, what it writes, how it is interrupted."""

import json
import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call, hear
from typer.testing import Result

from fenics_yeast import Scene, _form_cache, simulation
from fenics_yeast.reading import load_history, load_profiles, load_status
from fenics_yeast.record import History, Profiles, Timings
from fenics_yeast.record import Result as RunResult

COMMAND = [sys.executable, "-c", "from fenics_yeast.cli import main; main()"]
PNG = b"\x89PNG\r\n\x1a\n"

# The forms of the paper's preset, on few cells and with long steps.
SCENE = """\
title = "Test bud"
[cell]
shape = "sphere"
diameter = "5 um"
[wall]
thickness = "100 nm"
shear_modulus = "40 MPa"
[turgor]
pressure = "2 atm"
ramp = "0.01 min"
[growth]
zone = { pole = "top", half_angle = 24.0 }
threshold = "1 MPa"
time = "45 min"
[run]
end = "20 min"
save = [10, 20]
[numerics]
preset = "paper"
elements = 60
step = "2 min"
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a scene in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SCENE)
    return tmp_path


def start(*arguments: str) -> subprocess.Popen[str]:
    """Start the command as a process of its own, which hears Ctrl-C even in the background."""
    pipe = subprocess.PIPE
    command = [*COMMAND, *arguments]
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, preexec_fn=hear)


def tree(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


FILES = {
    "checkpoint.npz",
    "scene.toml", "history.csv", "profiles.npz", "run.json", "figures/shapes.png",
    "figures/volume.png", "surface.pvd", "surface/0000.vtu",
}  # fmt: skip
TWO_SAVED = FILES | {"surface/0001.vtu"}


# A run that finishes --------------------------------------------------------------------------


def test_run_leaves_its_folder_and_says_so(here: Path) -> None:
    result = call("run", "small.toml")
    assert (result.exit_code, result.stderr) == (0, "")
    folder = here / "out" / "small"
    assert tree(folder) == TWO_SAVED
    history = load_history(folder)
    expected = [f"{t} min: V/V0 = {history.at(t).volume_ratio:.6f}" for t in (10, 20)]
    assert result.stdout.splitlines() == [*expected, "finished, see out/small"]
    assert [profile.time for profile in load_profiles(folder)] == [10, 20]
    for name in ("shapes", "volume"):
        assert (folder / "figures" / f"{name}.png").read_bytes().startswith(PNG)
    summary = json.loads((folder / "run.json").read_text())
    assert (summary["status"], summary["end_time_min"]) == ("finished", 20)
    assert summary["steps"] == len(history) - 1
    assert summary["newton_iterations"] == history.newton_iterations.sum()
    parts = summary["timings"]
    total = parts.pop("total_s")
    assert all(seconds > 0 for seconds in parts.values())
    assert sum(parts.values()) <= total


def test_out_and_set_and_quiet(here: Path) -> None:
    changes = ("--set", "turgor.pressure=1 atm", "--set", "run.save=[5]", "--set", "run.end=5")
    result = call("run", "small.toml", "--out", "a b/c", "--quiet", *changes)
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    assert tree(here) == {"small.toml", *(f"a b/c/{name}" for name in FILES)}
    as_run = Scene.load(here / "a b" / "c" / "scene.toml")
    assert as_run.turgor.pressure == 0.101325
    assert as_run.run is not None and as_run.run.save == (5,)
    assert load_history(here / "a b" / "c").pressure_MPa[-1] == 0.101325


def test_a_run_can_be_repeated_from_its_own_scene(here: Path) -> None:
    arguments = ("--quiet", "--set", "run.end=4", "--set", "run.save=[4]")
    assert call("run", "small.toml", *arguments).exit_code == 0
    folder = here / "out" / "small"
    first = load_history(folder)
    assert call("run", str(folder / "scene.toml"), "--out", str(folder)).exit_code == 0
    np.testing.assert_array_equal(load_history(folder).volume_ratio, first.volume_ratio)


def test_a_static_scene_gives_one_row_and_one_shape(here: Path) -> None:
    text = SCENE[: SCENE.index("[growth]")]
    (here / "static.toml").write_text(text)
    result = call("run", "static.toml")
    assert result.exit_code == 0
    folder = here / "out" / "static"
    assert tree(folder) == FILES - {"figures/volume.png"}
    assert len(load_history(folder)) == len(load_profiles(folder)) == 1


def test_on_a_terminal_there_is_progress_and_a_table(here: Path) -> None:
    master, slave = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    environment.pop("OMPI_COMM_WORLD_SIZE", None)
    process = subprocess.Popen(
        [*COMMAND, "run", "small.toml"], stdin=slave, stdout=slave, stderr=slave, env=environment
    )
    os.close(slave)
    shown = b""
    while True:
        try:
            shown += os.read(master, 65536)
        except OSError:  # the process has closed its end
            break
    os.close(master)
    assert process.wait() == 0
    text = shown.decode()
    assert " of 20 min" in text and "left" in text
    table = text[text.index("bud radius (µm)") :]
    history = load_history(here / "out" / "small")
    for t in (10, 20):
        assert f"{history.at(t).volume_ratio:.6f}" in table
    assert table.rstrip().endswith("finished, see out/small")


def test_plot_draws_what_is_there(here: Path) -> None:
    assert call("run", "small.toml", "--quiet", "--out", "run").exit_code == 0
    folder = here / "run"
    for figure in ("shapes", "volume"):
        (folder / "figures" / f"{figure}.png").unlink()
    (folder / "run.json").unlink()  # as while the run goes
    with open(folder / "history.csv", "a") as file:
        file.write("21.0,0.2")
    result = call("plot", "run")
    assert result.exit_code == 0
    made = [f"figures/{name}.png" for name in ("shapes", "volume", "meridian")] + ["surface.pvd"]
    assert result.stdout.splitlines() == [f"run/{name}" for name in made]
    assert tree(folder) == TWO_SAVED - {"run.json"} | {"figures/meridian.png"}
    (folder / "profiles.npz").unlink()
    (folder / "history.csv").write_text("")
    assert call("plot", "run").exit_code == 2


# Bad input ------------------------------------------------------------------------------------


def refused(result: Result, *words: str) -> None:
    """Assert that input was refused in one line that holds some words."""
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("error: ") and result.stderr.count("\n") == 1, result.stderr
    for word in words:
        assert word in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[cell]", "[cell", ("not TOML",)),
        ("title", "titel", ("titel", "did you mean title")),
        ('diameter = "5 um"\n', "", ("cell.diameter", "missing")),
        ('"40 MPa"', "[1]", ("wall.shear_modulus",)),
        ('"40 MPa"', "nan", ("wall.shear_modulus", "nan")),
        ('"2 atm"', "inf", ("turgor.pressure", "inf")),
        ('"100 nm"', '"100 min"', ("wall.thickness", "100 min", "a length")),
        ('"100 nm"', '"9 um"', ("wall.thickness", "9 um", "radius")),
        ("24.0", "0", ("growth.zone.half_angle",)),
        ("24.0", "181", ("growth.zone.half_angle", "181")),
        ("[10, 20]", "[10, 30]", ("run.save", "30")),
        ('preset = "paper"', 'preset = "quick"', ("numerics.preset", "quick", "paper")),
    ],
)
def test_a_bad_scene_is_refused_in_a_line(
    here: Path, old: str, new: str, words: Sequence[str]
) -> None:
    assert old in SCENE
    (here / "bad.toml").write_text(SCENE.replace(old, new))
    for command in ("check", "run"):
        refused(call(command, "bad.toml"), "bad.toml", *words)
    assert tree(here) == {"small.toml", "bad.toml"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "nowhere.toml"), ("nowhere.toml", "no such file")),
        (("check", "nowhere.toml"), ("nowhere.toml", "no such file")),
        (("run", "."), ("folder",)),
        (("run", "small.toml", "--set", "growth.time"), ("growth.time", "TABLE.KEY=VALUE")),
        (("run", "small.toml", "--set", "growth.tim=3"), ("growth.time",)),
        (("run", "small.toml", "--set", "growth.time=-3"), ("growth.time", "-3")),
        (("run", "small.toml", "--out", "small.toml"), ("small.toml", "is a file")),
        (("run", "small.toml", "--out", "small.toml/x"), ("small.toml/x", "is a file")),
        (("run", "small.toml", "--out", "/proc/x"), ("/proc/x", "cannot be written")),
        (("plot", "nowhere"), ("nowhere", "holds no scene.toml")),
    ],
)
def test_bad_arguments_are_refused_in_a_line(
    here: Path, arguments: Sequence[str], words: Sequence[str]
) -> None:
    refused(call(*arguments), *words)
    assert tree(here) == {"small.toml"}


def test_the_scene_itself_is_not_overwritten(here: Path) -> None:
    (here / "scene.toml").write_text(SCENE)
    refused(call("run", "scene.toml", "--out", "."), "holds a scene.toml that no run has left")
    assert (here / "scene.toml").read_text() == SCENE


@pytest.mark.parametrize(
    "arguments", [("run",), ("frobnicate",), ("run", "small.toml", "--frobnicate"), ()]
)
def test_wrong_usage_exits_2(here: Path, arguments: Sequence[str]) -> None:
    result = call(*arguments)
    assert result.exit_code == 2 or (result.exit_code == 0 and not arguments)  # help; older click
    assert "Usage" in result.stdout + result.stderr
    assert tree(here) == {"small.toml"}


def test_check_says_that_a_scene_is_valid(here: Path) -> None:
    result = call("check", "small.toml")
    assert (result.exit_code, result.stdout) == (0, "small.toml: a valid scene\n")
    assert tree(here) == {"small.toml"}


@pytest.mark.parametrize(
    ("arguments", "heavy"),
    [
        (["--help"], {"dolfinx", "mpi4py", "petsc4py", "matplotlib", "numpy", "pint", "rich"}),
        (["check", "small.toml"], {"dolfinx", "mpi4py", "petsc4py", "matplotlib", "rich"}),
    ],
)
def test_quick_commands_load_nothing_heavy(
    here: Path, arguments: list[str], heavy: set[str]
) -> None:
    code = (
        "import sys; from fenics_yeast.cli import app\n"
        f"app({arguments}, standalone_mode=False); print(*sys.modules, file=sys.stderr)"
    )
    loaded = []
    for program in (code, "import sys, typer; print(*sys.modules, file=sys.stderr)"):
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        loaded.append(set(done.stderr.split()))
    assert not heavy & (loaded[0] - loaded[1])  # older typer loads rich itself


# Runs that end early --------------------------------------------------------------------------


def test_a_service_has_no_home_in_its_environment(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without one Open MPI 5 aborts."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(_form_cache.folder().parent.parent))
    monkeypatch.delenv("HOME")
    command = [*COMMAND, "run", "small.toml", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert load_status(here / "out" / "small") == "finished"


def test_a_home_that_cannot_be_written_is_no_matter(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the cache is elsewhere: matplotlib would tell of it at length."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(_form_cache.folder().parent.parent))
    monkeypatch.setenv("HOME", "/proc/nowhere")
    monkeypatch.delenv("MPLCONFIGDIR", raising=False)
    for arguments in (("run", "small.toml", "--quiet"), ("plot", "out/small")):
        done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=60)
        assert (done.returncode, done.stderr) == (0, "")


def test_a_lost_equilibrium_exits_3_with_all_results(here: Path) -> None:
    late = ("--set", "run.end=100", "--set", "run.save=[40]", "--set", "growth.threshold=0.9")
    result = call("run", "small.toml", *late)
    assert result.exit_code == 3
    assert "no equilibrium" in result.stderr and result.stderr.count("\n") == 1
    assert result.stdout.splitlines()[-1] == "no-equilibrium, see out/small"
    folder = here / "out" / "small"
    assert tree(folder) == TWO_SAVED
    assert load_status(folder) == "no-equilibrium"
    history, profiles = load_history(folder), load_profiles(folder)
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
    assert load_status(here / "out" / "small") == status


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 60
    while not condition():
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)


SIGNALS = [[signal.SIGINT], [signal.SIGTERM], [signal.SIGHUP], [signal.SIGINT, signal.SIGTERM]]


@pytest.mark.parametrize("numbers", SIGNALS)
def test_an_interrupted_run_exits_130_and_keeps_what_it_has(here: Path, numbers: list[int]) -> None:
    """Ctrl-C, the end of a batch job or of a connection; once more while figures are drawn."""
    process = start("run", "small.toml", "--quiet", "--set", "numerics.step=0.002")
    folder = here / "out" / "small"
    path = folder / "history.csv"
    wait_for(lambda: path.exists() and path.read_bytes().count(b"\n") > 10, process)
    for number in numbers:
        process.send_signal(number)
        time.sleep(0.03 if number is numbers[0] else 0)
    output, errors = process.communicate(timeout=60)
    assert (process.returncode, output) == (130, "")
    assert errors.startswith("interrupted at ") and errors.count("\n") == 1
    history, profiles = load_history(folder), load_profiles(folder)
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"] == "interrupted"
    assert summary["end_time_min"] == history.time_min[-1] == profiles.all[-1].time
    assert summary["steps"] == len(history) - 1
    assert tree(folder) == FILES if len(numbers) == 1 else tree(folder) <= FILES


def test_under_nohup_the_end_of_a_connection_is_no_matter(here: Path) -> None:
    command = ["nohup", *COMMAND, "run", "small.toml", "--quiet", "--set", "numerics.step=0.02"]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe)
    folder = here / "out" / "small"
    path = folder / "history.csv"
    wait_for(lambda: path.exists() and path.read_bytes().count(b"\n") > 10, process)
    process.send_signal(signal.SIGHUP)
    assert (*process.communicate(timeout=60), process.returncode) == (b"", b"", 0)
    assert load_status(folder) == "finished"


@pytest.mark.parametrize(
    ("size", "status", "advice"),
    [
        (1500, "failed", "run the scene again"),
        (50_000, "finished", "fenics-yeast plot out/small draws what lacks"),
    ],
)
def test_a_disk_that_fills_up_ends_the_run_in_a_line(
    here: Path, size: int, status: str, advice: str
) -> None:
    """In a line of the history, which then has whole lines only; or in a figure."""
    code = (
        "import resource; from mpi4py import MPI; from fenics_yeast.cli import main\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size})); main()"
    )
    command = [sys.executable, "-c", code, "run", "small.toml", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr.startswith("error: out/small: cannot be written: ")
    assert done.stderr.endswith(f"; once that is mended, {advice}\n")
    assert done.stderr.count("\n") == 1
    folder = here / "out" / "small"
    rows = load_history(folder)
    assert (folder / "history.csv").read_text().count("\n") == len(rows) + 1 > 1
    assert (folder / "history.csv").read_bytes().endswith(b"\n")
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"] == status
    assert ("cannot be written" in summary["message"]) == (status == "failed")
    assert summary["steps"] == len(rows) - 1


def test_interrupted_figures_and_error_bars_leave_the_run_as_it_is(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    for part, message in (("error_bars.error_bars", "; the error bars were interrupted"),
                          ("plots.draw", "")):  # fmt: skip
        monkeypatch.setattr(f"fenics_yeast.{part}", interrupted)
        result = call("run", "small.toml", "--quiet", "--error-bars")
        assert (result.exit_code, result.stderr) == (130, "interrupted\n")
        summary = json.loads((here / "out" / "small" / "run.json").read_text())
        assert summary["status"] == "finished"
        assert summary["message"] == "reached 20 min" + message


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
    assert (result.exit_code, result.stderr) == (130, "interrupted at 20 min\n")
    folder = here / "out" / "small"
    summary = json.loads((folder / "run.json").read_text())
    assert summary["status"] == "interrupted" and summary["end_time_min"] == 20
    assert len(load_history(folder)) == summary["steps"] + 1 > 10
    assert [profile.time for profile in load_profiles(folder)] == [10, 20]


def test_a_reader_that_goes_away_does_not_end_the_run(here: Path) -> None:
    process = start("run", "small.toml")
    assert process.stdout is not None
    process.stdout.close()
    assert process.wait(60) == 0
    assert load_status(here / "out" / "small") == "finished"
