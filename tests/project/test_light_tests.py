"""Tests of scenes and geometry run where there is no dolfinx."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.ranks import environment

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
