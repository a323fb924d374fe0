"""The laws that a scene asks for, with parameters that vary from zone to zone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Discretisation, Intervals, Pole
from ..mechanics import Gaussian, Law, OwnLaw, Parameter, Shell, Weight, Weights, own_laws
from ..mechanics import growth_laws as growth
from ..mechanics import hyperelasticity as wall
from ..scene import AnyWall, Growth, LinearWall, OgdenWall, PressureTable, Scene, Wall
from .discretise import discretise

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


zone_law = growth_law


def build_shell(
    scene: Scene,
    comm: Any = None,
    *,
    energy: OwnLaw | None = None,
    growth_law: OwnLaw | None = None,
) -> Shell:
    """Discretised wall of a scene, unloaded, on all ranks of a communicator.

    Parameters
    ----------
    scene
        What to discretise.
    comm
        MPI communicator whose ranks share the wall; all ranks of the world if left out.
    energy, growth_law
        Laws in place of the scene's own. A growth law needs a scene with a growing zone.

    Raises
    ------
    TypeError, ValueError
        If a law gives no UFL expression, or one of a wrong shape, or raises; see `own_laws`.
    """
    if scene.growth is None and growth_law is not None:
        raise ValueError("a growth law needs a scene with a table [growth], for its zone")
    cut = discretise(scene)
    own = own_laws.growth_law(growth_law) if growth_law else None
    shell = Shell(
        cut,
        dx.MPI.COMM_WORLD if comm is None else comm,
        order=scene.numerics.order,
        thickness_points=scene.numerics.thickness_points,
        thickness=scene.wall.thickness,
        shear_modulus=scene.wall.shear_modulus,
        shear_penalty=scene.numerics.shear_penalty,
        energy=own_laws.energy_law(energy) if energy else strain_energy(scene.wall),
        thickness_ratio=thickness_ratio(scene.wall, cut),
        modulus_ratio=modulus_ratio(scene.wall, cut),
        growth_law=zone_law(scene, cut, own),
        per_grown=scene.wall.energy_per == "grown",
        thinning=thinning(scene.wall),
        bending=scene.wall.bending,
    )
    if shell.force is not None and scene.axial_load is not None:
        shell.force.value = scene.axial_load.force
    return shell


def turgor(scene: Scene) -> Callable[[float], float]:
    """Pressure in MPa at a time in min: as the scene has it, times a rise over the ramp."""
    pressure, ramp = scene.turgor.pressure, 0.0 if scene.run is None else scene.turgor.ramp

    def at(time: float) -> float:
        rise = min(1.0, time / ramp) if ramp > 0 else 1.0
        if isinstance(pressure, PressureTable):
            return rise * float(np.interp(time, pressure.time, pressure.value))
        return rise * pressure

    return at
