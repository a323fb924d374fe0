"""Runs a scene from start to end."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from time import perf_counter
from typing import Any

import numpy as np

from . import _dolfinx as dx
from . import own_laws, scene_laws
from .equilibrium import Equilibrium
from .evolution import Evolution
from .integrators import TABLEAUX
from .journal import Journal, ObserverError
from .march import March
from .meridian import discretise
from .outcome import Outcome, remarks
from .own_laws import OwnLaw
from .record import History, Observer, Profiles, Result, Timings
from .scene import PressureTable, Scene
from .shell import Shell
from .stability import Stability
from .walk import walk

_ROUND_OFF = 1e-12  # of the nodal forces, for those that would double the wall's length
_LOG = logging.getLogger(__name__)


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
    shell = Shell(
        cut,
        dx.MPI.COMM_WORLD if comm is None else comm,
        order=scene.numerics.order,
        thickness_points=scene.numerics.thickness_points,
        thickness=scene.wall.thickness,
        shear_modulus=scene.wall.shear_modulus,
        shear_penalty=scene.numerics.shear_penalty,
        energy=own_laws.energy_law(energy) if energy else scene_laws.strain_energy(scene.wall),
        thicker=scene_laws.thicker(scene.wall, cut),
        stiffer=scene_laws.stiffer(scene.wall, cut),
        growth_law=own_laws.growth_law(growth_law)
        if growth_law
        else scene_laws.growth_law(scene, cut),
        per_grown=scene.wall.energy_per == "grown",
        thinning=scene_laws.thinning(scene.wall),
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


def simulate(
    scene: Scene,
    *,
    energy: OwnLaw | None = None,
    growth_law: OwnLaw | None = None,
    observer: Observer | None = None,
    comm: Any = None,
) -> Result:
    """Run a scene from start to end.

    Whatever ends the run early is told in the result, with all that was computed before.

    Parameters
    ----------
    scene
        What to simulate.
    energy, growth_law
        Laws of your own in place of the scene's: strain energy of the wall, growth rate in the
        zone. Each is a function in UFL, or a `laws.Law` that gives it parameters.
    observer
        Is told of every accepted step and every saved profile, on rank 0 alone. What it raises
        ends the run and is raised here.
    comm
        MPI communicator whose ranks share the wall; all ranks of the world if left out. Every
        rank gets the history; the profiles are on rank 0.

    Returns
    -------
    Result
        History, profiles, and how the run ended.
    """
    began = perf_counter()
    shell = build_shell(scene, comm, energy=energy, growth_law=growth_law)
    journal = Journal(shell, observer)
    compiled = perf_counter()
    tolerance = _precision(scene) * _force(scene, len(shell.discretisation.nodes))
    with Equilibrium(shell, tolerance) as equilibrium, Stability(shell) as stability:

        def run() -> Outcome:
            if scene.path is not None:
                return walk(scene, scene.path, shell, stability, journal, tolerance)
            tableau = TABLEAUX[scene.numerics.integrator]
            evolution = Evolution(shell, equilibrium, tableau, turgor(scene))
            solvers = (equilibrium, stability, evolution, tableau)
            return March(scene, shell, *solvers, journal, tolerance).go()

        loop = perf_counter()
        outcome = _guarded(run, journal)
        loop_s = perf_counter() - loop - journal.output_s
    rows = journal.rows
    message = outcome.message + (remarks(rows) if outcome.status != "failed" else "")
    return Result(
        history=History(rows),
        profiles=Profiles(tuple(journal.profiles)),
        status=outcome.status,
        message=message,
        end_time=rows[-1].time_min if rows else 0.0,
        dofs=dx.size_of(shell.space),
        steps=max(0, len(rows) - 1),
        rejected_steps=journal.rejected,
        newton_iterations=journal.iterations,
        timings=Timings(
            compile_s=compiled - began,
            setup_s=loop - compiled,
            loop_s=loop_s,
            output_s=journal.output_s,
            total_s=perf_counter() - began,
        ),
    )


def _guarded(run: Callable[[], Outcome], journal: Journal) -> Outcome:
    """Outcome of a run that may be interrupted or break; its last state is kept."""
    try:
        outcome = run()
    except ObserverError as error:
        assert error.__cause__ is not None
        raise error.__cause__ from None
    except KeyboardInterrupt:
        time = journal.rows[-1].time_min if journal.rows else 0.0
        outcome = Outcome("interrupted", f"interrupted at {time:g} min")
    except Exception as error:
        _LOG.debug("the run broke", exc_info=True)
        outcome = Outcome("failed", f"the run broke: {type(error).__name__}: {error}")
    if outcome.status != "finished":
        with suppress(ObserverError):  # it has failed before, or fails in `finish` again
            journal.save()
    return outcome


def _precision(scene: Scene) -> float:
    """Relative size at which a residual counts as zero: below the errors of adaptive steps."""
    numerics = scene.numerics
    fixed = numerics.step is not None or scene.growth is None
    return 1e-8 if fixed else max(1e-10, min(1e-5, 0.05 * numerics.tolerance))


def _force(scene: Scene, nodes: int) -> float:
    """Size of the nodal forces of the load in µN, or of those that would strain the wall by 1 %.

    An open wall may bend under loads that hardly strain it, and a force is small beside turgor:
    then the size is that of the load, no smaller than what round-off allows.
    """
    radius, load = scene.cell.radius, scene.axial_load
    unit = scene.wall.shear_modulus * scene.wall.thickness / radius
    pressure = scene.turgor.pressure
    least = 0.01 * unit
    if scene.path is not None and not scene.path.until.of_load:
        pressure = scene.path.until.pressure or unit
    values = pressure.value if isinstance(pressure, PressureTable) else (pressure,)
    sizes = [abs(value) for value in values]
    if load is not None or not scene.cell.closed:
        slender = scene.wall.thickness / radius
        least = _ROUND_OFF / _precision(scene) * unit
        if scene.path is not None and scene.path.until.volume_ratio is not None:
            sizes = [slender**2 * unit if scene.wall.bending else unit]
        if load is not None:
            sizes += [abs(load.force) / radius**2]
        if scene.path is not None and scene.path.until.of_load:
            moved = scene.path.until.displacement or 0.0
            force = scene.path.until.force or unit * slender * radius * moved
            sizes += [abs(force) / radius**2]
    return float(max(*sizes, least) * radius**2 / nodes**0.5)
