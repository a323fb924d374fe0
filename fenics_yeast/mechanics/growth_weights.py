"""Weights of growth, a field `w(S, t)` at the growing points: when and where a zone grows."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Array, Intervals
from .ordering import Order
from .quadrature import QuadraturePoints


@dataclass(frozen=True)
class Gaussian:
    """A Gaussian of the arc length from a centre.

    Attributes
    ----------
    centre
        Reference arc length in µm, or the pole from which that of the current wall is measured.
    width
        Standard deviation in µm.
    """

    centre: float | Literal["bottom", "top"]
    width: float

    @property
    def follows_tip(self) -> bool:
        """Whether arc length is that of the current wall."""
        return isinstance(self.centre, str)

    def at(self, s: Array, length: float = inf) -> Array:
        """Return the weight at arc lengths in µm along a meridian of a length."""
        centre = length if self.centre == "top" else 0.0 if self.centre == "bottom" else self.centre
        return np.exp(-(((s - centre) / self.width) ** 2) / 2)


@dataclass(frozen=True)
class Weight:
    """Weight of growth in one zone: 1 or a Gaussian in its span, 0 before and after.

    Attributes
    ----------
    parts, span
        Parts of the meridian that the zone covers; times in min at which growth begins and ends.
    gaussian
        Decrease with arc length; None for 1.
    """

    parts: Intervals
    span: tuple[float, float] = (0.0, inf)
    gaussian: Gaussian | None = None

    def grows(self, start: float, end: float) -> bool:
        """Return whether the zone grows between two times or, at equal times, just after."""
        begins, ends = self.span
        return begins <= (start + end) / 2 < ends


Weights = tuple[Weight, ...]
"""Weights of all zones of a wall."""


class WeightField:
    """Weights at the quadrature points of the growing elements.

    A weight that follows the tip depends on the shape of the whole wall. It is updated with the
    growth strains in every iteration, which preserves the order of time integration; the tangents
    omit its derivative.

    Parameters
    ----------
    points, weights
        Quadrature points of the growing elements; weights of the zones.
    stretch
        Meridional stretch `λ1` of the mid-surface in UFL.

    Attributes
    ----------
    function
        The weights, a scalar in UFL.
    """

    def __init__(self, points: QuadraturePoints, stretch: Any, weights: Weights) -> None:
        field, self._dofs = points.function(1)
        self.function, self._values = field[0], field.x.array
        self._arc_length = _ArcLength(points, stretch) if follow_tip(weights) else None
        self.set(points, weights)

    def set(self, points: QuadraturePoints, weights: Weights) -> None:
        """Set the zones of another wall of the same structure, whose nodes have moved."""
        self._S, self._zones = points.S, weights
        self._inside = [points.inside(zone.parts) for zone in self._zones]
        if self._arc_length is not None:
            self._arc_length.move(points)
        self.set_interval(0.0, 0.0)

    def set_interval(self, start: float, end: float) -> None:
        """Set the weights of an interval in min or, at equal times, of just after."""
        self._growing = [zone.grows(start, end) for zone in self._zones]
        for gaussian, grows, inside in self._each():
            if gaussian is None or not grows:
                self._values[self._dofs[inside]] = float(grows)
            elif not gaussian.follows_tip:
                self._values[self._dofs[inside]] = gaussian.at(self._S[inside])

    def update(self) -> None:
        """Update weights that follow the tip to the trial state."""
        if self._arc_length is None:
            return
        s, length = self._arc_length.at_points()
        for gaussian, grows, inside in self._each():
            if grows and gaussian is not None and gaussian.follows_tip:
                self._values[self._dofs[inside]] = gaussian.at(s[inside], length)

    def _each(self) -> Iterator[tuple[Gaussian | None, bool, NDArray[np.bool_]]]:
        gaussians = [zone.gaussian for zone in self._zones]
        return zip(gaussians, self._growing, self._inside, strict=True)


def follow_tip(weights: Weights) -> bool:
    """Whether any of some weights follows the tip."""
    return any(zone.gaussian and zone.gaussian.follows_tip for zone in weights)


class _ArcLength:
    """Arc length along the current meridian at quadrature points, from the stretch in UFL."""

    def __init__(self, points: QuadraturePoints, stretch: Any) -> None:
        self._elements = points.elements
        self._stretch = self._every(points).compile([stretch])
        # Integrals of the polynomial through the points, from an element's start to each of them
        # and over the whole element.
        places = dx.quadrature_points(points.degree)
        powers = np.arange(1, len(places) + 1)
        coefficients = np.linalg.inv(places ** (powers - 1))
        self._up_to = places**powers / powers @ coefficients
        self._whole = 1 / powers @ coefficients

    def move(self, points: QuadraturePoints) -> None:
        """Take over the places of the elements."""
        every = self._every(points)
        self._length = np.ptp(every.ends, axis=1)
        self._order = Order(points.mesh.comm, every.ends.min(axis=1), every.owned)

    @staticmethod
    def _every(points: QuadraturePoints) -> QuadraturePoints:
        """Return the points of all local elements."""
        count = len(dx.element_vertices(points.mesh))
        return replace(points, elements=np.arange(count, dtype=np.int32))

    def at_points(self) -> tuple[Array, float]:
        """Return arc length from the bottom at the points, and the whole length, in µm."""
        stretch = self._stretch()
        lengths = self._order.allgather(self._length * (stretch @ self._whole))
        total = np.cumsum(lengths)
        first = (total - lengths)[self._order.places]
        inside = self._length[:, None] * (stretch @ self._up_to.T)
        return (first[:, None] + inside)[self._elements], float(total[-1])
