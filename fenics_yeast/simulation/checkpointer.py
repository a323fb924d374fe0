"""Checkpoints of a run, taken every few seconds; and the way back from one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from ..mechanics import Ordering, Shell
from ..scene import Scene
from .checkpoint import Checkpoint, CheckpointError
from .recorder import Recorder
from .result import Timings

_EVERY = 2.0  # seconds between checkpoints
_SHARE = 0.02  # most of the time that they may take


class Checkpointer:
    """Hands on checkpoints, often enough to lose little; its methods are collective.

    Parameters
    ----------
    shell, scene, journal
        The wall, its scene and the notes of its run.
    keep
        Is given the checkpoints, on rank 0 alone.
    """

    def __init__(
        self, shell: Shell, scene: Scene, recorder: Recorder, keep: Callable[[Checkpoint], None]
    ) -> None:
        self._comm, self._layout = shell.comm, Ordering(shell)
        self._scene, self._recorder, self._keep = scene.to_toml(), recorder, keep
        self._kept: Checkpoint | None = None
        self._next = perf_counter() + _EVERY

    def offer(self, checkpoint: Checkpoint | None, timings: Timings) -> None:
        """Hand a checkpoint with the arrays of each rank on, unless the last was just now."""
        due = perf_counter() >= self._next
        if self._comm.size > 1:
            due = self._comm.bcast(due)
        if due:
            self.finish(checkpoint, timings)

    def finish(self, checkpoint: Checkpoint | None, timings: Timings) -> None:
        """Hand a checkpoint on, unless that was done."""
        if checkpoint is None or checkpoint is self._kept:
            return
        began = perf_counter()
        ordered = self._layout.ordered(replace(checkpoint, scene=self._scene, timings=timings))

        def keep() -> None:
            if ordered is not None:
                self._keep(ordered)

        self._recorder.on_root(keep)
        self._kept, now = checkpoint, perf_counter()
        self._next = now + max(_EVERY, (now - began) / _SHARE)


def local(checkpoint: Checkpoint, shell: Shell) -> Checkpoint:
    """The part of this rank of a checkpoint; collective.

    Raises
    ------
    CheckpointError
        If it is that of another wall.
    """
    try:
        return Ordering(shell).local(checkpoint)
    except ValueError:
        raise CheckpointError("is that of another mesh, as another version made it") from None
