"""A scene's meridian cut into cells, finer where it matters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .curves import Curve, Polygon, Sphere

if TYPE_CHECKING:
    from .scene import Scene

Array = NDArray[np.float64]


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
