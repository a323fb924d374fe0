"""The laws that a scene asks for, with parameters that vary from zone to zone."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import NDArray

from . import growth, wall
from ._wall import AnyWall
from .laws import Law, Parameter
from .meridian import Discretisation
from .scene import LinearWall, OgdenWall, Scene, Wall
from .weights import Weight, Weights
from .zones import Intervals

Array = NDArray[np.float64]


def strain_energy(material: AnyWall) -> Law:
    """Strain energy of a scene's wall."""
    match material:
        case Wall(shear_modulus=mu, ogden_exponent=alpha):
            return Law(wall.ogden, {"mu": mu, "alpha": alpha})
        case OgdenWall(shear_moduli=moduli, ogden_exponents=exponents):
            terms = {f"mu_{i}": mu for i, mu in enumerate(moduli)}
            terms |= {f"alpha_{i}": alpha for i, alpha in enumerate(exponents)}
            return Law(wall.ogden_terms, terms)
        case LinearWall(young_modulus=young, poisson_ratio=poisson):
            return Law(wall.linear, {"young": young, "poisson": poisson})


def thinning(material: AnyWall) -> Law | None:
    """Strain through a scene's wall; None where it keeps its thickness."""
    if material.thickness_change == "none":
        return None
    if isinstance(material, LinearWall):
        return Law(wall.linear_thinning, {"poisson": material.poisson_ratio})
    return Law(wall.incompressible_thinning)


def growth_law(scene: Scene, cut: Discretisation) -> Law | None:
    """Growth rate of a scene's zones; None for an elastic scene."""
    if scene.growth is None:
        return None
    parameters: dict[str, Parameter] = {
        "sigma_trs": by_zone(cut.zones, [zone.threshold for zone in scene.growing]),
        "t_grw": by_zone(cut.zones, [zone.time for zone in scene.growing]),
    }
    if any(zone.span != (0.0, inf) for zone in scene.growing):
        zones = zip(cut.zones, scene.growing, strict=True)
        parameters["of_rate"] = Weights(tuple(Weight(parts, zone.span) for parts, zone in zones))
    return Law(growth.stress_driven, parameters)


def by_zone(zones: Sequence[Intervals], values: Sequence[float], outside: float = 1.0) -> Parameter:
    """A number for each zone; what is the same in all of them, and is not read elsewhere, is one.

    Parameters
    ----------
    zones
        Parts of the meridian that the zones cover.
    values
        The numbers, one for each zone.
    outside
        Number outside of all zones.
    """
    if len(set(values)) == 1:
        return values[0]

    def at(S: Array) -> Array:
        # A cell's points lie in its inside, and edges are nodes: no point is on an edge.
        field = np.full_like(S, outside)
        for parts, value in zip(zones, values, strict=True):
            for part in parts:
                field[part.holds(S)] = value
        return field

    return at
