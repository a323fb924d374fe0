"""Interrupts of a run that several ranks share: they wait for the end of a step."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .record import Observer, Profile, Row


@contextmanager
def interrupts_at_steps(comm: Any, observers: list[Observer]) -> Iterator[None]:
    """On several ranks, let Ctrl-C and SIGTERM interrupt a run only where all ranks are in step.

    The launcher signals every rank at some instant of its own: raised there, a KeyboardInterrupt
    would leave other ranks waiting for it. Rank 0 therefore raises it as an observer.

    Parameters
    ----------
    comm
        Ranks of the run.
    observers
        Those of the run; on rank 0 one is added.
    """
    if comm.size == 1 or threading.current_thread() is not threading.main_thread():
        yield
        return
    listener = _Listener()
    if comm.rank == 0:
        observers.append(listener)
    signals = (signal.SIGINT, signal.SIGTERM)
    previous = {number: signal.signal(number, listener.hear) for number in signals}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


class _Listener:
    """Observer that raises at the next step what it has heard of."""

    def __init__(self) -> None:
        self._heard = False

    def hear(self, *_: object) -> None:
        self._heard = True

    def accepted(self, row: Row) -> None:
        """Raise a KeyboardInterrupt if there was one."""
        if self._heard:
            self._heard = False
            raise KeyboardInterrupt

    def saved(self, profile: Profile) -> None:
        """Nothing: a step has just come to its end."""
