"""Sweeps: their cases, parallel runs, failures and interruptions."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support import command
from support.command import lines, wait_for
from support.scenes import SMALL

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast.output import read_history, read_summary
from fenics_yeast.scene import unit_symbol
from fenics_yeast.studies.cases import parse_variation, plan

SCENE = SMALL.replace("20 min", "8 min").replace("[10, 20]", "[4, 8]")


@pytest.fixture
def here(here: Path) -> Path:
    """The working directory, with a short scene in it."""
    (here / "small.toml").write_text(SCENE)
    return here


@pytest.fixture(scope="module")
def bud() -> Scene:
    return Scene.from_toml(SCENE)


SWEEP = ("sweep", "small.toml", "--out", "sweep")


def start(*arguments: str) -> subprocess.Popen[str]:
    """Start a sweep as a process group of its own, as a terminal does."""
    return command.start(*SWEEP, *arguments, start_new_session=True)


def sweep(*arguments: str) -> subprocess.CompletedProcess[str]:
    return command.finish(*SWEEP, *arguments, start_new_session=True)


def table(folder: Path) -> list[dict[str, str]]:
    with open(folder / "sweep" / "sweep.csv") as file:
        return list(csv.DictReader(file))


# Planning -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "held"),
    [
        ("growth.time=30,45 min,1 h", [30, 45, 60]),
        ("growth.threshold=0.9:1.1:5", [0.9, 0.95, 1.0, 1.05, 1.1]),
        ("growth.threshold=0.9 MPa:1.1 MPa:3", [0.9, 1.0, 1.1]),
        ("growth.threshold=900:1100 kPa:3", [0.9, 1.0, 1.1]),
        ("growth.threshold = 1 , 0.9:1.1:3", [1.0, 0.9, 1.1]),
        ("turgor.pressure=-1e-1:0.1:3", [-0.1, 0.0, 0.1]),
        ("numerics.elements=10:30:3", [10, 20, 30]),
        ("numerics.preset=paper,default", ["paper", "default"]),
        ("numerics.geometry='conical',\"curved\"", ["conical", "curved"]),
        ("run.save=[4,8],[8]", ["[4 8]", "[8]"]),
    ],
)
def test_values_are_read_with_units_and_ranges(bud: Scene, text: str, held: list) -> None:
    cases = plan(bud, [parse_variation(text)])
    assert [case.values[0] for case in cases] == held  # exactly: 0.95, not 0.9500000000000001
    assert len({case.name for case in cases}) == len(cases)
    assert all(set(case.name) <= set("=.+,-_" + "abcdefghijklmnopqrstuvwxyz0123456789")
               for case in cases)  # fmt: skip


def test_cases_are_the_product_of_the_lists(bud: Scene) -> None:
    cases = plan(
        bud, [parse_variation("growth.time=30,60"), parse_variation("growth.threshold=1:2:3")]
    )
    assert [case.values for case in cases] == [
        (30, 1), (30, 1.5), (30, 2), (60, 1), (60, 1.5), (60, 2)
    ]  # fmt: skip
    assert cases[4].name == "growth.time=60_growth.threshold=1.5"
    assert cases[4].scene == bud.with_values({"growth.time": 60, "growth.threshold": 1.5})
    assert unit_symbol(cases[0].scene, "growth.threshold") == "MPa"
    assert unit_symbol(cases[0].scene, "turgor.pressure") == "MPa"
    assert unit_symbol(cases[0].scene, "numerics.elements") == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("growth.time", "write TABLE.KEY"),
        ("growth.time=", "write TABLE.KEY"),
        ("=3", "write TABLE.KEY"),
        ("growth.time=30,,45", "write TABLE.KEY"),
        ("growth.time=30:45", "write a range as A:B:N"),
        ("growth.time=30:45:1", "write a range as A:B:N"),
        ("growth.time=30:45:1e9", "write a range as A:B:N"),
        ("growth.time=a:b:3", "write a range as A:B:N"),
        ("growth.time=30 min:1 h:3", "in one unit"),
        ("growth.tim=30", "did you mean growth.time?"),
        ("growth.time=45,-3", "growth.time = -3: expected a time > 0"),
        ("growth.time=1 MPa:2 MPa:2", "expected a time > 0"),
        ("numerics.elements=10:20:4", "expected an integer"),
        ("wall.thickness=1:9:3", "less than the cell's radius"),
    ],
)
def test_an_invalid_plan_is_refused_on_one_line(bud: Scene, text: str, words: str) -> None:
    with pytest.raises(SceneError) as refusal:
        plan(bud, [parse_variation(text)])
    assert words in str(refusal.value) and "\n" not in str(refusal.value)


# Running --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.process
def test_a_sweep_writes_a_directory_for_each_case_a_table_and_a_figure(here: Path) -> None:
    vary = ("--vary", "growth.time=30,45", "--vary", "growth.threshold=0.9 MPa:1.1 MPa:2")
    done = sweep(*vary, "--jobs", "2", "--set", "run.save=[2,8]")
    assert (done.returncode, done.stderr) == (0, "")
    *lines, last = done.stdout.splitlines()
    assert sorted(line.split()[0] for line in lines) == ["1/4", "2/4", "3/4", "4/4"]
    assert last == "4 cases: 4 finished; see sweep/sweep.csv, sweep/sweep.png"
    assert (here / "sweep" / "sweep.png").read_bytes().startswith(b"\x89PNG")
    rows = table(here)
    assert [(row["growth.time"], row["growth.threshold"]) for row in rows] == [
        ("30.0", "0.9"), ("30.0", "1.1"), ("45.0", "0.9"), ("45.0", "1.1")
    ]  # fmt: skip
    for row in rows:
        folder = here / "sweep" / row["case"]
        assert not (folder / "figures").exists()
        changes = {key: float(row[key]) for key in ("growth.time", "growth.threshold")}
        alone = simulate(Scene.from_toml(SCENE).with_values({**changes, "run.save": [2, 8]}))
        for time_min in (2, 8):
            found = float(row[f"volume_ratio_at_{time_min}_min"])
            assert found == pytest.approx(alone.history.at(time_min).volume_ratio, abs=1e-12)
        np.testing.assert_allclose(
            read_history(folder).volume_ratio, alone.history.volume_ratio, rtol=1e-12
        )
        assert (row["status"], float(row["end_time_min"])) == ("finished", 8)
        assert float(row["wall_s"]) > 0
    plot = command.finish("plot", "sweep")
    assert plot.stdout == "sweep/sweep.png\n"
    case = f"sweep/{rows[0]['case']}"
    plot = command.finish("plot", case)
    assert f"{case}/figures/shapes.png" in plot.stdout


@pytest.mark.slow
@pytest.mark.process
def test_a_rerun_sweep_skips_finished_cases(here: Path) -> None:
    assert sweep("--vary", "growth.time=30,45", "--jobs", "1").returncode == 0
    folders = {time: here / "sweep" / f"growth.time={time}" for time in (30, 45, 60)}
    old = {time: folders[time].joinpath("run.json").stat().st_mtime_ns for time in (30, 45)}
    # A case is rerun if its directory has another scene or an incomplete summary.
    text = (folders[45] / "scene.toml").read_text()
    (folders[45] / "scene.toml").write_text(text.replace("thickness = 0.1", "thickness = 0.11"))
    done = sweep("--vary", "growth.time=30,45,60", "--jobs", "1")
    assert done.stdout.startswith(
        "1 of 3 cases have already ended; skipping them\n2/3  growth.time=45"
    )
    new = {time: folders[time].joinpath("run.json").stat().st_mtime_ns for time in folders}
    assert new[30] == old[30] and new[45] > old[45]
    assert [row["growth.time"] for row in table(here)] == ["30.0", "45.0", "60.0"]
    folders[60].joinpath("run.json").write_text("{")
    done = sweep("--vary", "growth.time=30,45,60", "--jobs", "1")
    assert done.stdout.startswith(
        "2 of 3 cases have already ended; skipping them\n3/3  growth.time=60"
    )
    assert read_summary(folders[60]).status == "finished"


@pytest.mark.process
def test_a_failing_case_is_a_row_with_its_reason(here: Path) -> None:
    blocked = here / "sweep" / "growth.time=45"
    blocked.mkdir(parents=True)
    (blocked / "history.csv").write_text("precious")
    done = sweep("--vary", "growth.time=30,45,60", "--jobs", "1", "--quiet")
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr == "error: 1 of 3 cases failed, first growth.time=45; see sweep.csv\n"
    rows = table(here)
    assert [row["status"] for row in rows] == ["finished", "failed", "finished"]
    assert "contains a history.csv that is not from a run" in rows[1]["message"]
    assert (blocked / "history.csv").read_text() == "precious"


@pytest.mark.process
def test_a_case_without_equilibrium_has_not_failed(here: Path) -> None:
    done = sweep("--vary", "turgor.pressure=0.2,2", "--jobs", "1", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
    assert [row["status"] for row in table(here)] == ["finished", "no-equilibrium"]


@pytest.mark.process
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--vary", "growth.tim=3"), "did you mean growth.time?"),
        (("--vary", "growth.time=3,-3"), "growth.time = -3"),
        (("--vary", "growth.time=3", "--vary", "growth.time=4"), "given twice"),
        (("--vary", "growth.time=3", "--set", "growth.tim=4"), "did you mean growth.time?"),
        (("--vary", "growth.time=3", "--out", "small.toml"), "small.toml: must be a directory"),
    ],
)
def test_errors_are_reported_before_anything_runs(
    here: Path, arguments: tuple[str, ...], words: str
) -> None:
    done = sweep(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr and done.stderr.count("\n") == 1
    assert [path.name for path in here.iterdir()] == ["small.toml"]


@pytest.mark.process
def test_a_table_that_is_not_from_a_sweep_is_not_overwritten(here: Path) -> None:
    (here / "sweep").mkdir()
    (here / "sweep" / "sweep.csv").write_text("my,own\n1,2\n")
    done = sweep("--vary", "growth.time=3")
    assert done.returncode == 2 and "not the table of a sweep" in done.stderr
    assert (here / "sweep" / "sweep.csv").read_text() == "my,own\n1,2\n"


# Interrupted and killed -----------------------------------------------------------------------

LONG = ("--set", "numerics.step=0.005")  # some seconds each


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize("to_all", [True, False])
def test_ctrl_c_stops_the_running_cases_and_keeps_their_results(here: Path, to_all: bool) -> None:
    """A terminal signals all processes; a batch system signals the first."""
    process = start("--vary", "growth.time=30,45,60", "--jobs", "2", *LONG)
    first, second = (here / "sweep" / f"growth.time={time}" for time in (30, 45))
    wait_for(lambda: lines(first) > 5 and lines(second) > 5, process)
    if to_all:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGTERM)
    output, errors = process.communicate(timeout=30)
    assert (process.returncode, output) == (130, "")
    # MPI's daemon may have written lines before.
    assert errors.splitlines()[-1] == "interrupted; rerun the same command to continue"
    kept = {}
    for folder in (first, second):
        assert read_summary(folder).status == "interrupted"
        kept[folder] = read_history(folder).rows
        assert 4 < len(kept[folder]) < 1600
    assert not (here / "sweep" / "growth.time=60").exists()
    done = sweep("--vary", "growth.time=30,45,60", "--jobs", "2", *LONG)
    assert done.returncode == 0
    assert [row["status"] for row in table(here)] == ["finished"] * 3
    for folder in (first, second):  # resumed, not restarted
        assert read_history(folder).rows[: len(kept[folder])] == kept[folder]
        assert read_history(folder).rows[-1].time_min == 8
        assert read_history(folder).rows[len(kept[folder])].step_min == pytest.approx(0.005)


def runs(process: int) -> bool:
    """Return whether a process runs; one that has ended but is not reaped has no command."""
    try:
        return bool(Path(f"/proc/{process}/cmdline").read_bytes())
    except OSError:
        return False


def children(process: subprocess.Popen[str]) -> list[int]:
    """Return the worker processes of a sweep."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
                called = (entry / "cmdline").read_text()
            except OSError:
                continue
            if parent == process.pid and "spawn_main" in called:
                found.append(int(entry.name))
    return found


@pytest.mark.process
def test_a_killed_process_fails_only_its_own_case(here: Path) -> None:
    """Cases that ran when a process was killed are rerun, one at a time."""
    process = start("--vary", "numerics.step=0.002,2,4", "--jobs", "1")
    killed = here / "sweep" / "numerics.step=0.002"
    wait_for(lambda: lines(killed) > 5, process)
    for child in children(process):
        os.kill(child, signal.SIGKILL)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 4
    assert errors == "error: 1 of 3 cases failed, first numerics.step=0.002; see sweep.csv\n"
    rows = table(here)
    assert [row["status"] for row in rows] == ["failed", "finished", "finished"]
    assert "process was killed" in rows[0]["message"]


@pytest.mark.process
def test_no_case_keeps_running_when_the_sweep_is_killed(here: Path) -> None:
    process = start("--vary", "growth.time=30,45", "--jobs", "2", *LONG)
    wait_for(lambda: lines(here / "sweep" / "growth.time=45") > 5, process)
    workers = children(process)
    assert len(workers) == 2
    process.kill()
    process.communicate()
    deadline = time.monotonic() + 20
    while any(map(runs, workers)):
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
@pytest.mark.process
def test_many_cases_in_one_process_need_no_more_memory_than_a_few(bud: Scene) -> None:
    """A run whose solver is not freed would take 30 kB."""
    code = """
import sys
from mpi4py import MPI
from fenics_yeast import Scene, simulate

def memory():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4

bud = Scene.from_toml(sys.argv[1])
taken = []
for i in range(120):
    simulate(bud.with_values({"growth.time": 30 + i, "run.end": 2}), comm=MPI.COMM_SELF)
    taken.append(memory())
print(taken[-1] - taken[59])
"""
    text = bud.with_values({"run.save": [2], "run.end": 2}).to_toml()
    done = subprocess.run(
        [sys.executable, "-c", code, text], capture_output=True, text=True, check=True
    )
    assert int(done.stdout) < 60 * 10


# Ranks ----------------------------------------------------------------------------------------


def test_ranks_share_the_cases(here: Path, mpirun: Callable[[str, int], Path]) -> None:
    script = f"""
import sys
from fenics_yeast.command.main import main
sys.argv[1:] = ["sweep", {str(here / "small.toml")!r}, "--vary", "growth.time=30:60:7", "--out",
                "sweep"]
main()
"""
    folder = mpirun(script, 2)
    rows = table(folder)
    assert [float(row["growth.time"]) for row in rows] == [30, 35, 40, 45, 50, 55, 60]
    assert {row["status"] for row in rows} == {"finished"}
    bud = Scene.from_toml(SCENE)
    for row in (rows[0], rows[-1]):  # run by one rank and by the other
        alone = simulate(bud.with_values({"growth.time": float(row["growth.time"])}))
        found = float(row["volume_ratio_at_8_min"])
        assert found == pytest.approx(alone.history.at(8).volume_ratio, abs=1e-12)
