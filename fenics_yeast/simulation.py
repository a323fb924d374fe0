"""Runs a scene from start to end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from . import _dolfinx as dx
from . import growth, wall
from .equilibrium import Equilibrium, EquilibriumError
from .evolution import Evolution
from .integrators import TABLEAUX
from .laws import Law
from .limit_point import Approach, approach
from .meridian import discretise
from .probe import Probe
from .record import History, Observer, Profile, Profiles, Result, Row, Status, Timings
from .scene import PressureTable, Scene
from .shell import Shell
from .stability import Stability
from .time_steps import TimeSteps

_FAILURES = 2  # failed steps in a row after which a limit point is looked for
_FIRST_STEP = 1e-3  # of the characteristic time of growth, where steps are adaptive
_SLOW = 0.02  # rate V'/V0 of growth, times its characteristic time, below which it counts as slow


def build_shell(scene: Scene, comm: Any = None) -> Shell:
    """Discretised wall of a scene, unloaded, on all ranks of a communicator."""
    mu, alpha = scene.wall.shear_modulus, scene.wall.ogden_exponent
    growth_law = None
    if scene.growth is not None:
        parameters = {"sigma_trs": scene.growth.threshold, "t_grw": scene.growth.time}
        growth_law = Law(growth.stress_driven, parameters)
    return Shell(
        discretise(scene),
        dx.MPI.COMM_WORLD if comm is None else comm,
        order=scene.numerics.order,
        thickness_points=scene.numerics.thickness_points,
        thickness=scene.wall.thickness,
        shear_modulus=mu,
        shear_penalty=scene.numerics.shear_penalty,
        energy=Law(wall.ogden, {"mu": mu, "alpha": alpha}),
        growth_law=growth_law,
    )


def turgor(scene: Scene) -> Callable[[float], float]:
    """Pressure in MPa at a time in min: as the scene has it, times a rise over the ramp."""
    pressure, ramp = scene.turgor.pressure, 0.0 if scene.run is None else scene.turgor.ramp

    def at(time: float) -> float:
        rise = min(1.0, time / ramp) if ramp > 0 else 1.0
        if isinstance(pressure, PressureTable):
            return rise * float(np.interp(time, pressure.time, pressure.value))
        return rise * pressure

    return at


def simulate(scene: Scene, *, observer: Observer | None = None, comm: Any = None) -> Result:
    """Run a scene from start to end.

    Whatever ends the run early is told in the result, with all that was computed before.

    Parameters
    ----------
    scene
        What to simulate.
    observer
        Is told of every accepted step and every saved profile, on rank 0 alone.
    comm
        MPI communicator whose ranks share the wall; all ranks of the world if left out. Every
        rank gets the history; the profiles are on rank 0.

    Returns
    -------
    Result
        History, profiles, and how the run ended.
    """
    return _Run(scene, observer, comm).go()


class _Run:
    """One run: its parts and what it has found so far."""

    def __init__(self, scene: Scene, observer: Observer | None, comm: Any) -> None:
        self._began = perf_counter()
        self._scene, self._observer = scene, observer
        self._shell = build_shell(scene, comm)
        self._probe = Probe(self._shell)
        self._timings = Timings(compile_s=perf_counter() - self._began)
        self._volume_0 = self._shell.volume()
        self._rows: list[Row] = []
        self._profiles: list[Profile] = []
        self._rejected = self._iterations = 0
        self._output_s = 0.0
        self._saved_at = -1.0

    def go(self) -> Result:
        """Run to the end, or to what ends the run."""
        numerics = self._scene.numerics
        self._tableau = TABLEAUX[numerics.integrator]
        self._precision = 1e-9 if numerics.step else min(1e-5, 0.05 * numerics.tolerance)
        with (
            Equilibrium(self._shell, self._precision * self._force()) as self._equilibrium,
            Stability(self._shell) as self._stability,
        ):
            pressure = turgor(self._scene)
            self._evolution = Evolution(self._shell, self._equilibrium, self._tableau, pressure)
            setup = perf_counter() - self._began - self._timings.compile_s
            self._timings = replace(self._timings, setup_s=setup)
            loop = perf_counter()
            status, message = self._guarded()
            loop = perf_counter() - loop - self._output_s
        return self._result(status, message, loop)

    def _force(self) -> float:
        """Size of the nodal forces of the load, or of those that would strain the wall by 1 %."""
        cell, wall_ = self._scene.cell, self._scene.wall
        least = 0.01 * wall_.shear_modulus * wall_.thickness / cell.radius
        given = self._scene.turgor.pressure
        values = given.value if isinstance(given, PressureTable) else (given,)
        pressure = max(*map(abs, values), least)
        return pressure * cell.radius**2 / len(self._shell.discretisation.nodes) ** 0.5

    def _guarded(self) -> tuple[Status, str]:
        try:
            return self._steps()
        except KeyboardInterrupt:
            self._keep_last()
            return "interrupted", f"interrupted at {self._time:g} min"

    @property
    def _time(self) -> float:
        return self._evolution.state.time

    def _steps(self) -> tuple[Status, str]:
        evolution, run = self._evolution, self._scene.run
        try:
            self._accept(evolution.load(), 0.0)
        except EquilibriumError as error:
            self._iterations += error.iterations
            return self._lost("the wall finds no equilibrium under its pressure", error)
        if run is None:
            self._save()
            return "finished", "equilibrium found"
        ramp = min(self._scene.turgor.ramp, run.end)
        steps = self._time_steps([ramp, *run.save, run.end])
        while (end := steps.propose(self._time)) is not None:
            try:
                step = evolution.attempt(end)
            except EquilibriumError as error:
                self._reject(error.iterations)
                steps.failed()
                if steps.exhausted:
                    return self._failed(error)
                if steps.failures >= _FAILURES and self._time >= ramp and self._meets_limit(end):
                    return self._limit()
                continue
            start, volume = self._time, self._shell.volume()
            if self._stability.falling() > 0:
                evolution.reject()
                self._reject(step.iterations)
                steps.failed()
                if self._meets_limit(end):
                    return self._limit()
                continue
            badness = 0.0
            if self._scene.numerics.step is None:
                badness = self._badness(evolution.volume_error(step), end - start, volume)
            if not steps.judge(badness):
                evolution.reject()
                self._reject(step.iterations)
                continue
            evolution.accept(end)
            if end == ramp:
                evolution.forget()
            self._accept(step.iterations, end - start)
            if end in run.save:
                self._save()
        return "finished", f"reached {run.end:g} min"

    def _meets_limit(self, end: float) -> bool:
        """Whether the wall loses its equilibrium on the way to a time, followed by volume."""
        before = self._rows[-2] if len(self._rows) > 1 else self._rows[-1]
        grown = self._rows[-1].volume_um3 - before.volume_um3
        if self._shell.growth is None or grown <= 0:
            return False
        rate = grown / self._rows[-1].step_min
        tolerance = self._precision * self._force()
        verdict, spent = approach(self._evolution, tolerance, rate, end, self._accept)
        self._iterations += spent
        return verdict is Approach.LIMIT

    def _limit(self) -> tuple[Status, str]:
        self._keep_last()
        ratio = self._rows[-1].volume_ratio
        return "no-equilibrium", (
            f"beyond {self._time:.2f} min, at V/V0 = {ratio:.4f}, there is no equilibrium: "
            "the wall has grown so soft that it can no longer carry the turgor"
        )

    def _failed(self, error: EquilibriumError) -> tuple[Status, str]:
        self._keep_last()
        return "failed", f"no step beyond {self._time:g} min, however small, converged: {error}"

    def _reject(self, iterations: int) -> None:
        self._rejected += 1
        self._iterations += iterations

    def _time_steps(self, milestones: list[float]) -> TimeSteps:
        """Fixed steps, or steps that follow the estimated error of growth."""
        numerics, growing = self._scene.numerics, self._scene.growth
        if numerics.step is not None:
            return TimeSteps(milestones, numerics.step, None)
        if growing is None:
            return TimeSteps(milestones, milestones[-1] / 100, None)
        return TimeSteps(milestones, _FIRST_STEP * growing.time, self._tableau.estimate_order)

    def _badness(self, error: float, dt: float, volume: float) -> float:
        """Estimated error of the volume, 1 being the largest wanted.

        An error of the volume acts like a shift in time by it over `V'`, and shifts add up over
        the run: it is held against what the cell grows in the characteristic time.
        """
        growing = self._scene.growth
        if growing is None:
            return 0.0
        grown = abs(volume - self._rows[-1].volume_um3) * growing.time / dt
        wanted = self._scene.numerics.tolerance * max(grown, _SLOW * self._volume_0)
        return abs(error) / (self._tableau.caution * wanted)

    def _lost(self, what: str, error: EquilibriumError) -> tuple[Status, str]:
        return "failed", f"{what}: {error}"

    def _accept(self, iterations: int, step: float) -> None:
        """Note an accepted state and tell the observer."""
        shell, sizes = self._shell, self._probe.sizes()
        self._iterations += iterations
        volume = shell.volume()
        row = Row(
            time_min=self._time,
            pressure_MPa=float(shell.pressure.value),
            volume_um3=volume,
            volume_ratio=volume / self._volume_0,
            pole_height_um=sizes.pole_height,
            bud_radius_um=sizes.bud_radius,
            neck_radius_um=sizes.neck_radius,
            max_growth_strain=sizes.max_growth_strain,
            dissipation_rate=shell.dissipation_rate(),
            step_min=step,
            newton_iterations=iterations,
        )
        self._rows.append(row)
        if self._observer is not None and shell.comm.rank == 0:
            began = perf_counter()
            self._observer.accepted(row)
            self._output_s += perf_counter() - began

    def _save(self) -> None:
        """Keep the profile of the accepted state."""
        began = perf_counter()
        self._saved_at = self._time
        profile = self._probe.profile(self._time)
        if profile is not None:
            self._profiles.append(profile)
            if self._observer is not None:
                self._observer.saved(profile)
        self._output_s += perf_counter() - began

    def _keep_last(self) -> None:
        """Keep the profile of the last accepted state of a run that ends early."""
        if self._rows and self._saved_at != self._time:
            self._save()

    def _result(self, status: Status, message: str, loop: float) -> Result:
        index_map = self._shell.space.dofmap.index_map
        return Result(
            history=History(self._rows),
            profiles=Profiles(tuple(self._profiles)),
            status=status,
            message=message,
            end_time=self._time,
            dofs=index_map.size_global,
            steps=max(0, len(self._rows) - 1),
            rejected_steps=self._rejected,
            newton_iterations=self._iterations,
            timings=replace(
                self._timings,
                loop_s=loop,
                output_s=self._output_s,
                total_s=perf_counter() - self._began,
            ),
        )
