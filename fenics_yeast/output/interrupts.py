"""Ctrl-C and similar signals: the first ends the run, further ones do not harm its results.

On several ranks, an interrupt waits for the end of a step.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, Self

if TYPE_CHECKING:
    from ..simulation import Profile, Row

# Ctrl-C; the end of a batch job; the end of a connection.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_Handler = Callable[[int, FrameType | None], Any]


def interrupt(*_: object) -> NoReturn:
    """Handle a signal like Ctrl-C."""
    raise KeyboardInterrupt


class Interrupts:
    """The signals that interrupt a run: a context manager, and an `Observer` of the run.

    On one rank, the first signal calls its previous handler at once. On several, it waits for the
    end of a step: the launcher signals each rank at a different moment, and a KeyboardInterrupt
    there would leave other ranks waiting. Rank 0 therefore raises it as an observer.

    Signals after a KeyboardInterrupt, or after `hold`, wait for `release`, so that a second
    Ctrl-C, or a repeated signal of a batch system, does not lose the results.

    Parameters
    ----------
    comm
        Ranks of the run.

    Attributes
    ----------
    acted
        Whether a KeyboardInterrupt was raised. PETSc may turn it into an error of its own.
    """

    def __init__(self, comm: Any) -> None:
        self._at_steps = comm.size > 1
        self._before: dict[int, _Handler] = {}
        self._held = self._heard = self.acted = False

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in map(int, SIGNALS):
                handler = signal.getsignal(number)
                if callable(handler):  # others are ignored, as under nohup, or end the process
                    self._before[number] = handler
                elif self._at_steps and handler is signal.SIG_DFL:
                    self._before[number] = interrupt
            for number in self._before:
                signal.signal(number, self._hear)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def accepted(self, row: Row) -> None:
        """Raise a KeyboardInterrupt if a rank was signalled, or if PETSc swallowed one."""
        if self.acted or (self._at_steps and self._heard):
            self._heard = False
            raise KeyboardInterrupt

    def saved(self, profile: Profile) -> None:
        """Ignore profiles."""

    def hold(self) -> None:
        """Let signals wait."""
        self._held = True

    def release(self) -> None:
        """Let signals act again; on one rank, raise a KeyboardInterrupt if one was waiting."""
        self._held = False
        if self._heard and not self._at_steps:
            self._heard = False
            raise KeyboardInterrupt

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self._held or self._at_steps:
            self._heard = True
            return
        try:
            self._before[number](number, frame)
        except KeyboardInterrupt:
            self._held = self.acted = True
            raise
