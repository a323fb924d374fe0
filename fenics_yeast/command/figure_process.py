"""The figures of a run, drawn by a second process that loads matplotlib during the run."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import IO, NoReturn, Self

from ..output import failed_figures
from ..scene import Scene
from ..simulation import Result
from .exits import is_rank


class FigureProcess:
    """Draws the figures of a run: a context manager, entered before MPI starts.

    A process that is forked here imports matplotlib meanwhile, and later draws what this process
    sends to it. Where a fork is unsafe or gains nothing (under mpirun, after MPI has started,
    beside threads, on one core), and if the second process is lost, this process draws.
    """

    def __init__(self) -> None:
        self._process: int | None = None
        self._pipes = ExitStack()

    def __enter__(self) -> Self:
        if _can_fork():
            with suppress(OSError):  # no process or file is left
                self._start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            os.kill(self._process, signal.SIGTERM)
            os.waitpid(self._process, 0)
            self._process = None
        with suppress(OSError):  # what it has not read
            self._pipes.close()

    def draw(self, path: Path, scene: Scene, result: Result) -> str | None:
        """Draw the figures and write ParaView surfaces; return a warning if that fails."""
        if self._process is not None:
            try:
                pickle.dump((path, scene, result), self._requests)
                self._requests.flush()
                failed = failed_figures(path, _surfaces(path, scene, result))
                answer: str | None = pickle.load(self._answers)
                return failed or answer
            except (OSError, EOFError, pickle.UnpicklingError):  # it was killed
                self.__exit__()
        parts = _surfaces(path, scene, result), _figures(path, scene, result)
        warnings = [failed_figures(path, part) for part in parts]
        return warnings[0] or warnings[1]

    def _start(self) -> None:
        with ExitStack() as stack:
            requested, self._requests = _pipe(stack)
            self._answers, answers = _pipe(stack)
            process = os.fork()
            if process == 0:
                try:
                    self._requests.close()  # otherwise it would not notice that the command ended
                    _serve(requested, answers)
                finally:
                    os._exit(0)
            self._process = process
            requested.close()
            answers.close()
            self._pipes = stack.pop_all()


def _can_fork() -> bool:
    alone = not is_rank() and "mpi4py.MPI" not in sys.modules and threading.active_count() == 1
    return alone and len(os.sched_getaffinity(0)) > 1


def _pipe(stack: ExitStack) -> tuple[IO[bytes], IO[bytes]]:
    """Return the end to read from and the end to write to."""
    ends = os.pipe()
    return stack.enter_context(open(ends[0], "rb")), stack.enter_context(open(ends[1], "wb"))


def _serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Draw on request until the command ends this process, or has ended itself."""
    for number in (signal.SIGINT, signal.SIGHUP):  # the command decides what they mean
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    import matplotlib.backends.backend_agg
    import matplotlib.figure  # noqa: F401

    from .. import figures  # noqa: F401

    while True:
        path, scene, result = pickle.load(requests)
        pickle.dump(failed_figures(path, _figures(path, scene, result)), answers)
        answers.flush()


def _leave(*_: object) -> NoReturn:
    """Leave no file half written."""
    raise SystemExit


def _surfaces(path: Path, scene: Scene, result: Result) -> Callable[[], object]:
    def write() -> None:
        from ..figures import write_surfaces

        if len(result.profiles):
            write_surfaces(path, scene, result.profiles)

    return write


def _figures(path: Path, scene: Scene, result: Result) -> Callable[[], object]:
    def make() -> None:
        from ..figures import draw

        parts = result.history, result.profiles, result.status, result.error_bars, result.mode
        draw(path, scene, *parts)

    return make
