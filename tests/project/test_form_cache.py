"""The cache of compiled forms survives killed and simultaneous processes."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from support import ranks
from support.command import MAIN
from support.scenes import BALLOON

from fenics_yeast import _form_cache

# Two modules: a space's element (with dolfinx 0.5) and a form.
CODE = """
import numpy as np, ufl
from fenics_yeast import _dolfinx as dx
mesh = dx.interval_mesh(dx.MPI.COMM_WORLD, np.array([0.0, 1.0, 3.0]))
f = dx.fem.Function(dx.quadrature_space(mesh, 1, 1))
f.x.array[:] = 2.0
form = dx.compile_form(f[0] ** 2 * ufl.dx(metadata={"quadrature_degree": 1}))
print(dx.assemble_scalar(form, mesh.comm))
"""
ANSWER = ("12.0\n", "")


def start(cache: Path | str, code: str = CODE, **more: str) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    environment = ranks.environment() | {"XDG_CACHE_HOME": str(cache)} | more
    command = [sys.executable, "-c", code]
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=environment)


def unfinished(cache: Path) -> set[Path]:
    return {
        path for path in cache.glob("fenics-yeast/*/*/*.c") if not Path(f"{path}.cached").exists()
    }


@pytest.mark.process
def test_a_run_after_a_killed_compilation_does_not_wait(tmp_path: Path) -> None:
    process = start(tmp_path)
    while not unfinished(tmp_path):
        assert process.poll() is None
        time.sleep(0.002)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    process.communicate()
    left = unfinished(tmp_path)
    began = time.monotonic()
    assert start(tmp_path).communicate() == ANSWER
    assert left and time.monotonic() - began < 9  # FFCx by itself would wait for 10 s
    assert not unfinished(tmp_path)


@pytest.mark.process
def test_a_form_without_its_library_is_compiled_again(tmp_path: Path) -> None:
    assert start(tmp_path).communicate() == ANSWER
    for library in tmp_path.glob("fenics-yeast/*/*/*.so"):
        library.unlink()
    assert start(tmp_path).communicate() == ANSWER


@pytest.mark.process
@pytest.mark.parametrize("kept", [0.0, 0.3, 0.9])
def test_a_damaged_library_is_compiled_again(tmp_path: Path, kept: float) -> None:
    """Cut short, as by a full disk: to load it would end the process by a bus error."""
    assert start(tmp_path).communicate() == ANSWER
    libraries = list(tmp_path.glob("fenics-yeast/*/*/*.so"))
    for library in libraries:
        stat = library.stat()
        assert _form_cache.is_whole(library, stat.st_size, stat.st_mtime_ns)
        os.truncate(library, int(kept * stat.st_size))
    info = [sys.executable, "-m", "fenics_yeast", "info"]
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    said = subprocess.run(info, env=environment, capture_output=True, text=True, check=True).stdout
    assert f"{len(libraries)} cut short, which the next run replaces" in said
    assert start(tmp_path).communicate() == ANSWER
    assert all(library.stat().st_size > 1000 for library in libraries)


@pytest.mark.process
def test_info_names_a_library_that_cannot_be_loaded(tmp_path: Path) -> None:
    """As long as it was, with zeros in place of its beginning."""
    assert start(tmp_path).communicate() == ANSWER
    library = next(tmp_path.glob("fenics-yeast/*/*/*.so"))
    with open(library, "r+b") as file:
        file.seek(64)
        file.write(bytes(2000))
    info = [sys.executable, "-m", "fenics_yeast", "info"]
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    done = subprocess.run(info, env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert f"{library} is damaged; run: rm {library}" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr
    library.unlink()
    assert start(tmp_path).communicate() == ANSWER


@pytest.mark.process
def test_simultaneous_processes_compile_once(tmp_path: Path) -> None:
    processes = [start(tmp_path) for _ in range(3)]
    assert [process.communicate() for process in processes] == [ANSWER] * 3
    assert not unfinished(tmp_path)
    assert not list(tmp_path.glob("fenics-yeast/*/*/*.failed"))


# Newton step and rate of growth, resultants through growth (two), residual, tangent, volume,
# its gradient, consistent tangent, stage force, dissipation; fields of profiles.
MODULES = 12
GROWTH = """
import ufl
from fenics_yeast import Scene, simulate
scene = Scene.from_toml('''
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40, bending = false }
turgor = { pressure = 0.2 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 45 }
run = { end = 0.1 }
numerics = { order = 1 }
''')
for _ in range(2):
    simulate(scene)
    ufl.variable(ufl.as_ufl(1.0))  # UFL counts these
"""


@pytest.mark.slow
@pytest.mark.process
def test_forms_of_a_growing_wall_are_compiled_once(tmp_path: Path) -> None:
    """In the same process and in the next one."""
    compiled = []
    for code in (GROWTH.replace("range(2)", "range(1)"), GROWTH):
        assert start(tmp_path, code).communicate() == ("", "")
        compiled.append(sorted(tmp_path.glob("fenics-yeast/*/*/*.so")))
    assert len(compiled[0]) > 5 and compiled[0] == compiled[1]
    # To find a form, its directory is listed: the time must not grow with the number of forms.
    assert max(Counter(path.parent for path in compiled[0]).values()) <= 3


@pytest.mark.slow
@pytest.mark.process
def test_forms_compiled_at_once_are_those_compiled_one_by_one(tmp_path: Path) -> None:
    """Dolfinx 0.5 compiles the elements of spaces too; other modules are forms and expressions."""
    code = GROWTH.replace("range(2)", "range(1)")
    names = []
    for cores in (2, 1):
        before = f"import os; os.sched_getaffinity = lambda _: set(range({cores}))\n"
        cache = tmp_path / str(cores)
        cache.mkdir()
        assert start(cache, before + code).communicate() == ("", "")
        assert not unfinished(cache)
        names.append({path.name for path in cache.glob("fenics-yeast/*/*/*.so")})
    assert names[0] == names[1]
    assert len([name for name in names[0] if "elements" not in name]) == MODULES


@pytest.mark.slow
@pytest.mark.process
def test_an_interrupted_compilation_leaves_no_process_and_no_harm(tmp_path: Path) -> None:
    before = "import os, signal; os.sched_getaffinity = lambda _: {0, 1}\n"
    # Jobs in the background of a script ignore it.
    before += "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    process = start(tmp_path, before + GROWTH)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    while len(workers := children.read_text().split()) < 2:
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in process.communicate(timeout=20)[1]
    assert not any(Path(f"/proc/{worker}").exists() for worker in workers)
    assert start(tmp_path, GROWTH).communicate() == ("", "")
    assert not unfinished(tmp_path)


@pytest.mark.process
def test_ranks_compile_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mpirun: Callable[[str, int], Path]
) -> None:
    """Under the names that a run on one rank looks for."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    mpirun(CODE, 2)
    compiled = sorted(tmp_path.glob("fenics-yeast/*/*/*.so"))
    assert compiled
    assert start(tmp_path).communicate() == ANSWER
    assert sorted(tmp_path.glob("fenics-yeast/*/*/*.so")) == compiled


@pytest.mark.process
def test_a_cache_that_cannot_be_written_is_replaced_for_the_run() -> None:
    output, errors = start("/proc/nowhere").communicate()
    assert output == ANSWER[0]
    assert errors.startswith("warning: the cache of compiled forms, /proc/nowhere, cannot be used")
    assert "XDG_CACHE_HOME" in errors and errors.count("\n") == 1


def test_the_cache_of_another_user_is_not_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    mine = _form_cache.folder.__wrapped__()
    assert mine.is_relative_to(tmp_path) and capsys.readouterr().err == ""
    monkeypatch.setattr(os, "geteuid", lambda: mine.stat().st_uid + 1)
    other = _form_cache.folder.__wrapped__()
    assert not other.is_relative_to(tmp_path / "fenics-yeast")
    assert "it belongs to another user" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.process
def test_without_a_compiler_the_command_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "static.toml").write_text(BALLOON)
    code = (
        f"import os; os.chdir({str(tmp_path)!r}); import sys; sys.argv[1:] = ['run', 'static.toml']"
        f"\n{MAIN}"
    )
    process = start(tmp_path, code, CC="no-such-compiler")
    output, errors = process.communicate()
    assert (process.returncode, output) == (1, "")
    assert errors.startswith("error: the C compiler no-such-compiler")
    assert "sudo apt install gcc" in errors and errors.count("\n") == 1
    # Once there is one, nothing is left in the way.
    process = start(tmp_path, code)
    assert process.communicate()[1] == ""
    assert process.returncode == 0
