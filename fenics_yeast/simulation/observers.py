"""Notify the observers of a run of recorded rows and profiles."""

from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from .history import Row
from .profiles import Profile
from .ranks import on_root
from .result import Observer


class Observers:
    """An observer that notifies several others, in their order."""

    def __init__(self, observers: Iterable[Observer]) -> None:
        self._observers = tuple(observers)

    def accepted(self, row: Row) -> None:
        """Pass on the row of an accepted state."""
        for observer in self._observers:
            observer.accepted(row)

    def saved(self, profile: Profile) -> None:
        """Pass on the profile of a saved time."""
        for observer in self._observers:
            observer.saved(profile)


class RowCallback:
    """A function called with each row, as an observer."""

    def __init__(self, call: Callable[[Row], None]) -> None:
        self.accepted = call

    def saved(self, profile: Profile) -> None:
        """Ignore profiles."""


class Publisher:
    """Passes rows and profiles to an observer on rank 0, until that raises an error."""

    def __init__(self, comm: Any, observer: Observer) -> None:
        self._comm, self._observer = comm, observer
        self._failed = False

    def publish(self, news: deque[Row | Profile | None]) -> None:
        """Pass on what is new, oldest first; collective.

        Raises a `RootError` or KeyboardInterrupt if the observer raised an error or interrupt.
        """
        while news:
            event = news.popleft()
            on_root(self._comm, lambda event=event: self._notify(event))  # type: ignore[misc]

    def _notify(self, event: Row | Profile | None) -> None:
        if self._failed:
            return
        try:
            if isinstance(event, Row):
                self._observer.accepted(event)
            elif event is not None:
                self._observer.saved(event)
        except Exception:
            self._failed = True
            raise
