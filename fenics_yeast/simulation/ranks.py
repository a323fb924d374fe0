"""Errors on several ranks: met by all of them, or else the end of all of them."""

from __future__ import annotations

import sys
from time import monotonic, sleep
from typing import Any, Self

_PATIENCE = 10.0  # seconds; ranks that meet an error meet it at the same step
_GAVE_UP, _INTERRUPTED = 4, 130


class OtherRanks:
    """The other ranks that share a wall; a context manager.

    An error on one rank alone would leave the others waiting for it in their next collective
    call, without end.
    """

    def __init__(self, comm: Any) -> None:
        # Of its own: nothing here must meet what the others wait for.
        self._comm: Any = comm.Dup() if comm.size > 1 else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._comm is not None:
            self._comm.Free()
            self._comm = None

    def wait(self, error: BaseException) -> None:
        """Wait until all ranks are here, each with its error; if some do not come, end them all."""
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
            f"error: the run broke on rank {self._comm.rank} alone, and ends on all: {words}; "
            "what it has written stays",
            file=sys.stderr,
            flush=True,
        )
        self._comm.Abort(_INTERRUPTED if isinstance(error, KeyboardInterrupt) else _GAVE_UP)
