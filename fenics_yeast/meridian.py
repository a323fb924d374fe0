"""A scene's meridian cut into cells, finer where it matters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ._cell import (
    CapCell,
    CapsuleCell,
    ConeCell,
    CylinderCell,
    DiscCell,
    End,
    ProfileCell,
    SphereCell,
    SpheroidCell,
)
from .curves import Cap, Capsule, Curve, Polygon, Sphere, Straight, spheroid

if TYPE_CHECKING:
    from ._cell import AnyCell, Pole
    from .scene import Scene

Array = NDArray[np.float64]

_LOOKED_AT = 20_001  # points of a curve at which the polar angle is looked at


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
    ends
        What the lower and the upper end are: a pole, a free edge, or how an edge is held.
    """

    curve: Curve
    nodes: Array
    zone: Interval | None
    ends: tuple[End, End] = ("pole", "pole")


def reference_curve(cell: AnyCell) -> Curve:
    """Meridian of the unloaded cell."""
    match cell:
        case SphereCell():
            return Sphere(cell.diameter / 2)
        case SpheroidCell():
            return spheroid(cell.diameter / 2, cell.height / 2)
        case CapsuleCell():
            return Capsule(cell.diameter / 2, cell.length - cell.diameter)
        case ProfileCell():
            from .contour import smooth_contour

            return smooth_contour(cell.r, cell.z, cell.tolerance)
        case CapCell():
            return Cap(cell.radius, float(np.deg2rad(cell.half_angle)))
        case DiscCell():
            return Straight(cell.diameter / 2, 0.0, 0.0)
        case ConeCell():
            return Straight(cell.outer_diameter / 2, cell.inner_diameter / 2, cell.height)
        case CylinderCell():
            return Straight(cell.diameter / 2, cell.diameter / 2, cell.length)


def discretise(scene: Scene) -> Discretisation:
    """Meridian, cells and growing zone of a scene."""
    curve = reference_curve(scene.cell)
    zone = _zone(scene, curve)
    inner = [] if zone is None else [s for s in (zone.start, zone.end) if 0 < s < curve.length]
    inner = sorted({*inner, *curve.joints})
    ends = scene.cell.ends
    edges = [s for s, end in zip((0.0, curve.length), ends, strict=True) if end != "pole"]
    layer = float(np.sqrt(scene.cell.radius * scene.wall.thickness))
    graded = scene.numerics.grading == "graded"
    density = _graded(zone, [*inner, *edges], layer) if graded else np.ones_like
    nodes = place_nodes(curve.length, inner, scene.numerics.elements, density)
    if scene.numerics.geometry == "curved":
        return Discretisation(curve, nodes, zone, ends)
    polygon = Polygon.inscribed(curve, nodes)
    if zone is not None:
        start, end = (polygon.S[np.argmin(abs(nodes - s))] for s in (zone.start, zone.end))
        zone = Interval(float(start), float(end))
    return Discretisation(polygon, polygon.S, zone, ends)


def _zone(scene: Scene, curve: Curve) -> Interval | None:
    if scene.growth is None:
        return None
    zone = scene.growth.zone
    extent = polar_extent(curve, zone.pole, float(np.deg2rad(zone.half_angle)))
    return Interval(0.0, extent) if zone.pole == "bottom" else Interval(extent, curve.length)


def polar_extent(curve: Curve, pole: Pole, half_angle: float) -> float:
    """Arc length in µm at which a polar cap ends.

    The angle in radians is seen from the middle of the axis, between the poles; for a part of a
    sphere, from its centre.
    """
    if isinstance(curve, Sphere | Cap):
        extent = min(half_angle * curve.R0, curve.length)
        return extent if pole == "bottom" else curve.length - extent
    S = np.linspace(0, curve.length, _LOOKED_AT)
    Z = curve.height(S)
    angle = np.arctan2(curve.radius(S), (Z[-1] + Z[0]) / 2 - Z)  # from below
    if pole == "top":
        angle, S = np.pi - angle[::-1], S[::-1]
    first = int(np.argmax(angle >= half_angle - 1e-12)) or len(S) - 1
    part = (half_angle - angle[first - 1]) / (angle[first] - angle[first - 1])
    return float(S[first - 1] + min(part, 1.0) * (S[first] - S[first - 1]))


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
