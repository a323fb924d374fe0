"""Weights of growth: a field `w(S, t)` at the growing points, by which growth is multiplied.

It says when a zone grows and how growth falls off around a point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _dolfinx as dx
from .zones import Intervals

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Weight:
    """Weight of growth in one zone: 1 in its time, and 0 before and after.

    Attributes
    ----------
    parts
        Where it holds.
    span
        When growth begins and ends, min.
    """

    parts: Intervals
    span: tuple[float, float] = (0.0, inf)

    def grows(self, start: float, end: float) -> bool:
        """Whether there is growth between two times; at one time, whether there is right after."""
        begins, ends = self.span
        return begins <= (start + end) / 2 < ends


@dataclass(frozen=True)
class Weights:
    """Weights of all zones of a wall."""

    zones: tuple[Weight, ...]


class WeightField:
    """Weights at the quadrature points of the growing cells.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    cells
        Local growing cells, ghosts among them.
    degree
        Degree of the quadrature rule.
    S
        Arc length of the quadrature points of all local cells, shape ``(cells, points)``.
    weights
        Weights of the zones.

    Attributes
    ----------
    function
        Their values, a scalar in UFL.
    """

    def __init__(
        self, mesh: Any, cells: NDArray[np.int32], degree: int, S: Array, weights: Weights
    ) -> None:
        space = dx.quadrature_space(mesh, 1, degree)
        field = dx.fem.Function(space)
        self.function = field[0]
        self._values, self._dofs = field.x.array, dx.dof_array(space)[cells]
        self._zones = weights.zones
        middle = S[cells].mean(axis=1)
        self._held = [np.any([p.holds(middle) for p in w.parts], axis=0) for w in self._zones]
        self._grows: Sequence[bool] = ()
        self.during(0.0, 0.0)

    def during(self, start: float, end: float) -> None:
        """Let growth be as between two times in min; at one time, as right after it."""
        grows = [weight.grows(start, end) for weight in self._zones]
        if grows == self._grows:
            return
        self._grows = grows
        for held, on in zip(self._held, grows, strict=True):
            self._values[self._dofs[held]] = float(on)

    def update(self) -> None:
        """Bring the weights up to the trial state."""
