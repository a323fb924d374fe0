"""Weights of growth: a field `w(S, t)` at the growing points, by which growth is multiplied.

It says when a zone grows, and how growth falls off around a point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Intervals
from .arc_length import ArcLength

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gaussian:
    """A Gaussian of the arc length from a point.

    Attributes
    ----------
    centre
        Arc length of the point along the unloaded wall in µm; or the pole of the current one
        from which arc lengths along the current wall count.
    width
        Standard deviation in µm.
    """

    centre: float | Literal["bottom", "top"]
    width: float

    def at(self, distance: Array) -> Array:
        """Weight at some arc lengths from the centre in µm."""
        return np.exp(-((distance / self.width) ** 2) / 2)


@dataclass(frozen=True)
class Weight:
    """Weight of growth in one zone: 1 or a Gaussian in its time, 0 before and after.

    Attributes
    ----------
    parts
        Where it holds.
    span
        When growth begins and ends, min.
    bump
        How it falls off; None: it is 1.
    """

    parts: Intervals
    span: tuple[float, float] = (0.0, inf)
    gaussian: Gaussian | None = None

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

    A weight that follows the tip depends on the shape of the whole wall. It is that of the trial
    state whenever growth is updated, in every stage and every iteration, so that methods in time
    keep their order; its derivative is left out of the tangents.

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
    stretch
        Stretch of the meridian, in UFL.
    weights
        Weights of the zones.

    Attributes
    ----------
    function
        Their values, a scalar in UFL.
    """

    def __init__(
        self,
        mesh: Any,
        cells: NDArray[np.int32],
        degree: int,
        S: Array,
        stretch: Any,
        weights: Weights,
    ) -> None:
        space = dx.quadrature_space(mesh, 1, degree)
        field = dx.fem.Function(space)
        self.function = field[0]
        self._values, dofs = field.x.array, dx.dof_array(space)
        self._zones = weights.zones
        self._places = [_held(S, cells, weight.parts) for weight in self._zones]
        self._dofs = [dofs[held] for held in self._places]
        self._S = S
        moving = [w for w in self._zones if w.gaussian and isinstance(w.gaussian.centre, str)]
        self._arc_length = ArcLength(mesh, degree, stretch) if moving else None
        self._grows: Sequence[bool] = ()
        self.set_interval(0.0, 0.0)

    def set_interval(self, start: float, end: float) -> None:
        """Let growth be as between two times in min; at one time, as right after it."""
        grows = [weight.grows(start, end) for weight in self._zones]
        if grows == self._grows:
            return
        self._grows = grows
        for weight, on, held, dofs in self._each():
            if weight.gaussian is None or not on:
                self._values[dofs] = float(on)
            elif not isinstance(weight.gaussian.centre, str):
                self._values[dofs] = weight.gaussian.at(self._S[held] - weight.gaussian.centre)

    def update(self) -> None:
        """Bring the weights up to the trial state."""
        if self._arc_length is None:
            return
        s, whole = self._arc_length.at_points()
        for weight, on, held, dofs in self._each():
            if on and weight.gaussian is not None and isinstance(weight.gaussian.centre, str):
                distance = s[held] if weight.gaussian.centre == "bottom" else whole - s[held]
                self._values[dofs] = weight.gaussian.at(distance)

    def _each(self) -> Any:
        return zip(self._zones, self._grows, self._places, self._dofs, strict=True)


def _held(S: Array, cells: NDArray[np.int32], parts: Intervals) -> NDArray[np.int32]:
    """Those of some cells that lie in some parts of the meridian."""
    middle = S[cells].mean(axis=1)
    held = np.zeros(len(cells), dtype=bool)
    for part in parts:
        held |= part.holds(middle)
    return cells[held]
