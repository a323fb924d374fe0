"""The first minutes: what `make` says on machines that lack something, and that it sets up."""

import os
import subprocess
import sys
from pathlib import Path
from shutil import copy, which

import pytest

TOP = Path(__file__).parents[2]
MAKE = which("make")
TOOLS = ("bash", "env", "grep", "mktemp", "rm", "sed", "tail", "uname")
PACKAGES = "python3-dolfinx python3-venv"
DEBIAN_DOLFINX = list(Path("/var/lib/dpkg/info").glob("python3-dolfinx*.list"))

pytestmark = [
    pytest.mark.skipif(MAKE is None, reason="no make here"),
    pytest.mark.skipif(not (TOP / "Makefile").exists(), reason="not in a checkout"),
]


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A folder of programs, with no Debian package and no right of root."""
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in TOOLS:
        place = which(name)
        assert place is not None, f"{name} belongs to every Debian"
        (programs / name).symlink_to(place)
    program(programs, "dpkg-query", "exit 1")
    program(programs, "id", "echo 1000")
    return programs


def program(folder: Path, name: str, text: str) -> None:
    place = folder / name
    place.write_text(f"#!/bin/sh\n{text}\n")
    place.chmod(0o755)


def refused(machine: Path, target: str = "debian-packages") -> str:
    """What make says where it cannot go on."""
    assert MAKE is not None
    done = subprocess.run(
        [MAKE, "--no-print-directory", target],
        cwd=TOP, capture_output=True, text=True, env={"PATH": str(machine), "LANG": "C"},
    )  # fmt: skip
    assert done.returncode == 2
    (line,) = (line for line in done.stderr.splitlines() if line.startswith("error: "))
    return line


@pytest.mark.process
def test_without_debian(machine: Path) -> None:
    assert f"needs Debian 12 or 13 with {PACKAGES}" in refused(machine)


@pytest.mark.process
def test_without_sudo(machine: Path) -> None:
    program(machine, "apt-get", "exit 0")
    line = refused(machine)
    assert "sudo are missing" in line and f"apt-get install {PACKAGES}" in line


@pytest.mark.process
def test_without_a_mirror(machine: Path) -> None:
    """As root; the last words of apt come before ours."""
    program(machine, "id", "echo 0")
    program(machine, "apt-get", "echo Temporary failure resolving the mirror >&2; exit 100")
    line = refused(machine)
    assert "could not be installed" in line and f"apt-get install {PACKAGES}" in line


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.skipif(not DEBIAN_DOLFINX, reason="dolfinx is not that of Debian")
def test_a_network_without_pypi_is_reported_and_does_no_harm(tmp_path: Path) -> None:
    """In a folder with a space, with another python3 first on PATH and a NumPy in the home."""
    assert MAKE is not None
    clone, home = tmp_path / "my clone", tmp_path / "home"
    (clone / "fenics_yeast").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", "README.md", "LICENSE"):
        copy(TOP / name, clone)
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    numpy = home / ".local" / "lib" / f"python{version}" / "site-packages" / "numpy"
    numpy.mkdir(parents=True)
    (numpy / "__init__.py").write_text("raise ImportError('an old NumPy')")
    program(tmp_path, "python3", "exit 1")
    nowhere = "http://127.0.0.1:9"
    offline = {
        "HOME": str(home), "LANG": "C", "PATH": f"{tmp_path}:{os.environ['PATH']}",
        "PIP_CONFIG_FILE": os.devnull, "PIP_INDEX_URL": nowhere, "PIP_RETRIES": "0",
    }  # fmt: skip
    done = subprocess.run(
        [MAKE, "setup"], cwd=clone, capture_output=True, text=True, env=offline, timeout=300
    )
    assert done.returncode == 2
    assert "error: pip could not install the libraries; check that PyPI" in done.stderr
    assert not (clone / ".venv" / ".installed").exists()
    # NumPy is that of Debian, with which dolfinx was built, without make's settings too.
    python = clone / ".venv" / "bin" / "python"
    code = "import numpy; print(numpy.__file__)"
    environment = {"HOME": str(home), "PATH": os.environ["PATH"]}
    found = subprocess.run(
        [python, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert found.stdout.startswith("/usr/lib/python3")
