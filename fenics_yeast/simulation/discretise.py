"""The mesh of a scene's meridian, graded towards edges, loads and growing zones."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry import (
    Array,
    Curve,
    Discretisation,
    End,
    Interval,
    Intervals,
    Pole,
    Polygon,
    apart,
    edges,
    merged,
    neck,
    place_nodes,
    within,
)
from ..scene import ProfileCell, Scene

Reference = Callable[[Array], tuple[Curve, Array]]

_NEAREST = 1e-3  # part of the width of a tip down to which elements get smaller towards it


def discretise(scene: Scene, counts: Sequence[int] = ()) -> Discretisation:
    """Return the meridian, elements and zones of a scene.

    `counts` are the numbers of elements between places that must be nodes, such as those of a
    similar scene; by default they follow the density of elements.

    Raises
    ------
    ValueError
        If there are other numbers of such places and counts, or the unloaded shape of a turgid
        outline has not been found; see `find_unloaded`.
    """
    return divided(scene, scene.cell.reference, counts)


def is_turgid_outline(scene: Scene) -> bool:
    """Whether a scene gives the outline of a turgid cell, so that its unloaded shape is found."""
    return isinstance(scene.cell, ProfileCell) and scene.cell.outline_is == "turgid"


def element_counts(scene: Scene) -> tuple[int, ...]:
    """Return the numbers of elements between places that must be nodes."""
    return divided(scene, lambda S: (scene.cell.curve, S)).counts


def divided(scene: Scene, reference: Reference, counts: Sequence[int] = ()) -> Discretisation:
    """Return the same on a meridian on which a function places what is given on the cell's curve.

    The function takes arc lengths on the curve, and returns the meridian and those on it.
    """
    curve, ends = scene.cell.curve, scene.cell.ends
    growing = [growth.zone.intervals(curve) for growth in scene.growing]
    walls = [zone.intervals(curve) for zone in scene.wall.zone]
    grows = merged(part for parts in growing for part in parts)
    loaded = _loaded(scene, curve)
    load = [] if loaded is None else [loaded]
    rings = [s for s in load if s < curve.length]
    zones = [part for parts in (*growing, *walls) for part in parts]
    septum = _septum(scene, curve)
    septa = [] if septum is None else [septum]
    inner = apart([*edges(zones, curve), *curve.joints, *rings, *septa])
    outer = [s for s, end in zip((0.0, curve.length), ends, strict=True) if end != "pole"]
    layer = float(np.sqrt(scene.cell.radius * min(scene.wall.thicknesses)))
    density: Callable[[Array], Array] = np.ones_like
    if scene.numerics.grading == "graded":
        tips = [polarity for zone in scene.growing if (polarity := zone.polarity) is not None]
        points = [
            _Point(S, tip.width, tip.follow == "tip")
            for tip in tips for S in tip.centres(curve)
        ]  # fmt: skip
        rests = [0.0] if load and scene.cell.closed else []  # on a point, like the load
        layers = [*inner, *outer, *load, *rests]
        density = _graded(curve.length, grows, layers, layer, points)
        near = [s for point in points for s in point.fixed]
        inner = apart([*inner, *(s for s in near if 0 < s < curve.length)])
    elements = scene.numerics.elements
    nodes, counts = place_nodes(curve.length, inner, elements, density, counts)
    meridian, places = reference(nodes)
    if scene.numerics.geometry == "conical":
        meridian = Polygon.inscribed(meridian, places)
        places = meridian.S

    def at_nodes(parts: Intervals) -> Intervals:
        stops = (places[[abs(nodes - s).argmin() for s in (p.start, p.end)]] for p in parts)
        return tuple(Interval(float(start), float(end)) for start, end in stops)

    if loaded is not None:
        loaded = float(places[abs(nodes - loaded).argmin()])
    grown, walled = (tuple(map(at_nodes, zones)) for zones in (growing, walls))
    whole = Discretisation(meridian, places, grown, ends, walled, loaded, counts)
    if septum is None or scene.septum is None or scene.septum.piece is None:
        return whole
    return _piece(whole, int(abs(nodes - septum).argmin()), scene.septum.piece)


def _septum(scene: Scene, curve: Curve) -> float | None:
    """Return the arc length in µm of a scene's septum."""
    if scene.septum is None:
        return None
    return neck(scene.growing_parts, curve) if scene.septum.at is None else scene.septum.at


def _piece(whole: Discretisation, node: int, side: Pole) -> Discretisation:
    """Return the part of a meridian on one side of a node, clamped there."""
    below = side == "bottom"
    nodes = whole.nodes[: node + 1] if below else whole.nodes[node:]
    start, end = float(nodes[0]), float(nodes[-1])
    zones, wall_zones = (
        tuple(within(parts, start, end) for parts in each)
        for each in (whole.zones, whole.wall_zones)
    )
    ends: tuple[End, End] = ("pole", "clamped") if below else ("clamped", "pole")
    return Discretisation(whole.curve, nodes, zones, ends, wall_zones)


def _loaded(scene: Scene, curve: Curve) -> float | None:
    """Return the arc length in µm at which a scene's force acts.

    By symmetry, a force on a closed cell acts at its top pole.
    """
    if scene.axial_load is None:
        return None
    return curve.length if scene.axial_load.at is None else scene.axial_load.at


@dataclass(frozen=True)
class _Point:
    """A point around which growth is polarised, with its width in µm."""

    S: float
    width: float
    follows_tip: bool

    def density(self, S: Array) -> Array:
        """Return the density of elements; at a tip it is constant per decade of distance.

        Points within a thousandth of the width become the whole dome of the tip when the cell
        has grown by six widths.
        """
        distance = np.abs(S - self.S) / self.width
        if self.follows_tip:
            return 60 / (distance + _NEAREST)
        return 30 / (1 + distance**2)

    @property
    def fixed(self) -> list[float]:
        """Arc lengths that must be nodes to resolve the steep density at a tip."""
        if not self.follows_tip:
            return []
        inward = 1 if self.S == 0 else -1
        return [self.S + inward * self.width * part for part in (_NEAREST, 0.01, 0.1)]


def _graded(
    length: float,
    growing: Intervals,
    edges: Sequence[float],
    layer: float,
    points: Sequence[_Point],
) -> Callable[[Array], Array]:
    """Return the density of elements, higher in growing zones and boundary layers.

    Around an edge it is constant per decade of distance, down to a fraction of the layer's
    width. The factors gave the smallest errors of those tried on growing buds, thick and thin.
    """

    def density(S: Array) -> Array:
        weight = np.ones_like(S)
        for part in growing:
            weight += 12 * part.holds(S)
        for edge in edges:
            weight += 0.6 * length / (0.05 * layer + np.abs(S - edge))
        for point in points:
            weight += point.density(S)
        return weight

    return density
