"""What a tolerance of V/V0 asks of mesh, integration points and shear penalty.

The constants bound errors measured on growing buds, thick and thin, up to bursting.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple, Self

import numpy as np

from ..geometry import edges
from .cell import AnyCell
from .growth import Growth
from .loads import Load
from .numerics import Numerics
from .wall import AnyWall


class Shares(NamedTuple):
    """Parts of the tolerance that each source of error may reach."""

    steps: float = 0.14
    mesh: float = 0.1
    thickness_points: float = 0.75
    shear_penalty: float = 0.01


SHARES = Shares()

_FEWEST_ELEMENTS = 10
_SMOOTH_POINTS = 3  # integration points, exact for what varies smoothly through the wall
_MOST_POINTS = {"gauss": 16, "clustered": 20}  # more would take minutes to compile
_FAINT = 0.05  # weight of growth too small for a kink
# Error times n², by a kink where stress crosses the threshold within the wall.
_BY_POINTS = {"gauss": 0.062, "clustered": 0.026}
_BY_PENALTY = 0.005  # error times κ


@dataclass(frozen=True)
class Meridian:
    """What a meridian asks of its mesh.

    Attributes
    ----------
    zones, layers
        Number of parts that grow, and of boundary layers; a bud has one of each.
    widths
        Length of the meridian in widths of a boundary layer.
    sharp
        Whether stress may cross the threshold within the wall: there is an edge of growth, or of
        the wall, in a layer that grows.
    """

    zones: int
    layers: int
    widths: float
    sharp: bool

    @classmethod
    def of(cls, cell: AnyCell, wall: AnyWall, growing: Sequence[Growth], load: Load | None) -> Self:
        """Return what the meridian of a scene asks of its mesh."""
        zones = [growth.zone for growth in growing]
        layers = cell.layers + sum(zone.layers for zone in (*zones, *wall.zone))
        layers += sum(2 * growth.zone.parts for growth in growing if growth.polarity is not None)
        if load is not None:
            layers += 2 if cell.closed else 1  # the load, and the pole that supports the cell
        width = (cell.radius * min(wall.thicknesses)) ** 0.5
        parts = sum(zone.parts for zone in zones)
        sharp = wall.bending and _is_sharp(cell, wall, growing)
        return cls(parts, layers, cell.curve.length / width, sharp)


def _is_sharp(cell: AnyCell, wall: AnyWall, growing: Sequence[Growth]) -> bool:
    """Whether a wall grows at an edge of a zone, at a support or where its curvature varies."""
    curve, parts = cell.curve, [zone.intervals(cell.curve) for zone in wall.zone]
    supports = [s for s, end in zip((0.0, curve.length), cell.ends, strict=True) if end != "pole"]
    for growth in growing:
        zone, polarity = growth.zone.intervals(curve), growth.polarity
        if polarity is None and cell.shape != "sphere":
            return True
        if polarity is not None and polarity.weight == "threshold":
            return True
        places = np.array([*edges([*zone, *sum(parts, ())], curve), *curve.joints, *supports])
        grows = np.any([part.holds(places) for part in zone], axis=0)
        if polarity is not None:
            grows &= polarity.weight_at(places, curve) > _FAINT
        if grows.any():
            return True
    return False


def choose_numerics(numerics: Numerics, meridian: Meridian) -> Numerics:
    """Return numerics whose omitted keys keep the error of V/V0 within the tolerance.

    Through the thickness, the most points that can be afforded may have a larger error.
    """
    if numerics.preset != "default":
        return numerics
    tolerance, given = numerics.tolerance, numerics.model_fields_set
    penalty = _BY_PENALTY / (SHARES.shear_penalty * tolerance)
    rule = numerics.thickness_rule
    if meridian.sharp and given.isdisjoint(("thickness_points", "thickness_rule")):
        rule = "clustered"
    points = ceil((_BY_POINTS[rule] / (SHARES.thickness_points * tolerance)) ** 0.5)
    if points > _MOST_POINTS[rule] and "thickness_rule" not in given:
        rule = "gauss"  # points very close to a face see the singularity at a sharp edge
    chosen: dict[str, object] = {
        "elements": _mesh(numerics, meridian).elements_for(SHARES.mesh * tolerance),
        "thickness_points": min(_MOST_POINTS[rule], max(_SMOOTH_POINTS, points * meridian.sharp)),
        "thickness_rule": rule,
        "shear_penalty": max(numerics.shear_penalty, penalty),
    }
    values = dict(numerics) | {key: chosen[key] for key in chosen if key not in given}
    return Numerics.model_construct(given, **values)


def estimate_errors(numerics: Numerics, meridian: Meridian) -> dict[str, float]:
    """Return relative errors of V/V0 by mesh, integration points and shear penalty.

    They are estimated before a run, for growth that is far from bursting.
    """
    by_points = _BY_POINTS[numerics.thickness_rule] / numerics.thickness_points**2
    return {
        "mesh": _mesh(numerics, meridian).error(numerics.elements),
        "thickness_points": meridian.sharp * by_points,
        "shear_penalty": _BY_PENALTY / numerics.shear_penalty,
    }


@dataclass(frozen=True)
class _Mesh:
    """Convergence of V/V0: the number of elements with an error of 1e-4, and the order."""

    elements: float
    order: int

    def error(self, elements: int) -> float:
        return 1e-4 * (self.elements / elements) ** self.order

    def elements_for(self, error: float) -> int:
        return max(_FEWEST_ELEMENTS, ceil(self.elements * (1e-4 / error) ** (1 / self.order)))


def _mesh(numerics: Numerics, meridian: Meridian) -> _Mesh:
    """Return the convergence of a kind of mesh, in proportion to that of a bud."""
    share = (1 + 1.6 * meridian.zones + 5.6 * meridian.layers) / 8.2
    if numerics.geometry == "conical" or numerics.order == 1:  # facets, or linear functions
        return _Mesh((180 if numerics.geometry == "conical" else 260) * share, 2)
    elements = {2: 16, 3: 12}.get(numerics.order, 9.5) * share
    if numerics.grading == "graded":
        return _Mesh(elements, 6)
    return _Mesh(max(elements, 5.5 * meridian.widths), 5)
