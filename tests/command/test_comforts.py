"""Example scene, installation check and shell completion."""

import sys
from importlib import metadata
from importlib.resources import files
from pathlib import Path

import pytest
from support import ranks
from support.command import call, finish

from fenics_yeast import Scene
from fenics_yeast.command import info as installation
from fenics_yeast.command.completion import assignments


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
    assert again.exit_code == 2 and "already exists" in again.stderr
    assert place.read_text() == "precious"
    nowhere = call("new", str(tmp_path / "no" / "such" / "folder.toml"))
    assert nowhere.exit_code == 2 and nowhere.stderr.count("\n") == 1


def test_optional_settings_of_the_example_are_valid() -> None:
    example = files("fenics_yeast.command").joinpath("example.toml").read_text(encoding="utf-8")
    lines = [
        line.removeprefix("# ") if line.startswith("# ") and " = " in line else line
        for line in example.splitlines()
    ]
    # A key replaces the one above it.
    kept = {line.split(" = ")[0]: i for i, line in enumerate(lines) if " = " in line}
    text = "\n".join(
        line for i, line in enumerate(lines) if " = " not in line or kept[line.split(" = ")[0]] == i
    )
    scene = Scene.from_toml(text)
    assert scene.numerics.preset == "paper" and scene.numerics.thickness_points == 9
    assert scene.turgor.pressure != Scene.from_toml(example).turgor.pressure


@pytest.mark.process
def test_info_reports_a_working_installation() -> None:
    done = finish("info")
    assert (done.returncode, done.stderr) == (0, "")
    subjects = [line.split()[0] for line in done.stdout.splitlines()]
    assert {"fenics-yeast", "Python", "dolfinx", "MPI", "compiler", "form"} <= set(subjects)
    assert "PETSc" in done.stdout and "a form compiled" in done.stdout
    package = done.stdout.split("\n")[0].split(" in ")[1]
    assert Path(package, "scene", "scene.py").exists()


@pytest.mark.process
@pytest.mark.parametrize(
    ("missing", "advice"),
    [("compiler", "sudo apt install gcc"), ("dolfinx", "sudo apt install python3-dolfinx")],
)
def test_info_says_what_is_missing_and_what_to_do(
    tmp_path: Path, missing: str, advice: str
) -> None:
    environment = ranks.environment()
    if missing == "compiler":
        environment["CC"] = "/nowhere/cc"
    else:
        (tmp_path / "dolfinx.py").write_text("raise ImportError('there is none')")
        environment["PYTHONPATH"] = str(tmp_path)
    done = finish("info", env=environment)
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


@pytest.mark.process
def test_a_shell_gets_the_completion() -> None:
    environment = ranks.environment() | {
        "_FENICS_YEAST_COMPLETE": "complete_bash",
        "COMP_WORDS": "fenics-yeast run bud.toml --set growth.ti",
        "COMP_CWORD": "4",
    }
    done = finish(before="import sys; sys.argv[0] = 'fenics-yeast'", env=environment)
    assert done.stdout.split() == ["growth.time="]
