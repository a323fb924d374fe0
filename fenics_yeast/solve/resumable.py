"""The protocol of everything whose state a checkpoint keeps."""

from typing import Protocol, TypeVar

State = TypeVar("State")


class Resumable(Protocol[State]):
    """An object whose state determines all that it computes from here on.

    A state is a frozen dataclass of numbers, arrays, tuples of them, or None. Its arrays are
    annotated as `DofValues` or `PointValues`, so that a checkpoint is the same on any number of
    ranks, and are never changed in place. Methods may be collective.
    """

    def state(self) -> State:
        """Return the state after an accepted step."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a state, of this object or of the same object in an earlier run."""
        ...
