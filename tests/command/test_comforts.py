"""Small comforts: a scene to begin with, what is installed, completion, the time that is left."""

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from support.command import COMMAND, call

from fenics_yeast import Scene, simulate
from fenics_yeast.command import info as installation
from fenics_yeast.command.completion import assignments
from fenics_yeast.command.example import EXAMPLE
from fenics_yeast.command.time_left import TimeLeft, duration
from fenics_yeast.simulation.result import Profile, Row


def test_new_writes_a_scene_and_never_over_one(tmp_path: Path) -> None:
    place = tmp_path / "my bud.toml"
    result = call("new", str(place))
    assert result.exit_code == 0 and f"fenics-yeast run '{place}'" in result.stdout
    documented = Path(__file__).parents[2] / "demos" / "scenes" / "bud.toml"
    scene, known = Scene.load(place), Scene.load(documented)
    for table in ("cell", "wall", "turgor", "growth"):
        assert getattr(scene, table) == getattr(known, table)
    place.write_text("precious")
    again = call("new", str(place))
    assert again.exit_code == 2 and "exists already" in again.stderr
    assert place.read_text() == "precious"
    nowhere = call("new", str(tmp_path / "no" / "such" / "folder.toml"))
    assert nowhere.exit_code == 2 and nowhere.stderr.count("\n") == 1


def test_what_the_example_only_mentions_is_valid_too() -> None:
    lines = [
        line.removeprefix("# ") if line.startswith("# ") and " = " in line else line
        for line in EXAMPLE.splitlines()
    ]
    # A key in place of the one above it.
    kept = {line.split(" = ")[0]: i for i, line in enumerate(lines) if " = " in line}
    text = "\n".join(
        line for i, line in enumerate(lines) if " = " not in line or kept[line.split(" = ")[0]] == i
    )
    scene = Scene.from_toml(text)
    assert scene.numerics.preset == "paper" and scene.numerics.thickness_points == 5
    assert scene.turgor.pressure != Scene.from_toml(EXAMPLE).turgor.pressure


def test_info_says_that_all_is_well() -> None:
    done = subprocess.run([*COMMAND, "info"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    subjects = [line.split()[0] for line in done.stdout.splitlines()]
    assert {"fenics-yeast", "Python", "dolfinx", "MPI", "compiler", "form"} <= set(subjects)
    assert "PETSc" in done.stdout and "a form compiled" in done.stdout


@pytest.mark.parametrize(
    ("missing", "advice"),
    [("compiler", "sudo apt install gcc"), ("dolfinx", "sudo apt install python3-dolfinx")],
)
def test_info_says_what_is_missing_and_what_to_do(
    tmp_path: Path, missing: str, advice: str
) -> None:
    environment = dict(os.environ)
    if missing == "compiler":
        environment["CC"] = "/nowhere/cc"
    else:
        (tmp_path / "dolfinx.py").write_text("raise ImportError('there is none')")
        environment["PYTHONPATH"] = str(tmp_path)
    done = subprocess.run([*COMMAND, "info"], capture_output=True, text=True, env=environment)
    assert done.returncode == 1
    (line,) = [line for line in done.stdout.splitlines() if "error: " in line]
    assert line.startswith("dolfinx") and advice in line
    assert "works." not in done.stdout


def test_info_names_the_libraries_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        if name in ("meshio", "pint"):
            raise metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(metadata, "version", version)
    monkeypatch.setattr(sys, "executable", "/my cells/python")
    finding = installation._libraries()
    assert not finding.works
    assert finding.text.endswith("run: '/my cells/python' -m pip install meshio pint numpy==1.0")


def test_keys_and_choices_are_completed() -> None:
    found = dict(assignments("growth.t"))
    assert set(found) == {"growth.threshold=", "growth.time="}
    assert "t_grw" in found["growth.time="]
    assert dict(assignments("growth.zone.h")).keys() == {"growth.zone.half_angle="}
    assert [text for text, _ in assignments("numerics.preset=p")] == ["numerics.preset=paper"]
    assert assignments("no.such=") == assignments("nothing") == []
    for text, _ in assignments(""):
        assert text.endswith("=")


def test_a_shell_gets_the_completion() -> None:
    environment = os.environ | {
        "_FENICS_YEAST_COMPLETE": "complete_bash",
        "COMP_WORDS": "fenics-yeast run bud.toml --set growth.ti",
        "COMP_CWORD": "4",
    }
    code = "import sys; sys.argv[0] = 'fenics-yeast'; "
    code += "from fenics_yeast.command.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment
    )
    assert done.stdout.split() == ["growth.time="]


class _Clock:
    """An observer that asks for the time left after each step, each of which takes a second."""

    def __init__(self, end: float) -> None:
        self._left, self.estimates = TimeLeft(end), []

    def accepted(self, row: Row) -> None:
        self.estimates.append(self._left.accepted(row.time_min, float(len(self.estimates))))

    def saved(self, profile: Profile) -> None:
        pass


def test_the_time_left_is_believable_where_steps_follow_the_growth(cell_scene: Scene) -> None:
    """Steps of this run lengthen sevenfold, and then shorten again."""
    numerics = {"tolerance": 1e-6, "integrator": "sdirk2", "elements": 16}
    scene = cell_scene.with_values({"numerics": numerics})
    clock = _Clock(90.0)
    simulate(scene, observer=clock)
    total = len(clock.estimates) - 1
    assert total > 500
    for done in range(total // 20, total - total // 20):  # within three times, either way
        estimate = clock.estimates[done]
        assert estimate is not None
        assert 1 / 3 < estimate / (total - done) < 3


def test_the_time_left_of_equal_steps_is_exact() -> None:
    left = TimeLeft(100.0)
    estimates = [left.accepted(time, 3.0 * time) for time in range(100)]
    assert estimates[:8] == [None] * 8
    for time in range(20, 100):
        estimate = estimates[time]
        assert estimate == pytest.approx(3.0 * (100 - time), rel=0.05)
    assert (duration(3.2), duration(600), duration(9000)) == ("3 s", "10 min", "2.5 h")
