"""The work of `fenics-yeast info`: test the installation, and say how to fix it."""

import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# Run in another process, which may crash; it compiles into an empty directory.
_TRIAL = """
import json, sys, time
from fenics_yeast import _dolfinx as dx
import dolfinx, numpy, ufl
began = time.perf_counter()
mesh = dx.interval_mesh(dx.MPI.COMM_SELF, numpy.array([0.0, 1.0]))
one = dx.fem.Constant(mesh, 1.0)
length = dx.assemble_scalar(dx.compile_form(one * ufl.dx(mesh)), mesh.comm)
assert abs(length - 1) < 1e-12, length
print(json.dumps({
    "seconds": time.perf_counter() - began,
    "dolfinx": dolfinx.__version__,
    "petsc": ".".join(map(str, dx.PETSc.Sys.getVersion())),
    "mpi": dx.MPI.Get_library_version().splitlines()[0].split(",")[0].strip(),
}))
"""
# Loads the compiled forms of a directory, also in another process: a damaged one may end it.
_LOADING = """
import ctypes, sys
from pathlib import Path
for path in sorted(Path(sys.argv[1]).rglob("*.so")):
    print(path, flush=True)
    ctypes.CDLL(str(path))
print("all", flush=True)
"""
_PATIENCE = 300  # seconds for the trial
_NAME = re.compile(r"[\w.-]+")  # of a library, before its version


@dataclass(frozen=True)
class Finding:
    """Result of one check.

    Attributes
    ----------
    subject, text
        What was checked; what was found, or how to fix it.
    works
        Whether a run would work.
    """

    subject: str
    text: str
    works: bool = True


def examine() -> Iterator[Finding]:
    """Check everything that a run needs; import dolfinx and compile a form in another process."""
    from importlib.metadata import version

    yield Finding("fenics-yeast", f"{version('fenics-yeast')} in {Path(__file__).parents[1]}")
    yield Finding("Python", f"{platform.python_version()}, {sys.executable}")
    yield _libraries()
    yield _cache()
    yield from _trial()
    mpirun = shutil.which("mpirun")
    yield Finding("mpirun", mpirun or "not found; needed only for runs on several ranks")
    ffmpeg = shutil.which("ffmpeg")
    yield Finding("ffmpeg", ffmpeg or "not found; animations are written only as GIF")


def _libraries() -> Finding:
    """Check the packages that pip installs."""
    from importlib.metadata import PackageNotFoundError, requires, version

    found, missing = [], []
    for line in requires("fenics-yeast") or []:
        name = _NAME.match(line)
        if name is None or "extra ==" in line:
            continue
        try:
            found.append((name[0], version(name[0])))
        except PackageNotFoundError:
            missing.append(line)
    if missing:
        # dolfinx was built for the installed NumPy, which pip must not replace.
        held = [f"numpy=={number}" for name, number in found if name == "numpy"]
        advice = shlex.join([sys.executable, "-m", "pip", "install", *missing, *held])
        return Finding("libraries", f"missing: {', '.join(missing)}; run: {advice}", works=False)
    return Finding("libraries", ", ".join(map(" ".join, found)))


def _cache() -> Finding:
    """Describe the cache of compiled forms; an unusable one only costs time."""
    from .. import _form_cache

    place = _form_cache.folder()
    files = {path: path.stat() for path in place.rglob("*.so") if path.is_file()}
    size = sum(stat.st_size for stat in files.values()) / 1e6
    text = f"{place}, {len(files)} compiled forms, {size:.1f} MB"
    damaged = sum(
        not _form_cache.is_whole(path, stat.st_size, stat.st_mtime_ns)
        for path, stat in files.items()
    )
    if damaged:
        return Finding("form cache", f"{text}; {damaged} cut short, which the next run replaces")
    done = subprocess.run(
        [sys.executable, "-c", _LOADING, str(place)], capture_output=True, text=True, check=False
    )
    last = done.stdout.splitlines()[-1] if done.stdout else str(place)
    if done.returncode == 0 and last == "all":
        return Finding("form cache", text)
    remedy = f"{shlex.quote(last)} is damaged; run: rm {shlex.quote(last)}"
    return Finding("form cache", remedy, works=False)


def _trial() -> Iterator[Finding]:
    found, problem = _try_out()
    if found is None:
        yield Finding("dolfinx", problem, works=False)
        return
    yield Finding("dolfinx", f"{found['dolfinx']}, PETSc {found['petsc']}")
    yield Finding("MPI", found["mpi"])
    yield Finding("compiler", f"a form compiled and evaluated in {found['seconds']:.1f} s")


def _try_out() -> tuple[dict[str, Any] | None, str]:
    """Return the findings of the trial, or the last line of its error."""
    with tempfile.TemporaryDirectory(prefix="fenics-yeast-") as folder:
        environment = os.environ | {"XDG_CACHE_HOME": folder}
        try:
            done = subprocess.run(
                [sys.executable, "-c", _TRIAL], env=environment, capture_output=True, text=True,
                timeout=_PATIENCE, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return (
                None,
                f"compiling a form takes more than {_PATIENCE} s; try again on an idle machine",
            )
    if done.returncode == 0:
        return json.loads(done.stdout.splitlines()[-1]), ""
    lines = done.stderr.strip().splitlines() or [
        f"importing it ended the process with status {done.returncode}; reinstall dolfinx"
    ]
    last = lines[-1].partition(": ")
    return None, last[2] or last[0]
