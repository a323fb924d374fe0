"""The runs that give the numbers of the hard cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import ufl
from closed_forms import MU, H, P, R, buckling

from fenics_yeast import Scene, simulate
from fenics_yeast.geometry import Discretisation, Interval, Sphere
from fenics_yeast.mechanics import Approximation, Law, Shell, WallProperties, growth_laws
from fenics_yeast.mechanics import hyperelasticity as wall
from fenics_yeast.simulation import Result, Status, build_shell
from fenics_yeast.solve import TABLEAUX, Equilibrium, TimeStepper

EDGE = R * np.pi * (1 - 24 / 180)  # arc length at the edge of the growing zone, µm

BUD = Scene.load(Path(__file__).parent / "scenes" / "bud.toml").with_values(
    {
        "numerics": {"preset": "default", "tolerance": 1e-4, "thickness_points": 3},
        "turgor.ramp": 0,
        "run": {"end": 80},
    }
)
SPHERE = BUD.with_values({"growth": None, "run": None})


@dataclass(frozen=True)
class Found:
    """Result of a case: status, number, Newton iterations and message."""

    status: Status
    value: float
    iterations: int
    message: str = ""


def found(result: Result, value: float) -> Found:
    return Found(result.status, float(value), result.newton_iterations, result.message)


def volume(scene: Scene, **laws: Law) -> Found:
    """Run a scene and find V/V0 at its end."""
    result = simulate(scene, **laws)
    return found(result, result.history.volume_ratio[-1] if len(result.history) else np.nan)


def burst(scene: Scene) -> Found:
    """Run a scene and find the time at which equilibrium is lost."""
    result = simulate(scene)
    return found(result, result.end_time)


def bud(values: dict[str, object], **laws: Law) -> Callable[[], Found]:
    return lambda: volume(BUD.with_values(values), **laws)


def slope(last: float) -> dict[str, object]:
    """Return a turgor that changes linearly from P to another pressure in MPa in 1000 min."""
    return {"time": [0, 1000], "value": [P, last]}


def until(end: float) -> dict[str, object]:
    return {"run": {"end": end}}


# Runs with laws, meshes or steps of their own ---------------------------------------------------


def stiffness_by_place(inside: float, outside: float) -> Law:
    """Return Ogden's energy with one shear modulus in the zone and another outside."""

    def energy(eps_e, mu_zone, mu_rest):  # type: ignore[no-untyped-def]
        S = ufl.SpatialCoordinate(ufl.domain.extract_domains(eps_e)[0])[0]
        mu = ufl.conditional(ufl.gt(S, EDGE), mu_zone, mu_rest)
        return wall.ogden(eps_e, mu, 2.0)

    return Law(energy, {"mu_zone": inside, "mu_rest": outside})


def growth_at_both_poles() -> Law:
    """Return equation (13) within 24° of either pole."""

    def rate(point, sigma_trs, t_grw):  # type: ignore[no-untyped-def]
        S = ufl.SpatialCoordinate(ufl.domain.extract_domains(point.eps)[0])[0]
        near_pole = ufl.Or(ufl.gt(S, EDGE), ufl.lt(S, np.pi * R - EDGE))
        grown = growth_laws.stress_driven(point, sigma_trs, t_grw)
        return ufl.conditional(near_pole, 1.0, 0.0) * grown

    return Law(rate, {"sigma_trs": 1.0, "t_grw": 45.0})


EVEN = {"numerics.elements": 60, "numerics.order": 4, "numerics.grading": "uniform"}
HALF = {"turgor.pressure": P / 2, "growth.threshold": 0.5}  # which a wall of μ/10 can carry


def two_poles() -> Found:
    """Find the growth of V/V0 at both poles over that at one."""
    whole = {**EVEN, "growth.zone.half_angle": 180.0}
    both = volume(BUD.with_values(whole), growth_law=growth_at_both_poles())
    one = volume(BUD.with_values(EVEN))
    start = volume(SPHERE.with_values(EVEN)).value
    return Found(both.status, (both.value - start) / (one.value - start), both.iterations)


def uneven_mesh() -> Found:
    """Find V/V0 at 80 min on 60 elements, alternately small and a thousand times larger."""
    zone = np.tile([1.0, 1000.0], 15)
    rest = np.tile([1000.0, 1.0], 15)
    nodes = np.concatenate([[0], EDGE * np.cumsum(rest) / rest.sum()])
    top = EDGE + (np.pi * R - EDGE) * np.cumsum(zone) / zone.sum()
    zone = (Interval(EDGE, np.pi * R),)
    mesh = Discretisation(Sphere(R), np.concatenate([nodes, top]), (zone,))
    from mpi4py import MPI

    law = Law(growth_laws.stress_driven, {"sigma_trs": 1.0, "t_grw": 45.0})
    energy = Law(wall.ogden, {"mu": MU, "alpha": 2.0})
    shell = Shell(
        mesh,
        WallProperties(thickness=H, shear_modulus=MU, energy=energy, growth_law=law),
        Approximation(order=3, thickness_points=3, shear_penalty=1000.0),
        MPI.COMM_WORLD,
    )
    unloaded = shell.volume()
    with Equilibrium(shell, 1e-7) as equilibrium:
        evolution = TimeStepper(shell, equilibrium, TABLEAUX["sdirk3"], lambda time: P)
        iterations = evolution.load()
        iterations += sum(evolution.step(time).iterations for time in np.arange(1.0, 81.0))
    return Found("finished", shell.volume() / unloaded, iterations)


def path(values: dict[str, object]) -> Scene:
    return SPHERE.with_values({"numerics.elements": 24, "numerics.order": 3, **values})


def largest_pressure(alpha: float) -> Found:
    """Find the largest p R/(μ h) on the path to V/V0 = 8."""
    goal = {"path": {"until": {"volume_ratio": 8.0}}, "wall.ogden_exponent": alpha}
    result = simulate(path(goal))
    return found(result, result.history.pressure_MPa.max() * R / (MU * H))


def buckles(h: float) -> Found:
    """Find the external pressure at which stability is lost, over the classical one."""
    goal = {"control": "pressure", "until": {"pressure": -1.1 * buckling(h)}, "steps": 110}
    elements = int(20 * np.sqrt(R / h))
    values = {"wall.thickness": h, "path": goal, "numerics.elements": elements}
    result = simulate(path({**values, "numerics.grading": "uniform"}))
    stable = result.history.stable
    last = np.flatnonzero(stable)[-1] if not stable.all() else 0
    lost = result.history.pressure_MPa[last : last + 2].mean()
    return found(result, lost / -buckling(h))


def membrane_error(ratio: float) -> Callable[[], Found]:
    """Return a run of an elastic sphere of some h/R at a given stress."""
    h = ratio * R
    values = {"wall.thickness": h, "turgor.pressure": P * h / H}
    return lambda: volume(SPHERE.with_values(values))


def deflated_and_back() -> Found:
    """Find V/V0 after turgor falls to 10 % and returns without growth, over V/V0 before."""
    shell = build_shell(BUD)
    with Equilibrium(shell, 1e-9) as equilibrium:
        evolution = TimeStepper(shell, equilibrium, TABLEAUX["sdirk3"], lambda time: P)
        iterations = evolution.load()
        iterations += sum(evolution.step(time).iterations for time in np.arange(2.0, 82.0, 2.0))
        before = shell.volume()
        for part in (0.4, 0.1, 0.4, 1.0):  # solving for equilibrium only, so nothing grows
            shell.pressure.value = part * P
            iterations += equilibrium.solve()
    return Found("finished", shell.volume() / before, iterations)


def turgor_off() -> Found:
    """Find V/V0 of a bud that has no turgor for ten of its 90 min.

    It differs from V/V0 at 80 min: at the zone's edge the residual stresses of growth exceed the
    threshold without turgor.
    """
    edges = [0, 40, 40.01, 50, 50.01]
    table = {"time": edges, "value": [P, P, 0, 0, P]}
    return volume(BUD.with_values({"turgor.pressure": table, **until(90.01)}))


def by_a_table() -> Found:
    """Find V/V0 of an elastic cell with turgor by times and values, halfway down a ramp."""
    table = {"time": [0, 30, 40], "value": [P, P, P / 10]}
    return volume(BUD.with_values({"growth": None, "turgor.pressure": table, **until(35)}))
