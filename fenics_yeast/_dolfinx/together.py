"""Compile all forms that a function needs at once, in as many processes as there are cores."""

import gc
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from .._mpi import ALONE

T = TypeVar("T")

_PATIENCE = 300.0  # s for all forms; one takes some seconds
_LOOK = 0.01  # s between two looks at the processes


class FirstCompilation(Exception):
    """A form was not in the cache: others may not be either."""


class Planned:
    """Stands for a form or an expression that is still to be compiled; its values are 0."""


@dataclass
class Plan:
    """What is to be compiled."""

    sources: list[Any] = field(default_factory=list)

    def add(self, source: Any) -> Planned:
        """Add a form, or an expression with its points."""
        self.sources.append(source)
        return Planned()


# What this thread does about forms: None compiles each; True stops at the first compilation.
_purpose: ContextVar[Plan | bool | None] = ContextVar("purpose", default=None)


def plan() -> Plan | None:
    """Return the plan that forms are to be added to instead of being compiled."""
    purpose = _purpose.get()
    return purpose if isinstance(purpose, Plan) else None


@contextmanager
def watched(place: Path) -> Iterator[None]:
    """Raise `FirstCompilation` if something is compiled into a directory, where that is asked."""
    if _purpose.get() is not True:
        yield
        return
    before = place.stat().st_mtime_ns
    yield
    if place.stat().st_mtime_ns != before:
        raise FirstCompilation


def together(make: Callable[[], T], compile_one: Callable[[Any], object], comm: Any) -> T:
    """Return what a function makes. If forms are missing in the cache, compile them at once.

    The function is called again after the first compilation, to find out which other forms it
    needs, and once more to use them. Processes are forked, which is unsafe under mpirun: there,
    and on one core, forms are compiled one after the other.

    Parameters
    ----------
    make
        Compiles forms, and can be called repeatedly.
    compile_one
        Compiles a source into the cache.
    comm
        Communicator of the forms.
    """
    cores = len(os.sched_getaffinity(0))
    if comm.size > 1 or not ALONE or cores == 1 or _purpose.get() is not None:
        return make()
    with suppress(FirstCompilation), _purpose_of(True):
        return make()
    planned = Plan()
    with suppress(Exception), _purpose_of(planned):  # an error will occur again
        make()
    _compile(planned.sources, compile_one, cores)
    return make()


@contextmanager
def _purpose_of(purpose: Plan | bool) -> Iterator[None]:
    token = _purpose.set(purpose)
    try:
        yield
    finally:
        _purpose.reset(token)


def _compile(sources: list[Any], compile_one: Callable[[Any], object], cores: int) -> None:
    """Compile sources in several processes; what fails is left out."""
    numbers, queue = os.pipe()  # each process takes the next number when it is free
    os.write(queue, bytes(range(len(sources))))
    os.close(queue)
    deadline = time.monotonic() + _PATIENCE
    processes: set[int] = set()
    try:
        for _ in range(min(cores, len(sources))):
            process = os.fork()
            if process == 0:
                try:
                    _work(numbers, sources, compile_one)
                finally:
                    os._exit(0)
            processes.add(process)
        while processes and time.monotonic() < deadline:
            time.sleep(_LOOK)
            for process in tuple(processes):
                if os.waitpid(process, os.WNOHANG)[0] == process:
                    processes.discard(process)
    finally:
        os.close(numbers)
        for process in processes:  # of an interrupted run, with their C compilers
            for kill in (os.killpg, os.kill):
                with suppress(ProcessLookupError):
                    kill(process, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(process, 0)


def _work(numbers: int, sources: list[Any], compile_one: Callable[[Any], object]) -> None:
    """Compile sources until none is left, in a forked process."""
    os.setpgid(0, 0)  # Ctrl-C reaches only the run, which ends this process
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    silence = os.open(os.devnull, os.O_WRONLY)
    for output in (1, 2):  # errors occur again in the run, which reports them
        os.dup2(silence, output)
    gc.disable()
    while taken := os.read(numbers, 1):
        with suppress(Exception):
            compile_one(sources[taken[0]])
