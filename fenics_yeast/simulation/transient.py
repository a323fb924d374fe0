"""A scene in time: loading, steps, and what ends them."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Generator, Sequence

from ..mechanics import Shell
from ..scene import PressureTable, Scene
from ..solve import (
    ApproachEnd,
    ButcherTableau,
    Equilibrium,
    EquilibriumError,
    PathError,
    Stability,
    StepController,
    StepResult,
    TimeStepper,
    approach_limit_point,
    find_limit_pressure,
    same_time,
)
from .checkpoint import Checkpoint
from .outcome import Outcome, limit_pressure_reached, softened
from .recorder import Recorder
from .result import Row, Timings

_FAILURES = 2  # failed fixed steps in a row after which a limit point is looked for
_FIRST_STEP = 1e-3  # of the characteristic time of growth, where steps are adaptive
_SLOW = 0.02  # rate V'/V0 of growth, times its characteristic time, below which it counts as slow
_FAST = 0.25  # rate V'/V above which it counts as fast, and errors are held to the volume itself
_STILL = 1e-7  # change of the volume in a step after which it is asked whether anything grows


class Transient:
    """A run of a scene in time, or to a single equilibrium.

    Parameters
    ----------
    scene, shell, equilibrium, stability
        What is run, its unloaded wall and the solvers.
    evolution, tableau
        The wall in time and the method of its steps.
    journal
        Takes note of all steps.
    tolerance
        Norm of the residual in µN at which it counts as zero.

    Attributes
    ----------
    checkpoint
        All that determines how the run goes on from the last step, with the arrays of this rank
        in its own order and without timings; None before the first.
    """

    def __init__(
        self,
        scene: Scene,
        shell: Shell,
        equilibrium: Equilibrium,
        stability: Stability,
        stepper: TimeStepper,
        tableau: ButcherTableau,
        recorder: Recorder,
        tolerance: float,
    ) -> None:
        self._scene, self._shell = scene, shell
        self._equilibrium, self._stability = equilibrium, stability
        self._stepper, self._tableau = stepper, tableau
        self._recorder, self._tolerance = recorder, tolerance
        self._stable = True
        self._cut = False
        self._switches = sorted(time for zone in scene.growing for time in zone.span)
        self._kinks = self._bends()
        self._steps = self._time_steps()
        self.checkpoint: Checkpoint | None = None

    @property
    def _time(self) -> float:
        return self._stepper.accepted.time

    def restore(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint, whose arrays are those of this rank."""
        self._equilibrium.restore(checkpoint.chord)
        self._stepper.restore(checkpoint.stepper)
        self._steps.restore(checkpoint.controller)
        self._stability.last = checkpoint.stability
        self._cut = checkpoint.step_reduced
        self.checkpoint = checkpoint

    def run(self) -> Generator[Row, None, Outcome]:
        """Run to the end, or to what ends the run; yields the row of each accepted state."""
        run, recorder, steps = self._scene.run, self._recorder, self._steps
        if self.checkpoint is None:
            if (lost := self._load()) is not None:
                return lost
            self._settle(0.0)
            yield recorder.rows[-1]
        if run is None:
            return Outcome("finished", "equilibrium found")
        while (end := self._propose(steps)) is not None:
            try:
                step = self._stepper.attempt(end)
            except EquilibriumError as error:
                recorder.reject(error.iterations)
                steps.failed()
                if steps.failures >= self._patience or steps.exhausted:
                    lost = yield from self._limit(end)
                    if lost is not None:
                        return lost
                    if steps.exhausted:
                        return self._failed(error)
                continue
            if self._past_limit():
                self._stepper.reject()
                recorder.reject(step.iterations)
                steps.failed()
                lost = yield from self._limit(end)
                if lost is not None:
                    return lost
                if steps.exhausted:
                    return self._failed(EquilibriumError("only states past a limit point", 0))
                continue
            if not self._good(steps, step, end):
                self._stepper.reject()
                recorder.reject(step.iterations)
                continue
            start = self._time
            self._stepper.accept(end)
            if _among(end, self._kinks):
                self._stepper.reset_predictor()
            if _among(end, self._switches):
                steps.reset()
            row = recorder.accept(end, end - start, step.iterations, self._stable)
            self._settle(end)
            yield row
        grown = recorder.rows[-1].max_growth_strain
        message = f"reached {run.end:g} min"
        if self._growing and grown == 0:
            message += "; nothing grew: the stress stays below the threshold"
        if self._cut:
            message += f"; steps were cut, for {self._tableau.name} is not stable in longer ones"
        elif steps.reductions and self._scene.numerics.step is not None:
            message += f"; fixed steps that found no equilibrium were cut: {steps.reductions}"
        return Outcome("finished", message)

    def _settle(self, time: float) -> None:
        """Keep what an accepted state at a time in min leaves, and what goes on from it."""
        run, recorder = self._scene.run, self._recorder
        if run is None or _among(time, run.save):
            recorder.save()
        self.checkpoint = Checkpoint(
            scene="",
            stepper=self._stepper.state(),
            chord=self._equilibrium.tangent,
            controller=self._steps.state(),
            stability=self._stability.last,
            step_reduced=self._cut,
            recorder=recorder.state(),
            timings=Timings(),
        )

    # --- loading --------------------------------------------------------------------------

    def _load(self) -> Outcome | None:
        """First equilibrium: at once, or where Newton's method fails or strays, step by step."""
        stepper, recorder = self._stepper, self._recorder
        try:
            iterations = stepper.load()
            if not self._past_limit():
                recorder.accept(0.0, 0.0, iterations, self._stable)
                return None
        except EquilibriumError as error:
            iterations = error.iterations
        recorder.reject(iterations)
        stepper.unload()
        try:
            limit = find_limit_pressure(self._shell, stepper.pressure(0.0), self._tolerance)
            if limit is not None:
                recorder.count_iterations(limit.iterations)
                return limit_pressure_reached(limit.pressure)
            iterations = stepper.load()
        except (EquilibriumError, PathError) as error:
            stepper.unload()
            return Outcome("failed", f"the wall finds no equilibrium under its pressure: {error}")
        self._past_limit()
        recorder.accept(0.0, 0.0, iterations, self._stable)
        return None

    # --- steps ----------------------------------------------------------------------------

    def _bends(self) -> list[float]:
        """Increasing times in min at which the pressure's slope changes, or growth switches."""
        turgor, run = self._scene.turgor, self._scene.run
        end = 0.0 if run is None else run.end
        times = turgor.pressure.time if isinstance(turgor.pressure, PressureTable) else ()
        inside = (t for t in (*times, *self._switches) if 0 < t < end)
        return sorted([min(turgor.ramp, end), *inside])

    def _time_steps(self) -> StepController:
        """Fixed steps, or steps that follow the estimated error of growth."""
        run, numerics, growth_time = self._scene.run, self._scene.numerics, self._scene.growth_time
        milestones = [] if run is None else [*self._kinks, *run.save, run.end]
        if numerics.step is not None:
            return StepController(milestones, numerics.step, None)
        if growth_time is None:
            return StepController(milestones, max(milestones, default=0.0) / 100, None)
        return StepController(milestones, _FIRST_STEP * growth_time, self._tableau.estimate_order)

    def _propose(self, steps: StepController) -> float | None:
        """End of the next step; where nothing will change, all the way to the next milestone."""
        rows = self._recorder.rows
        changed = abs(rows[-1].volume_um3 - rows[max(0, len(rows) - 2)].volume_um3)
        if changed <= _STILL * rows[-1].volume_um3:
            milestone = steps.propose_milestone(self._time)
            steady = milestone is None or not self._changing(milestone)
            if steady and self._stepper.at_rest:
                return milestone
        wanted, longest = steps.propose(self._time), self._stepper.longest_step
        if wanted is None or wanted - self._time <= longest:
            return wanted
        self._cut = self._cut or self._scene.numerics.step is not None
        return steps.propose(self._time, longest)

    @property
    def _growing(self) -> bool:
        return self._shell.growth is not None

    def _changing(self, end: float) -> bool:
        """Whether the pressure changes from now to a time before the next kink."""
        return self._stepper.pressure(end) != self._stepper.pressure(self._time)

    def _past_limit(self) -> bool:
        """Whether the trial is past a limit point, or inside out; notes whether it is stable."""
        self._stable = self._stability.negative_modes() == 0
        if self._stable:
            return False
        inside_out = self._scene.cell.closed and self._shell.volume() <= 0
        return self._equilibrium.compliance() < 0 or inside_out

    def _good(self, steps: StepController, step: StepResult, end: float) -> bool:
        """Whether the trial is good enough; adapts the steps."""
        if self._scene.numerics.step is not None:
            return steps.accepts(0.0)
        return steps.accepts(self._badness(self._stepper.volume_error(step), end - self._time))

    def _badness(self, error: float, dt: float) -> float:
        """Estimated error of the volume, 1 being the largest wanted.

        An error of the volume acts like a shift in time by it over `V'`, and shifts add up over
        the run: it is held against what the cell grows in the characteristic time. In fast growth
        the shift is multiplied by what is still to come, and it is held against the volume.
        """
        growth_time, recorder = self._scene.growth_time, self._recorder
        if growth_time is None:
            return 0.0
        volume = self._shell.volume()
        grown = abs(volume - recorder.rows[-1].volume_um3) * growth_time / dt
        grown = min(max(grown, _SLOW * recorder.volume_0), _FAST * volume)
        wanted = self._scene.numerics.tolerance * grown
        return abs(error) / (self._tableau.caution * wanted)

    @property
    def _patience(self) -> int:
        """Failed steps in a row after which a limit point is looked for.

        Adaptive steps are short where much happens: one that fails has met something.
        """
        return _FAILURES if self._scene.numerics.step is not None else 1

    # --- ends -----------------------------------------------------------------------------

    def _limit(self, end: float) -> Generator[Row, None, Outcome | None]:
        """Find out whether the wall loses its equilibrium on the way to a time, and tell."""
        if self._growing:
            lost = yield from self._meets_limit(end)
            return self._lost(end) if lost else None
        if not self._changing(end):
            return None
        start, pressure = self._time, self._stepper.pressure
        try:
            limit = find_limit_pressure(self._shell, pressure(end), self._tolerance)
        except PathError:
            limit = None
        if limit is None:
            self._stepper.reject()
            return None
        part = (limit.pressure - pressure(start)) / (pressure(end) - pressure(start))
        time = start + part * (end - start)
        if time > start:
            self._stepper.accept(time)
            yield self._recorder.accept(time, time - start, limit.iterations, True)
        else:
            self._stepper.reject()
        return limit_pressure_reached(limit.pressure, time)

    def _meets_limit(self, end: float) -> Generator[Row, None, bool]:
        """Whether a growing wall loses its equilibrium on the way to a time, followed by volume."""
        rate = self._volume_rate(end)
        if rate == 0:
            return False
        precision = self._scene.numerics.tolerance
        steps = approach_limit_point(
            self._stepper, self._tolerance, precision, rate, end, self._accept
        )
        check_convergence, spent = yield from steps
        self._stepper.reset_predictor()
        self._recorder.count_iterations(spent)
        return check_convergence is ApproachEnd.LIMIT

    def _volume_rate(self, end: float) -> float:
        """Rate of the volume in µm³/min: that of the last step, and what the pressure changes."""
        rows = self._recorder.rows
        last, before = rows[-1], rows[max(0, len(rows) - 2)]
        rate, slope = 0.0, self._slope(end)
        if last.step_min > 0:
            rate = (last.volume_um3 - before.volume_um3) / last.step_min
            slope -= (last.pressure_MPa - before.pressure_MPa) / last.step_min
        return rate + self._equilibrium.compliance() * slope if slope else rate

    def _slope(self, end: float) -> float:
        """Rate of the pressure in MPa/min from now to a time before the next kink."""
        pressure = self._stepper.pressure
        return (pressure(end) - pressure(self._time)) / (end - self._time)

    def _lost(self, end: float) -> Outcome:
        """Tell which of growth and pressure has brought a growing wall to its limit point."""
        last, growth_time = self._recorder.rows[-1], self._scene.growth_time
        if growth_time is not None and self._slope(end) * growth_time / last.pressure_MPa > 1:
            return limit_pressure_reached(last.pressure_MPa, last.time_min)
        return softened(last, self._scene.wall.energy_per == "reference")

    def _accept(self, iterations: int, step: float) -> Row:
        """Note a state accepted on the approach to a limit point."""
        stable = self._stability.negative_modes() == 0
        return self._recorder.accept(self._time, step, iterations, stable)

    def _failed(self, error: EquilibriumError) -> Outcome:
        return Outcome(
            "failed", f"no step beyond {self._time:g} min, however small, converged: {error}"
        )


def _among(time: float, times: Sequence[float]) -> bool:
    """Whether a time is one of some increasing ones."""
    after = bisect_left(times, time)
    return any(same_time(time, other) for other in times[max(0, after - 1) : after + 1])
