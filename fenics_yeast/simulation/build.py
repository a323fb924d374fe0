"""The laws that a scene asks for, with parameters that vary from zone to zone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry import Discretisation, Intervals, Pole
from ..mechanics import Gaussian, Law, Parameter, Weight, Weights
from ..mechanics import growth_laws as growth
from ..mechanics import hyperelasticity as wall
from ..scene import AnyWall, Growth, LinearWall, OgdenWall, Scene, Wall

Array = NDArray[np.float64]


def strain_energy(material: AnyWall) -> Law:
    """Strain energy of a scene's wall."""
    match material:
        case Wall(shear_modulus=mu, ogden_exponent=alpha):
            return Law(wall.ogden, {"mu": mu, "alpha": alpha})
        case OgdenWall(shear_moduli=moduli, ogden_exponents=exponents):
            terms = {f"mu_{i}": mu for i, mu in enumerate(moduli)}
            terms |= {f"alpha_{i}": alpha for i, alpha in enumerate(exponents)}
            return Law(wall.ogden_sum, terms)
        case LinearWall(young_modulus=young, poisson_ratio=poisson):
            return Law(wall.linear, {"young": young, "poisson": poisson})


def thinning(material: AnyWall) -> Law | None:
    """Strain through a scene's wall; None where it keeps its thickness."""
    if material.thickness_change == "none":
        return None
    if isinstance(material, LinearWall):
        return Law(wall.saint_venant_kirchhoff_thinning, {"poisson": material.poisson_ratio})
    return Law(wall.incompressible_thinning)


def growth_law(scene: Scene, mesh: Discretisation, own: Law | None = None) -> Law | None:
    """Growth rate of a scene's zones; None where nothing grows.

    Parameters
    ----------
    scene, cut
        The scene and its meridian, maybe that of a piece without growing zones.
    own
        A rate in place of equation (13), with thresholds and times of its own; the scene says
        where and when it holds, and may weight it.

    Raises
    ------
    ValueError
        If the scene weights a threshold, which a rate of one's own does not have.
    """
    if not mesh.growing:
        return None
    parameters: dict[str, Parameter] = {
        "sigma_trs": by_zone(mesh.zones, [zone.threshold for zone in scene.growing]),
        "t_grw": by_zone(mesh.zones, [zone.time for zone in scene.growing]),
    }
    law = own or Law(growth.stress_driven, parameters)
    rates, stresses = [], []
    for whole, zone in zip(mesh.zones, scene.growing, strict=True):
        of_rate = zone.polarity and zone.polarity.weight == "rate"
        for parts, gaussian in _gaussians(whole, zone, scene, mesh):
            rates.append(Weight(parts, zone.span, gaussian if of_rate else None))
            stresses.append(Weight(parts, gaussian=None if of_rate else gaussian))
    if any(weight != Weight(weight.parts) for weight in stresses):
        if own is not None:
            raise ValueError('a growth law of your own has no threshold: weight = "rate" is wanted')
        law = Law(law.function, {**law.parameters, "of_stress": Weights(tuple(stresses))})
    if any(weight != Weight(weight.parts) for weight in rates):
        weights = Weights(tuple(rates))
        law = Law(growth.weighted(law.function), {**law.parameters, "of_rate": weights})
    return law


def _gaussians(
    parts: Intervals, zone: Growth, scene: Scene, mesh: Discretisation
) -> list[tuple[Intervals, Gaussian | None]]:
    """How growth of a zone falls off around a point: its parts, each with its own point."""
    polarity = zone.polarity
    if polarity is None:
        return [(parts, None)]
    if polarity.centre is not None:
        # Straight elements are a little shorter than the curve whose arc length was given.
        scale = mesh.curve.length / scene.cell.curve.length
        return [(parts, Gaussian(polarity.centre * scale, polarity.width))]
    if polarity.pole == "both":  # caps that may meet at their edges
        lower = tuple(part for part in parts if part.start + part.end < mesh.curve.length)
        upper = tuple(part for part in parts if part not in lower)
        halves: list[tuple[Intervals, Pole]] = [(lower, "bottom"), (upper, "top")]
    else:
        halves = [(parts, polarity.pole or "top")]
    ends = {"bottom": 0.0, "top": mesh.curve.length}
    tip = polarity.follow == "tip"
    return [(half, Gaussian(pole if tip else ends[pole], polarity.width)) for half, pole in halves]


def thickness_ratio(material: AnyWall, mesh: Discretisation) -> Parameter:
    """Thickness of a wall over that outside of its zones."""
    values = [(zone.thickness or material.thickness) / material.thickness for zone in material.zone]
    return by_zone(mesh.wall_zones, values, 1.0)


def modulus_ratio(material: AnyWall, mesh: Discretisation) -> Parameter:
    """Moduli of a wall over those outside of its zones."""
    mu = material.shear_modulus
    values = [zone.modulus_factor or (zone.shear_modulus or mu) / mu for zone in material.zone]
    return by_zone(mesh.wall_zones, values, 1.0)


def by_zone(
    zones: Sequence[Intervals], values: Sequence[float], outside: float | None = None
) -> Parameter:
    """A number for each zone; one number where it is the same wherever it is read.

    Parameters
    ----------
    zones
        Parts of the meridian that the zones cover.
    values
        The numbers, one for each zone.
    outside
        Number outside of all zones; None where it is not read there.
    """
    rest = values[0] if outside is None else outside
    if {*values, rest} == {rest}:
        return rest

    def at(S: Array) -> Array:
        # A cell's points lie in its inside, and edges are nodes: no point is on an edge.
        field = np.full_like(S, rest)
        for parts, value in zip(zones, values, strict=True):
            for part in parts:
                field[part.holds(S)] = value
        return field

    return at
