"""Scenes, and tests of scenes and geometry, load no dolfinx."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.ranks import environment
from support.scenes import BALLOON, BUD

TESTS = Path(__file__).parents[1]
CODE = """
import sys, pytest
status = pytest.main(["-p", "no:cacheprovider", *sys.argv[1:]])
print(int(status), *{"dolfinx", "ufl", "mpi4py", "petsc4py", "matplotlib"} & set(sys.modules))
"""


@pytest.mark.process
@pytest.mark.parametrize("room", ["scene", "geometry"])
def test_a_room_without_dolfinx_is_tested_without_it(room: str) -> None:
    command = [sys.executable, "-c", CODE, str(TESTS / room)]
    done = subprocess.run(
        command, cwd=TESTS.parent, env=environment(), capture_output=True, text=True
    )
    assert done.stdout.splitlines()[-1] == "0", done.stdout


@pytest.mark.process
def test_a_scene_loads_neither_dolfinx_nor_pint(tmp_path: Path) -> None:
    path, bud = tmp_path / "balloon.toml", tmp_path / "bud.toml"
    path.write_text(BALLOON)
    bud.write_text(BUD)
    code = (
        "import sys; from fenics_yeast.scene import Scene; [*map(Scene.load, sys.argv[1:])];"
        "print(*{'dolfinx', 'ufl', 'petsc4py', 'matplotlib', 'pint'} & set(sys.modules))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code, path, bud],
        cwd=TESTS.parent,
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout.strip() == ""
