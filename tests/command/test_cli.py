"""The command: exit status, what it prints and where, what it writes, how it refuses bad input."""

import json
import os
import pty
import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from support import ranks
from support.command import FILES, TWO_SAVED, call, finish, start, tree
from support.scenes import SMALL
from typer.testing import Result

from fenics_yeast import Scene, _form_cache
from fenics_yeast.output import read_history, read_profiles, read_summary

PNG = b"\x89PNG\r\n\x1a\n"


# A run that finishes --------------------------------------------------------------------------


def test_run_leaves_its_folder_and_says_so(here: Path) -> None:
    result = call("run", "small.toml")
    assert (result.exit_code, result.stderr) == (0, "")
    folder = here / "out" / "small"
    assert tree(folder) == TWO_SAVED
    history = read_history(folder)
    expected = [f"{t} min: V/V0 = {history.at(t).volume_ratio:.6f}" for t in (10, 20)]
    assert result.stdout.splitlines() == [*expected, "finished: reached 20 min; see out/small"]
    assert [profile.time for profile in read_profiles(folder)] == [10, 20]
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
    assert read_history(here / "a b" / "c").pressure_MPa[-1] == 0.101325


def test_figures_can_be_left_to_plot(here: Path) -> None:
    assert call("run", "small.toml", "--no-figures").exit_code == 0
    folder = here / "out" / "small"
    drawn = {name for name in TWO_SAVED if name.startswith(("figures/", "surface"))}
    assert tree(folder) == TWO_SAVED - drawn
    assert call("run", "small.toml", "--no-figures", "--resume").exit_code == 0
    assert tree(folder) == TWO_SAVED - drawn
    assert call("run", "small.toml", "--resume").exit_code == 0
    assert tree(folder) == TWO_SAVED
    assert call("plot", str(folder)).exit_code == 0


def test_a_run_can_be_repeated_from_its_own_scene(here: Path) -> None:
    arguments = ("--quiet", "--set", "run.end=4", "--set", "run.save=[4]")
    assert call("run", "small.toml", *arguments).exit_code == 0
    folder = here / "out" / "small"
    first = read_history(folder)
    assert call("run", str(folder / "scene.toml"), "--out", str(folder)).exit_code == 0
    np.testing.assert_array_equal(read_history(folder).volume_ratio, first.volume_ratio)


def test_a_static_scene_gives_one_row_and_one_shape(here: Path) -> None:
    text = SMALL[: SMALL.index("[growth]")]
    (here / "static.toml").write_text(text)
    result = call("run", "static.toml")
    assert result.exit_code == 0
    folder = here / "out" / "static"
    assert tree(folder) == FILES - {"figures/volume.png"}
    assert len(read_history(folder)) == len(read_profiles(folder)) == 1


def on_a_terminal(width: int) -> str:
    """What a run of the small scene shows on a terminal of a width."""
    master, slave = pty.openpty()
    environment = ranks.environment() | {"TERM": "xterm", "COLUMNS": str(width)}
    process = start("run", "small.toml", stdin=slave, stdout=slave, stderr=slave, env=environment)
    os.close(slave)
    shown = b""
    while True:
        try:
            shown += os.read(master, 65536)
        except OSError:  # the process has closed its end
            break
    os.close(master)
    assert process.wait() == 0
    return shown.decode()


@pytest.mark.process
def test_on_a_terminal_there_is_progress_and_a_table(here: Path) -> None:
    text = on_a_terminal(100)
    assert " of 20 min" in text and "drawing figures" in text and "0:00:00" not in text
    table = text[text.index("bud radius (µm)") :]
    history = read_history(here / "out" / "small")
    for t in (10, 20):
        assert f"{history.at(t).volume_ratio:.6f}" in table
    assert table.rstrip().endswith("finished: reached 20 min; see out/small")


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


@pytest.mark.process
def test_a_service_has_no_home_in_its_environment(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without one Open MPI 5 aborts."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(_form_cache.folder().parent.parent))
    monkeypatch.delenv("HOME")
    done = finish("run", "small.toml", "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert read_summary(here / "out" / "small").status == "finished"


@pytest.mark.process
def test_an_unknown_user_without_a_home_runs_and_leaves_nothing(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(_form_cache.folder().parent.parent))
    monkeypatch.delenv("HOME")
    (here / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(here / "temporary"))
    before = "import pwd; pwd.getpwuid = {}.__getitem__"
    done = finish("run", "small.toml", "--quiet", before=before)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not list((here / "temporary").glob("fenics-yeast-*"))


@pytest.mark.process
def test_a_home_that_cannot_be_written_is_no_matter(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the cache is elsewhere: matplotlib would tell of it at length."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(_form_cache.folder().parent.parent))
    monkeypatch.setenv("HOME", "/proc/nowhere")
    monkeypatch.delenv("MPLCONFIGDIR", raising=False)
    for arguments in (("run", "small.toml", "--quiet"), ("plot", "out/small")):
        done = finish(*arguments)
        assert (done.returncode, done.stderr) == (0, "")


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
    assert old in SMALL
    (here / "bad.toml").write_text(SMALL.replace(old, new))
    for command in ("check", "run"):
        refused(call(command, "bad.toml"), "bad.toml", *words)
    assert tree(here) == {"small.toml", "bad.toml"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "nowhere.toml"), ("nowhere.toml", "no such file")),
        (("check", "nowhere.toml"), ("nowhere.toml", "no such file")),
        (("run", "."), ("Is a directory",)),
        (("run", "small.toml", "--set", "growth.time"), ("growth.time", "TABLE.KEY=VALUE")),
        (("run", "small.toml", "--set", "growth.tim=3"), ("growth.time",)),
        (("run", "small.toml", "--set", "growth.time=-3"), ("growth.time", "-3")),
        (("run", "small.toml", "--out", "small.toml"), ("small.toml", "is a file")),
        (("run", "small.toml", "--out", "small.toml/x"), ("small.toml/x", "is a file")),
        (("run", "small.toml", "--out", "/proc/x"), ("/proc/x", "cannot be written")),
        (("plot", "nowhere"), ("nowhere", "no such directory")),
    ],
)
def test_bad_arguments_are_refused_in_a_line(
    here: Path, arguments: Sequence[str], words: Sequence[str]
) -> None:
    refused(call(*arguments), *words)
    assert tree(here) == {"small.toml"}


def test_the_scene_itself_is_not_overwritten(here: Path) -> None:
    (here / "scene.toml").write_text(SMALL)
    refused(call("run", "scene.toml", "--out", "."), "contains a scene.toml that is not from a run")
    assert (here / "scene.toml").read_text() == SMALL


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
    assert (result.exit_code, result.stdout) == (0, "small.toml: valid\n")
    refused(call("check", "small.toml", "--set", "growth.time=-1"), "growth.time = -1")
    assert tree(here) == {"small.toml"}


def test_the_version_is_shown() -> None:
    result = call("--version")
    assert (result.exit_code, result.stdout) == (0, f"fenics-yeast {version('fenics-yeast')}\n")


@pytest.mark.process
@pytest.mark.parametrize(
    ("arguments", "heavy"),
    [
        (["--help"], {"dolfinx", "mpi4py", "petsc4py", "matplotlib", "pint", "rich"}),
        (["check", "small.toml"], {"dolfinx", "mpi4py", "petsc4py", "matplotlib", "rich"}),
    ],
)
def test_quick_commands_load_nothing_heavy(
    here: Path, arguments: list[str], heavy: set[str]
) -> None:
    code = (
        "import sys; from fenics_yeast.command.main import app\n"
        f"app({arguments}, standalone_mode=False); print(*sys.modules, file=sys.stderr)"
    )
    loaded = []
    for program in (code, "import sys, typer; print(*sys.modules, file=sys.stderr)"):
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        loaded.append(set(done.stderr.split()))
    assert not heavy & (loaded[0] - loaded[1])  # older typer loads rich itself


@pytest.mark.process
@pytest.mark.parametrize("width", [20, 40, 60, 100])
def test_tables_are_readable_on_a_narrow_terminal(here: Path, width: int) -> None:
    """No number is cut or broken over lines; further columns are left out."""
    text = on_a_terminal(width)
    table = text.replace("\r", "").splitlines()
    history = read_history(here / "out" / "small")
    for t in (10, 20):
        assert any(
            line.split()[:2] == [f"{t}", f"{history.at(t).volume_ratio:.6f}"] for line in table
        )
    assert ("bud radius" in text) == (width > 72)


def test_a_run_extended_beyond_its_saved_times_prints_its_last_volume(here: Path) -> None:
    assert call("run", "small.toml").exit_code == 0
    extended = call("run", "small.toml", "--resume", "--set", "run.end=24")
    assert extended.exit_code == 0
    last = read_history(here / "out" / "small").rows[-1]
    assert last.time_min == 24
    assert f"24 min: V/V0 = {last.volume_ratio:.6f}" in extended.stdout
