"""Weights of growth, a field `w(S, t)` at the growing points: when and where a zone grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Intervals
from .gather import Order

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gaussian:
    """A Gaussian of the arc length from a centre.

    Attributes
    ----------
    centre
        Reference arc length of the centre in µm, or the pole from which arc length is measured
        along the current wall.
    width
        Standard deviation in µm.
    """

    centre: float | Literal["bottom", "top"]
    width: float

    def at(self, distance: Array) -> Array:
        """Return the weight at arc lengths in µm from the centre."""
        return np.exp(-((distance / self.width) ** 2) / 2)


@dataclass(frozen=True)
class Weight:
    """Weight of growth in one zone: 1 or a Gaussian in its span, 0 before and after.

    Attributes
    ----------
    parts
        Parts of the meridian that it covers.
    span
        Times in min at which growth begins and ends.
    gaussian
        How it falls off; None for 1.
    """

    parts: Intervals
    span: tuple[float, float] = (0.0, inf)
    gaussian: Gaussian | None = None

    def grows(self, start: float, end: float) -> bool:
        """Return whether it grows between two times or, at equal times, just after."""
        begins, ends = self.span
        return begins <= (start + end) / 2 < ends


@dataclass(frozen=True)
class Weights:
    """Weights of all zones of a wall."""

    zones: tuple[Weight, ...]


class WeightField:
    """Weights at the quadrature points of the growing elements.

    A weight that follows the tip depends on the shape of the whole wall. It is updated with growth
    in every stage and iteration, which preserves the order of time integration; the tangents omit
    its derivative.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    elements
        Local growing elements, ghosts among them.
    degree
        Degree of the quadrature rule.
    S
        Arc length of the quadrature points of all local elements, shape ``(elements, points)``.
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
        elements: NDArray[np.int32],
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
        self._places = [_within(S, elements, weight.parts) for weight in self._zones]
        self._dofs = [dofs[inside] for inside in self._places]
        self._S = S
        moving = [w for w in self._zones if w.gaussian and isinstance(w.gaussian.centre, str)]
        self._arc_length = _ArcLength(mesh, degree, stretch) if moving else None
        self._grows: Sequence[bool] = ()
        self.set_interval(0.0, 0.0)

    def set_interval(self, start: float, end: float) -> None:
        """Set the weights of an interval in min or, at equal times, of just after."""
        grows = [weight.grows(start, end) for weight in self._zones]
        if grows == self._grows:
            return
        self._grows = grows
        for weight, on, inside, dofs in self._each():
            if weight.gaussian is None or not on:
                self._values[dofs] = float(on)
            elif not isinstance(weight.gaussian.centre, str):
                self._values[dofs] = weight.gaussian.at(self._S[inside] - weight.gaussian.centre)

    def update(self) -> None:
        """Update weights that follow the tip to the trial state."""
        if self._arc_length is None:
            return
        s, whole = self._arc_length.at_points()
        for weight, on, inside, dofs in self._each():
            if on and weight.gaussian is not None and isinstance(weight.gaussian.centre, str):
                distance = s[inside] if weight.gaussian.centre == "bottom" else whole - s[inside]
                self._values[dofs] = weight.gaussian.at(distance)

    def _each(self) -> Any:
        return zip(self._zones, self._grows, self._places, self._dofs, strict=True)


def _within(S: Array, elements: NDArray[np.int32], parts: Intervals) -> NDArray[np.int32]:
    """Return the elements that lie in parts of the meridian."""
    middle = S[elements].mean(axis=1)
    inside = np.zeros(len(elements), dtype=bool)
    for part in parts:
        inside |= part.holds(middle)
    return elements[inside]


class _ArcLength:
    """Arc length of the current meridian at the quadrature points.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    degree
        Degree of its quadrature rule.
    stretch
        Stretch of the meridian, a scalar in UFL.
    """

    def __init__(self, mesh: Any, degree: int, stretch: Any) -> None:
        self._mesh = mesh
        ends = mesh.geometry.x[dx.element_vertices(mesh), 0]
        self._length = np.ptp(ends, axis=1)
        elements = np.arange(len(ends), dtype=np.int32)
        owned = elements < mesh.topology.index_map(1).size_local
        self._elements, self._order = elements, Order(mesh.comm, ends.min(axis=1), owned)
        places = dx.quadrature_points(degree)
        self._stretch = dx.compile_expression(stretch, places)
        # Integrals of the polynomial through the points, from an element's start to each of them
        # and over the whole element. Elements point upward, like the mesh.
        powers = np.arange(1, len(places) + 1)
        coefficients = np.linalg.inv(places ** (powers - 1))
        self._up_to = places**powers / powers @ coefficients
        self._whole = 1 / powers @ coefficients

    def at_points(self) -> tuple[Array, float]:
        """Return arc length from the bottom at the local points, and the whole length; µm.

        The shape of the first is ``(elements, points)``; collective.
        """
        stretch = dx.evaluate(self._stretch, self._mesh, self._elements)
        lengths = self._order.allgather(self._length * (stretch @ self._whole))
        total = np.cumsum(lengths)
        first = (total - lengths)[self._order.places]
        inside = self._length[:, None] * (stretch @ self._up_to.T)
        return first[:, None] + inside, float(total[-1])
