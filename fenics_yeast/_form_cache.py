"""The directories of compiled forms, safe for killed and simultaneous processes.

FFCx marks a compilation by an empty C file and waits for the process that left it, which may be
dead. Here one process compiles a form at a time, under a lock that ends with it, in a directory of
our own: anything unfinished while the lock is held was abandoned, and is compiled again. FFCx lists
a directory to find a form there, so that each form has its own, or shares it with few.
"""

import atexit
import fcntl
import hashlib
import os
import shutil
import sys
import sysconfig
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

_LOCK = "lock"


class CompilerError(RuntimeError):
    """Forms cannot be compiled on this machine; the one-line message says what to do."""


@cache
def folder() -> Path:
    """Return the directory for this Python and machine, or a temporary one if it is unusable."""
    directory = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    try:
        base = Path(directory).expanduser()
        place = Path(base, "fenics-yeast", f"forms-{sysconfig.get_config_var('SOABI')}").absolute()
        place.mkdir(parents=True, exist_ok=True)
        if place.stat().st_uid != os.geteuid():  # code is loaded from it
            raise PermissionError(0, "it belongs to another user")
        with open(place / _LOCK, "a"):
            return place
    except (OSError, RuntimeError) as error:  # RuntimeError: no home directory
        problem = getattr(error, "strerror", None) or str(error)
    place = temporary("forms")
    print(
        f"warning: the cache of compiled forms, {directory}, cannot be used ({problem}): "
        "each run compiles its forms again; set XDG_CACHE_HOME to a directory that can be written",
        file=sys.stderr,
    )
    return place


def place_of(identity: str) -> Path:
    """Return the directory of forms of an identity, which is the same in all processes."""
    return folder() / hashlib.sha1(identity.encode(), usedforsecurity=False).hexdigest()


def temporary(name: str) -> Path:
    """Return a directory private to this process and user, removed at its end."""
    place = Path(tempfile.mkdtemp(prefix=f"fenics-yeast-{name}-"))
    atexit.register(shutil.rmtree, place, ignore_errors=True)
    return place


@contextmanager
def held(place: Path) -> Iterator[None]:
    """Hold the lock of a directory of forms; remove unfinished compilations."""
    place.mkdir(exist_ok=True)
    with open(place / _LOCK, "a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX)  # ends with the process, however that ends
        except OSError:  # a file system without locks
            pass
        else:
            _remove_unfinished(place)
        yield


def _remove_unfinished(place: Path) -> None:
    """Remove what an abandoned compilation, a full disk or a damaged one has left."""
    with os.scandir(place) as entries:
        sizes = {entry.name: (entry.stat().st_size, entry.stat().st_mtime_ns) for entry in entries}
    suffix = f".{sysconfig.get_config_var('SOABI')}.so"
    for name in sizes:
        module, extension = os.path.splitext(name)
        library = module + suffix
        whole = library in sizes and is_whole(place / library, *sizes[library])
        if extension == ".c" and not (whole and f"{name}.cached" in sizes):
            for rest in (name, f"{name}.cached", library):
                (place / rest).unlink(missing_ok=True)


@cache
def is_whole(library: Path, size: int, changed: int) -> bool:
    """Whether a shared library of a size in bytes, last changed at a time in ns, is complete.

    To load one that was cut short would end the process. An ELF file ends with the table to which
    its header points.
    """
    with open(library, "rb") as file:
        header = file.read(64)
    if len(header) < 64 or header[:4] != b"\x7fELF":
        return False
    start = int.from_bytes(header[40:48], sys.byteorder)
    entry, number = (int.from_bytes(header[i : i + 2], sys.byteorder) for i in (58, 60))
    return 0 < start + entry * number <= size


def compiler_error(place: Path, error: Exception) -> CompilerError:
    """Return an error that says why a compilation failed and what to do."""
    compiler = (os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc").split()[0]
    if shutil.which(compiler) is None:
        text = f"the C compiler {compiler}, which FEniCSx needs at run time, cannot be found"
        return CompilerError(f"{text}; on Debian: sudo apt install gcc libc6-dev")
    if not Path(sysconfig.get_path("include"), "Python.h").exists():
        text = "Python.h, which FEniCSx needs at run time, is missing"
        return CompilerError(f"{text}; on Debian: sudo apt install python3-dev")
    reason = " ".join(str(error).split())
    return CompilerError(f"forms cannot be compiled in {place}: {reason}")
