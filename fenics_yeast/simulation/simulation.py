"""Runs a scene from start to end."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator
from contextlib import ExitStack
from time import perf_counter
from typing import Any, Self

import numpy as np

from .. import _dolfinx as dx
from ..mechanics import OwnLaw, Shell, own_laws
from ..scene import PressureTable, Scene
from ..solve import TABLEAUX, Equilibrium, Stability, TimeStepper
from . import build as scene_laws
from .checkpoint import Checkpoint, Start
from .checkpointer import Checkpointer, local
from .discretise import discretise
from .initial_state import set_initial_state
from .outcome import Outcome, stability_note
from .ranks import OtherRanks
from .recorder import ObserverError, Recorder
from .result import History, Observer, Profile, Profiles, Result, Row, Timings
from .static import run_path
from .transient import Transient

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
    own = own_laws.growth_law(growth_law) if growth_law else None
    shell = Shell(
        cut,
        dx.MPI.COMM_WORLD if comm is None else comm,
        order=scene.numerics.order,
        thickness_points=scene.numerics.thickness_points,
        thickness=scene.wall.thickness,
        shear_modulus=scene.wall.shear_modulus,
        shear_penalty=scene.numerics.shear_penalty,
        energy=own_laws.energy_law(energy) if energy else scene_laws.strain_energy(scene.wall),
        thickness_ratio=scene_laws.thickness_ratio(scene.wall, cut),
        modulus_ratio=scene_laws.modulus_ratio(scene.wall, cut),
        growth_law=scene_laws.growth_law(scene, cut, own),
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


class Simulation:
    """A scene on its way from start to end: an iterator over its accepted steps.

        with Simulation(scene) as simulation:
            for row in simulation:
                if row.bud_radius_um > 1.5:
                    break
        print(simulation.result.message)

    A loop that was left may be taken up again by another one before the end of the block. On
    several ranks all of them iterate, and meet the same rows.

    Parameters
    ----------
    scene, energy, growth_law, observer, callback, comm, state
        As in `simulate`.
    start
        Where an earlier run of the scene is taken up; the same on all ranks, but for profiles,
        which rank 0 alone needs.
    keep
        Is given a checkpoint of the last step every few seconds and at the end, on rank 0 alone;
        must be there on all ranks.

    Raises
    ------
    CheckpointError
        If the start is that of another wall.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        energy: OwnLaw | None = None,
        growth_law: OwnLaw | None = None,
        observer: Observer | None = None,
        callback: Callable[[Row], None] | None = None,
        comm: Any = None,
        state: Profile | None = None,
        start: Start | None = None,
        keep: Callable[[Checkpoint], None] | None = None,
    ) -> None:
        self._began = perf_counter()
        self._shell = shell = build_shell(scene, comm, energy=energy, growth_law=growth_law)
        called = None if callback is None else _Callback(callback)
        self._recorder = Recorder(shell, [each for each in (observer, called) if each is not None])
        if shell.comm.bcast(state is not None):
            set_initial_state(shell, state)
        compiled = perf_counter()
        tolerance = _precision(scene) * _force(scene, len(shell.discretisation.nodes))
        self._resources = resources = ExitStack()
        equilibrium = resources.enter_context(Equilibrium(shell, tolerance))
        stability = resources.enter_context(Stability(shell))
        self._others = resources.enter_context(OtherRanks(shell.comm))
        self._transient: Transient | None = None
        self._steps: Generator[Row, None, Outcome]
        if scene.path is not None:
            self._steps = run_path(scene, scene.path, shell, stability, self._recorder, tolerance)
        else:
            tableau = TABLEAUX[scene.numerics.integrator]
            stepper = TimeStepper(shell, equilibrium, tableau, turgor(scene))
            solvers = (equilibrium, stability, stepper, tableau)
            self._transient = Transient(scene, shell, *solvers, self._recorder, tolerance)
            self._steps = self._transient.run()
        self._before = Timings()
        if start is not None and self._transient is not None:
            self._transient.restore(local(start.checkpoint, shell))
            self._recorder.restore(start.checkpoint.recorder, start.rows, start.profiles)
            self._before = start.checkpoint.timings
        self._checkpointer = (
            None if keep is None else Checkpointer(shell, scene, self._recorder, keep)
        )
        self._outcome: Outcome | None = None
        self._compile_s = compiled - self._began
        self._setup_s = perf_counter() - compiled
        self._run_s = self._total_s = 0.0
        self._lap: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Row:
        """Take the next step.

        Raises
        ------
        KeyboardInterrupt
            If it is interrupted; the run has then ended and has its result.
        """
        if self._outcome is not None:
            raise StopIteration
        self._lap = perf_counter()
        try:
            row = next(self._steps)
            if self._checkpointer is not None and self._transient is not None:
                self._checkpointer.offer(self._transient.checkpoint, self._timings())
            return row
        except StopIteration as end:
            self._end(end.value)
        except ObserverError as error:
            self._others.wait(error)
            self._free(Outcome("failed", f"the run broke: {error}"))
            raise error.__cause__ or error from None
        except KeyboardInterrupt as interrupt:
            self._interrupted(interrupt)
            raise
        except Exception as error:
            _LOG.debug("the run broke", exc_info=True)
            self._others.wait(error)
            self._end(Outcome("failed", f"the run broke: {type(error).__name__}: {error}"))
        finally:
            self._run_s, self._lap = self._in_steps(), None
        raise StopIteration

    def close(self) -> None:
        """End the run where it is, with the profile of its last state, and free the solvers."""
        if self._outcome is None:
            self._end(Outcome("interrupted", f"stopped at {self._time:g} min"))

    @property
    def result(self) -> Result:
        """What was found so far, and how the run ended; interrupted, as long as it has not."""
        rows, recorder = self._recorder.rows, self._recorder
        status, message = self._outcome or Outcome("interrupted", f"at {self._time:g} min so far")
        return Result(
            history=History(rows),
            profiles=Profiles(tuple(recorder.profiles)),
            status=status,
            message=message + (stability_note(rows) if status != "failed" else ""),
            end_time=self._time,
            dofs=dx.size_of(self._shell.space),
            steps=max(0, len(rows) - 1),
            rejected_steps=recorder.rejected,
            newton_iterations=recorder.iterations,
            timings=self._timings(),
        )

    @property
    def _time(self) -> float:
        """Time of the last accepted state in min."""
        rows = self._recorder.rows
        return rows[-1].time_min if rows else 0.0

    def _interrupted(self, interrupt: KeyboardInterrupt) -> None:
        """End a run in its last state, unless it has ended."""
        if self._outcome is None:
            self._others.wait(interrupt)
            self._end(Outcome("interrupted", f"interrupted at {self._time:g} min"))

    def _end(self, outcome: Outcome) -> None:
        """Keep what an ended run leaves."""
        self._outcome = outcome
        self._steps.close()
        try:
            if outcome.status != "finished":
                self._recorder.save()
            if self._checkpointer is not None and self._transient is not None:
                self._checkpointer.finish(self._transient.checkpoint, self._timings())
        except ObserverError:  # it has failed before, or fails where the run is completed
            pass
        finally:
            self._free(outcome)

    def _free(self, outcome: Outcome) -> None:
        self._outcome = outcome
        self._steps.close()
        self._resources.close()
        self._total_s = perf_counter() - self._began

    def _in_steps(self) -> float:
        """Seconds in the steps so far, between which the caller does what it likes."""
        return self._run_s + (0.0 if self._lap is None else perf_counter() - self._lap)

    def _timings(self) -> Timings:
        """Where the time went so far, earlier parts of the run included."""
        output_s = self._recorder.output_s
        return self._before + Timings(
            compile_s=self._compile_s,
            setup_s=self._setup_s,
            loop_s=self._in_steps() - output_s,
            output_s=output_s,
            total_s=self._total_s or perf_counter() - self._began,
        )


class _Callback:
    """A function as an observer of the accepted states."""

    def __init__(self, call: Callable[[Row], None]) -> None:
        self.accepted = call

    def saved(self, profile: Profile) -> None:
        """Nothing: the function asks for the rows."""


def simulate(
    scene: Scene,
    *,
    energy: OwnLaw | None = None,
    growth_law: OwnLaw | None = None,
    observer: Observer | None = None,
    callback: Callable[[Row], None] | None = None,
    comm: Any = None,
    state: Profile | None = None,
    start: Start | None = None,
    keep: Callable[[Checkpoint], None] | None = None,
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
        ends the run and is raised here; other ranks raise a RuntimeError in its place.
    callback
        Called with the row of every accepted step: an observer in a word.
    comm
        MPI communicator whose ranks share the wall; all ranks of the world if left out. Every
        rank gets the history; the profiles are on rank 0.
    state
        The wall at time 0, in place of the unloaded one: a profile of a run on the same nodes,
        or of one of which the scene is a piece (see `septum`).
    start, keep
        Where an earlier run is taken up, and what checkpoints are given to, as in `Simulation`.

    Returns
    -------
    Result
        History, profiles, and how the run ended.
    """
    with Simulation(
        scene,
        energy=energy,
        growth_law=growth_law,
        observer=observer,
        callback=callback,
        comm=comm,
        state=state,
        start=start,
        keep=keep,
    ) as simulation:
        try:
            for _ in simulation:
                pass
        except KeyboardInterrupt as interrupt:  # told in the result
            simulation._interrupted(interrupt)  # if that was between two steps
        return simulation.result


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
