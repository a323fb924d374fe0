"""Several observers of a run as one."""

from __future__ import annotations

from collections.abc import Iterable

from .result import Observer, Profile, Row


class Observers:
    """An observer that tells several others, in their order."""

    def __init__(self, observers: Iterable[Observer]) -> None:
        self._observers = tuple(observers)

    def accepted(self, row: Row) -> None:
        """Tell of an accepted state."""
        for observer in self._observers:
            observer.accepted(row)

    def saved(self, profile: Profile) -> None:
        """Tell of the profile of a saved time."""
        for observer in self._observers:
            observer.saved(profile)
