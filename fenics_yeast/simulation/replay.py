"""Repeat the steps and the mesh of a run in runs of similar scenes."""

from __future__ import annotations

from dataclasses import dataclass

from ..scene import Numerics, Scene
from .discretise import element_counts
from .history import History


@dataclass(frozen=True)
class Replay:
    """Discretisation of a run: results of runs that share it are smooth in their parameters.

    Otherwise steps and elements are chosen for each scene, and jump by a part of the
    tolerance.

    Attributes
    ----------
    times
        Ends of the accepted steps in min.
    numerics
        The table `[numerics]`, with all that the tolerance chose.
    counts
        Numbers of elements between places that must be nodes.
    """

    times: tuple[float, ...]
    numerics: Numerics
    counts: tuple[int, ...]

    @classmethod
    def of(cls, scene: Scene, history: History) -> Replay:
        """Return the discretisation of a scene whose run has a history."""
        return cls(tuple(history.time_min.tolist()), scene.numerics, element_counts(scene))

    def applied_to(self, scene: Scene) -> Scene:
        """Return a scene with these numerics, and nothing left to choose."""
        return scene.with_values({"numerics": self.numerics.model_dump(by_alias=True)})
