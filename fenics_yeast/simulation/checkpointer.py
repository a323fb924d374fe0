"""Regular checkpoints of a run, and the way back from one."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from ..mechanics import Ordering, Shell
from ..scene import Scene
from .checkpoint import Checkpoint, CheckpointError
from .ranks import on_root
from .result import Timings

_EVERY = 2.0  # seconds between checkpoints
_SHARE = 0.02  # largest part of the time that they may take


class Checkpointer:
    """Passes checkpoints to a function on rank 0 every few seconds; its methods are collective."""

    def __init__(self, shell: Shell, scene: Scene, keep: Callable[[Checkpoint], None]) -> None:
        self._comm, self._ordering = shell.comm, Ordering(shell.space, shell.growing_points)
        self._scene, self._keep = scene.to_toml(), keep
        self._kept: Checkpoint | None = None
        self._next = perf_counter() + _EVERY

    def offer(self, checkpoint: Checkpoint | None, timings: Timings) -> None:
        """Pass on a checkpoint with the arrays of each rank, if one is due."""
        due = perf_counter() >= self._next
        if self._comm.size > 1:
            due = self._comm.bcast(due)
        if due:
            self.finish(checkpoint, timings)

    def finish(self, checkpoint: Checkpoint | None, timings: Timings) -> None:
        """Pass on a checkpoint, unless it was passed on before."""
        if checkpoint is None or checkpoint is self._kept:
            return
        began = perf_counter()
        ordered = self._ordering.ordered(replace(checkpoint, scene=self._scene, timings=timings))

        on_root(self._comm, lambda: ordered is not None and self._keep(ordered))
        self._kept, now = checkpoint, perf_counter()
        self._next = now + max(_EVERY, (now - began) / _SHARE)


def local(checkpoint: Checkpoint, shell: Shell) -> Checkpoint:
    """Return the part of a checkpoint that belongs to this rank; collective.

    Raises
    ------
    CheckpointError
        If it belongs to another wall.
    """
    try:
        return Ordering(shell.space, shell.growing_points).local(checkpoint)
    except ValueError:
        raise CheckpointError("belongs to another mesh, made by another version") from None
