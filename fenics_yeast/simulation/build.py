"""Build the shell of a scene: its laws, with parameters that vary from zone to zone."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array, Discretisation, Intervals, Pole
from ..mechanics import (
    Approximation,
    Gaussian,
    Law,
    OwnLaw,
    Parameter,
    Shell,
    WallProperties,
    Weight,
    growth_laws,
    hyperelasticity,
    own_energy,
    own_growth_law,
)
from ..scene import AnyWall, Growth, LinearWall, OgdenWall, PressureTable, Scene, Wall
from .discretise import discretise


def strain_energy(material: AnyWall) -> Law:
    """Return the strain energy of a scene's wall."""
    match material:
        case Wall(shear_modulus=mu, ogden_exponent=alpha):
            return Law(hyperelasticity.ogden, {"mu": mu, "alpha": alpha})
        case OgdenWall(shear_moduli=moduli, ogden_exponents=exponents):
            terms = {f"mu_{i}": mu for i, mu in enumerate(moduli)}
            terms |= {f"alpha_{i}": alpha for i, alpha in enumerate(exponents)}
            return Law(hyperelasticity.ogden_sum, terms)
        case LinearWall(young_modulus=young, poisson_ratio=poisson):
            return Law(hyperelasticity.saint_venant_kirchhoff, {"young": young, "poisson": poisson})


def thinning(material: AnyWall) -> Law | None:
    """Return the strain through a scene's wall; None for constant thickness."""
    if material.thickness_change == "none":
        return None
    if isinstance(material, LinearWall):
        nu = material.poisson_ratio
        return Law(hyperelasticity.saint_venant_kirchhoff_thinning, {"poisson": nu})
    return Law(hyperelasticity.incompressible_thinning)


def zone_law(scene: Scene, mesh: Discretisation, own: Law | None = None) -> Law | None:
    """Return the growth rate of a scene's zones; None if the meridian has none.

    A user's own rate replaces equation (13), its threshold and time; the scene's zones, times and
    weights still apply to it.

    Raises
    ------
    ValueError
        If the scene weights the threshold, which a user's own rate lacks.
    """
    if not mesh.growing:
        return None
    parameters: dict[str, Parameter] = {
        "sigma_trs": by_zone(mesh.zones, [zone.threshold for zone in scene.growing]),
        "t_grw": by_zone(mesh.zones, [zone.time for zone in scene.growing]),
    }
    law = own or Law(growth_laws.stress_driven, parameters)
    rates, stresses = [], []
    for whole, zone in zip(mesh.zones, scene.growing, strict=True):
        of_rate = zone.polarity and zone.polarity.weight == "rate"
        for parts, gaussian in _gaussians(whole, zone, scene, mesh):
            rates.append(Weight(parts, zone.span, gaussian if of_rate else None))
            stresses.append(Weight(parts, gaussian=None if of_rate else gaussian))
    if any(weight != Weight(weight.parts) for weight in stresses):
        if own is not None:
            raise ValueError(
                'a growth law of your own has no threshold; polarity.weight must be "rate"'
            )
        law = Law(law.function, {**law.parameters, "of_stress": tuple(stresses)})
    if any(weight != Weight(weight.parts) for weight in rates):
        rate = growth_laws.weighted(law.function)
        law = Law(rate, {**law.parameters, "of_rate": tuple(rates)})
    return law


def _gaussians(
    parts: Intervals, zone: Growth, scene: Scene, mesh: Discretisation
) -> list[tuple[Intervals, Gaussian | None]]:
    """Return the parts of a zone, each with the Gaussian by which growth falls off there."""
    polarity = zone.polarity
    if polarity is None:
        return [(parts, None)]
    if polarity.centre is not None:
        # Straight elements are a little shorter.
        curve, (centre,) = scene.cell.reference(np.array([polarity.centre]))
        scale = mesh.curve.length / curve.length
        return [(parts, Gaussian(float(centre) * scale, polarity.width))]
    if polarity.pole == "both":  # caps that may meet at their edges
        lower = tuple(part for part in parts if part.start + part.end < mesh.curve.length)
        upper = tuple(part for part in parts if part not in lower)
        halves: list[tuple[Intervals, Pole]] = [(lower, "bottom"), (upper, "top")]
    else:
        halves = [(parts, polarity.pole or "top")]
    ends = {"bottom": 0.0, "top": mesh.curve.length}
    tip = polarity.follow == "tip"
    return [(half, Gaussian(pole if tip else ends[pole], polarity.width)) for half, pole in halves]


def thickness_ratio(material: AnyWall, mesh: Discretisation) -> Parameter | None:
    """Return thickness over that outside the zones; None for 1 everywhere."""
    if not material.zone:
        return None
    values = [(zone.thickness or material.thickness) / material.thickness for zone in material.zone]
    return by_zone(mesh.wall_zones, values, 1.0)


def modulus_ratio(material: AnyWall, mesh: Discretisation) -> Parameter | None:
    """Return moduli over those outside the zones; None for 1 everywhere."""
    if not material.zone:
        return None
    mu = material.shear_modulus
    values = [zone.modulus_factor or (zone.shear_modulus or mu) / mu for zone in material.zone]
    return by_zone(mesh.wall_zones, values, 1.0)


def by_zone(
    zones: Sequence[Intervals], values: Sequence[float], outside: float | None = None
) -> Parameter:
    """Return a function of arc length with one value per zone; a number if all are equal.

    `outside` is the value outside all zones; None if it is never evaluated there.
    """
    rest = values[0] if outside is None else outside
    if {*values, rest} == {rest}:
        return rest

    def at(S: Array) -> Array:
        # Edges of zones are nodes, so that no quadrature point lies on one.
        field = np.full_like(S, rest)
        for parts, value in zip(zones, values, strict=True):
            for part in parts:
                field[part.holds(S)] = value
        return field

    return at


def build_shell(
    scene: Scene,
    comm: Any = None,
    *,
    energy: OwnLaw | None = None,
    growth_law: OwnLaw | None = None,
    counts: Sequence[int] = (),
) -> Shell:
    """Return the unloaded shell of a scene, on all ranks of a communicator.

    By default, all ranks of the world share the wall. Laws of the user's own replace those of the
    scene; a growth law needs a scene with a growing zone. `counts` are as in `discretise`.

    Raises
    ------
    TypeError, ValueError
        If a law of the user's own is invalid; see `mechanics.own_energy`.
    """
    if scene.growth is None and growth_law is not None:
        raise ValueError("a growth law needs a scene with a table [growth] that gives its zone")
    mesh = discretise(scene, counts)
    wall = wall_of(scene, mesh, energy, growth_law)
    comm = dx.MPI.COMM_WORLD if comm is None else comm

    def make() -> Shell:
        shell = Shell(mesh, wall, approximation_of(scene), comm)
        _ = shell.point_fields  # which every run needs
        return shell

    shell = dx.compiled_together(comm, make)
    set_force(scene, shell)
    return shell


def wall_of(
    scene: Scene,
    mesh: Discretisation,
    energy: OwnLaw | None = None,
    growth_law: OwnLaw | None = None,
) -> WallProperties:
    """Return what the wall of a scene is made of, on a mesh; see `build_shell`."""
    material = scene.wall
    own = own_growth_law(growth_law) if growth_law else None
    return WallProperties(
        thickness=material.thickness,
        shear_modulus=material.shear_modulus,
        energy=own_energy(energy) if energy else strain_energy(material),
        growth_law=zone_law(scene, mesh, own),
        thickness_ratio=thickness_ratio(material, mesh),
        modulus_ratio=modulus_ratio(material, mesh),
        energy_per_grown_volume=material.energy_per == "grown",
        thinning=thinning(material),
        bending=material.bending,
    )


def approximation_of(scene: Scene) -> Approximation:
    """Return how the wall of a scene is approximated."""
    numerics = scene.numerics
    return Approximation(
        numerics.order,
        numerics.thickness_points,
        numerics.shear_penalty,
        numerics.thickness_rule,
    )


def set_force(scene: Scene, shell: Shell) -> None:
    """Set the force of a scene on its shell."""
    if shell.force is not None and scene.axial_load is not None:
        shell.force.value = scene.axial_load.force


def turgor(scene: Scene) -> Callable[[float], float]:
    """Return the pressure in MPa as a function of time in min, with its rise over the ramp."""
    pressure, ramp = scene.turgor.pressure, 0.0 if scene.run is None else scene.turgor.ramp

    def at(time: float) -> float:
        rise = min(1.0, time / ramp) if ramp > 0 else 1.0
        if isinstance(pressure, PressureTable):
            return rise * float(np.interp(time, *pressure.ramps))
        return rise * pressure

    return at
