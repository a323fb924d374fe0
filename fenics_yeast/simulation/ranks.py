"""Errors on several ranks: all ranks raise them, or all of them end."""

import sys
from collections.abc import Callable
from time import monotonic, sleep
from typing import Any, Self, TypeVar

from .result import EXIT_STATUS

T = TypeVar("T")

_PATIENCE = 10.0  # seconds; ranks that share an error raise it in the same step


class RootError(RuntimeError):
    """Rank 0 raised an error, which is this error's cause there; raised on all ranks at once."""


def on_root(comm: Any, act: Callable[[], T], expected: type[Exception] | None = None) -> T | None:
    """Act on rank 0; what it raises there is raised on all ranks. Collective.

    Parameters
    ----------
    comm
        MPI communicator.
    act
        Called on rank 0.
    expected
        Errors of this class are raised on all ranks as such, made from their message.

    Returns
    -------
    T or None
        What the action returned; None on the other ranks.

    Raises
    ------
    RootError
        If it raised another error.
    KeyboardInterrupt
        If it raised that.
    """
    value: T | None = None
    problem: BaseException | None = None
    if comm.rank == 0:
        try:
            value = act()
        except (Exception, KeyboardInterrupt) as error:
            problem = error
    name, words = (type(problem).__name__, str(problem)) if problem else ("", "")
    known = expected is not None and isinstance(problem, expected)
    if comm.size > 1:
        name, words, known = comm.bcast((name, words, known))
    if name == KeyboardInterrupt.__name__:
        raise KeyboardInterrupt from problem
    if expected is not None and known:
        raise expected(words) from problem
    if name:
        raise RootError(f"{name}: {words}") from problem
    return value


class OtherRanks:
    """The other ranks that share a wall; a context manager.

    An error on one rank would leave the others waiting forever in their next collective call.
    """

    def __init__(self, comm: Any) -> None:
        # A separate communicator: nothing here may match a call that the others wait in.
        self._comm: Any = comm.Dup() if comm.size > 1 else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._comm is not None:
            self._comm.Free()
            self._comm = None

    def wait(self, error: BaseException) -> None:
        """Wait until all ranks are here, each with its error; if some are missing, abort all."""
        if self._comm is None:
            return
        everyone, patience = self._comm.Ibarrier(), monotonic() + _PATIENCE
        while not everyone.Test():
            if monotonic() > patience:
                self._abort(error)
            sleep(0.01)

    def _abort(self, error: BaseException) -> None:
        words = f"{type(error).__name__}: {error}".replace("\n", " ")
        print(
            f"error: the run failed on rank {self._comm.rank} but not on all others: {words}; "
            "all ranks end; output so far is kept",
            file=sys.stderr,
            flush=True,
        )
        interrupted = isinstance(error, KeyboardInterrupt)
        self._comm.Abort(EXIT_STATUS["interrupted" if interrupted else "failed"])
