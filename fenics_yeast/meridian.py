"""Reference meridians and the interval meshes on them.

Arc length `S` runs from the bottom pole to the top pole, `R' = cos Φ`, `Z' = sin Φ`; the outward
normal is `(sin Φ, -cos Φ)`. Every function of `S` takes and returns arrays of one shape.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .scene import Scene

Array = NDArray[np.float64]


class Curve(Protocol):
    """A reference meridian of the given length in µm."""

    @property
    def length(self) -> float: ...

    def radius(self, S: Array) -> Array:
        """`R(S)` in µm."""
        ...

    def height(self, S: Array) -> Array:
        """`Z(S)` in µm."""
        ...

    def angle(self, S: Array) -> Array:
        """`Φ(S)` in radians."""
        ...

    def curvature(self, S: Array) -> Array:
        """`Φ'(S)` in 1/µm."""
        ...


@dataclass(frozen=True)
class Sphere:
    """Meridian of a sphere of the given mid-surface radius in µm, centred at the origin."""

    R0: float

    @property
    def length(self) -> float:
        return np.pi * self.R0

    def radius(self, S: Array) -> Array:
        return self.R0 * np.sin(S / self.R0)

    def height(self, S: Array) -> Array:
        return -self.R0 * np.cos(S / self.R0)

    def angle(self, S: Array) -> Array:
        return S / self.R0

    def curvature(self, S: Array) -> Array:
        return np.full_like(S, 1 / self.R0)


@dataclass(frozen=True)
class Polygon:
    """Straight conical elements between points of a curve: the paper's faceted meridian.

    Attributes
    ----------
    S, R, Z
        Arc length along the polygon, radius and height of its corners in µm, shape ``(n + 1,)``.
    """

    S: Array
    R: Array
    Z: Array

    @classmethod
    def inscribed(cls, curve: Curve, S: Array) -> Polygon:
        """Polygon with its corners on a curve at the arc lengths `S` of that curve."""
        R, Z = curve.radius(S), curve.height(S)
        R[np.isclose(R, 0, atol=1e-12 * curve.length)] = 0
        return cls(np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(R), np.diff(Z)))]), R, Z)

    @property
    def length(self) -> float:
        return float(self.S[-1])

    def radius(self, S: Array) -> Array:
        return np.interp(S, self.S, self.R)

    def height(self, S: Array) -> Array:
        return np.interp(S, self.S, self.Z)

    def angle(self, S: Array) -> Array:
        """Angle of the facet; at a corner the mean of its two neighbours."""
        facets = np.unwrap(np.arctan2(np.diff(self.Z), np.diff(self.R)))
        tiny = 1e-9 * self.length
        before = np.searchsorted(self.S[1:-1], S - tiny)
        after = np.searchsorted(self.S[1:-1], S + tiny)
        return (facets[before] + facets[after]) / 2

    def curvature(self, S: Array) -> Array:
        return np.zeros_like(S)


@dataclass(frozen=True)
class Interval:
    """A part of the meridian, in µm of arc length."""

    start: float
    end: float


@dataclass(frozen=True)
class Discretisation:
    """A meridian cut into cells.

    Attributes
    ----------
    curve
        The reference meridian.
    nodes
        Arc length of the cells' ends in µm, increasing, shape ``(n + 1,)``.
    zone
        The growing part, its ends among the nodes; None where nothing grows.
    """

    curve: Curve
    nodes: Array
    zone: Interval | None


def discretise(scene: Scene) -> Discretisation:
    """Meridian, cells and growing zone of a scene."""
    curve: Curve = Sphere(scene.cell.diameter / 2)
    zone = _zone(scene, curve)
    ends = [] if zone is None else [s for s in (zone.start, zone.end) if 0 < s < curve.length]
    layer = float(np.sqrt(scene.cell.diameter / 2 * scene.wall.thickness))
    density = _graded(zone, ends, layer) if scene.numerics.grading == "graded" else np.ones_like
    nodes = place_nodes(curve.length, ends, scene.numerics.elements, density)
    if scene.numerics.geometry == "curved":
        return Discretisation(curve, nodes, zone)
    polygon = Polygon.inscribed(curve, nodes)
    if zone is not None:
        start, end = (polygon.S[np.argmin(abs(nodes - s))] for s in (zone.start, zone.end))
        zone = Interval(float(start), float(end))
    return Discretisation(polygon, polygon.S, zone)


def _zone(scene: Scene, curve: Curve) -> Interval | None:
    if scene.growth is None:
        return None
    extent = curve.length * scene.growth.zone.half_angle / 180
    if scene.growth.zone.pole == "bottom":
        return Interval(0.0, extent)
    return Interval(curve.length - extent, curve.length)


def _graded(
    zone: Interval | None, edges: Sequence[float], layer: float
) -> Callable[[Array], Array]:
    """Density of cells: more of them where the wall grows and in the boundary layers.

    The numbers are the best of those tried on three growing buds.
    """

    def density(S: Array) -> Array:
        weight = np.ones_like(S)
        if zone is not None:
            weight += 12 * ((zone.start <= S) & (zone.end >= S))
        for edge in edges:
            weight += 40 / (1 + ((S - edge) / (0.35 * layer)) ** 2)
        return weight

    return density


def place_nodes(
    length: float, fixed: Sequence[float], elements: int, density: Callable[[Array], Array]
) -> Array:
    """Nodes of a given number of cells, with some places fixed and a wanted density elsewhere.

    Parameters
    ----------
    length
        Length of the meridian in µm.
    fixed
        Arc lengths within it that must be nodes.
    elements
        Number of cells; at least one lies between two fixed places.
    density
        Relative number of cells per length, positive.

    Returns
    -------
    Array
        Increasing arc lengths, shape ``(elements + 1,)``.
    """
    ends = np.array([0.0, *sorted(fixed), length])
    parts = []
    for start, end in pairwise(ends):
        S = np.linspace(start, end, 2001)
        rho = density((S[1:] + S[:-1]) / 2) * np.diff(S)
        parts.append((S, np.concatenate([[0.0], np.cumsum(rho)])))
    counts = _apportion(np.array([total[-1] for _, total in parts]), max(elements, len(parts)))
    nodes = [np.interp(np.linspace(0, total[-1], n + 1)[:-1], total, S)
             for n, (S, total) in zip(counts, parts, strict=True)]  # fmt: skip
    return np.concatenate([*nodes, [length]])


def _apportion(shares: Array, total: int) -> NDArray[np.int64]:
    """Whole numbers of a given sum, at least one each, nearest in proportion to the shares."""
    counts = np.ones(len(shares), dtype=np.int64)
    while counts.sum() < total:
        counts[np.argmax(shares / (counts + 0.5))] += 1
    return counts
