"""Runs in time: find the first equilibrium, take steps, and report how the run ends."""

from collections.abc import Generator
from contextlib import ExitStack
from typing import Any, Self

from ..mechanics import Shell
from ..scene import SHARES, Scene
from ..solve import (
    TABLEAUX,
    Equilibrium,
    EquilibriumError,
    PathError,
    Resumable,
    Stability,
    StepResult,
    TimeStepper,
    approach_limit_point,
    find_limit_pressure,
)
from .blow_up import blow_up_time
from .build import turgor
from .checkpoint import Checkpoint
from .error_estimate import estimate_error
from .history import Row
from .loading import load_in_parts
from .milestones import among, kinks, step_controller, switches
from .outcome import (
    Outcome,
    growth_limit_reached,
    growth_unbounded,
    limit_pressure_exceeded,
    stopped_at_contact,
    wall_softened,
)
from .recorder import Recorder
from .result import ErrorEstimate, Timings
from .step_errors import StepErrors

_FAILURES = 2  # failed fixed steps in a row after which a limit point is looked for
_UNCHANGED = 1e-7  # relative change of the volume in a step after which the wall may be at rest


class Transient:
    """A run of a scene in time, or to a single equilibrium; a context manager.

    `tolerance` is the norm of the residual in µN that counts as zero. `checkpoint` is the last one,
    with this rank's arrays and without timings; None before the first step.
    """

    def __init__(self, scene: Scene, shell: Shell, recorder: Recorder, tolerance: float) -> None:
        self._scene, self._shell = scene, shell
        self._recorder, self._tolerance = recorder, tolerance
        self._resources = ExitStack()
        self._equilibrium = self._resources.enter_context(Equilibrium(shell, tolerance))
        self._stability = self._resources.enter_context(Stability(shell))
        self._tableau = TABLEAUX[scene.numerics.integrator]
        self._stepper = TimeStepper(shell, self._equilibrium, self._tableau, turgor(scene))
        self._stable = True
        self._reduced = False
        self._switches, self._kinks = switches(scene), kinks(scene)
        self._controller = step_controller(
            scene, self._stepper.pressure, self._tableau.estimate_order
        )
        growth_time, allowed = scene.growth_time or 1.0, SHARES.steps * scene.numerics.tolerance
        self._errors = StepErrors(self._tableau, growth_time, shell.reference_volume, allowed)
        # By the names of a checkpoint. The solver comes first, as it moves the shell.
        self._resumable: dict[str, Resumable[Any]] = {
            "chord": self._equilibrium,
            "stepper": self._stepper,
            "controller": self._controller,
            "stability": self._stability,
            "errors": self._errors,
        }
        self.checkpoint: Checkpoint | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._resources.close()

    @property
    def _time(self) -> float:
        return self._stepper.accepted.time

    def restore(self, checkpoint: Checkpoint) -> None:
        """Continue from a checkpoint, whose arrays are those of this rank."""
        for name, part in self._resumable.items():
            part.restore(getattr(checkpoint, name))
        self._reduced = checkpoint.step_reduced
        self.checkpoint = checkpoint

    def run(self) -> Generator[Row, None, Outcome]:
        """Run to the end, or to what ends the run; yield the row of each accepted state."""
        recorder, controller = self._recorder, self._controller
        patience = 1 if self._scene.numerics.step is None else _FAILURES
        if self.checkpoint is None:
            if (lost := self._load()) is not None:
                return lost
            self._settle(0.0)
            yield recorder.rows[-1]
        if self._scene.run is None:
            return Outcome("finished", "equilibrium found")
        while (end := self._propose()) is not None:
            if self._scene.run.stop_at_contact and recorder.contact is not None:
                return stopped_at_contact(recorder.rows[recorder.contact])
            try:
                step = self._stepper.attempt(end)
            except EquilibriumError as error:
                problem: EquilibriumError | None = error
                iterations = error.iterations
            else:
                if not self._past_limit():
                    if row := self._accept_or_reject(step, end):
                        yield row
                        if (infinite := self._blow_up()) is not None:
                            return growth_unbounded(infinite, row)
                    continue
                self._stepper.reject()
                problem, iterations = None, step.iterations
            recorder.reject(iterations)
            controller.failed()
            if problem is None or controller.failures >= patience or controller.exhausted:
                lost = yield from self._find_limit(end)
                if lost is not None:
                    return lost
                if controller.exhausted:
                    return self._failed(problem or "only states past a limit point were found")
        return self._finished(self._scene.run.end)

    def _accept_or_reject(self, step: StepResult, end: float) -> Row | None:
        """Accept a trial that is accurate enough; return its row."""
        start, recorder = self._time, self._recorder
        if not self._accurate(step, end):
            self._stepper.reject()
            recorder.reject(step.iterations)
            return None
        self._stepper.accept(end)
        if among(end, self._kinks):
            self._stepper.reset_predictor()
        if among(end, self._switches):
            self._controller.reset()
        row = recorder.accept(end, end - start, step.iterations, self._stable)
        self._settle(end)
        return row

    def _settle(self, time: float) -> None:
        """Save a profile of the accepted state at a time in min, if due, and a checkpoint."""
        run, recorder = self._scene.run, self._recorder
        if run is None or among(time, run.save):
            recorder.save()
        self.checkpoint = Checkpoint(
            scene="",
            **{name: part.state() for name, part in self._resumable.items()},
            step_reduced=self._reduced,
            recorder=recorder.state(),
            timings=Timings(),
        )

    def estimate_error(self) -> ErrorEstimate:
        """Return the estimated error of V/V0 at the saved times, or at the end of the last step."""
        errors, rows = self._errors.state(), self._recorder.rows
        error, speed = errors.error, errors.speed
        if not speed and rows and rows[-1].step_min:
            change = rows[-1].volume_um3 - rows[-2].volume_um3
            speed = abs(change) / (rows[-1].step_min * rows[-1].volume_um3)
            error = errors.shift * speed
        return estimate_error(self._scene, error, speed)

    # --- loading --------------------------------------------------------------------------

    def _load(self) -> Outcome | None:
        """Find the first equilibrium: at once or, if Newton's method fails or strays, in parts."""
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
            iterations, lost = load_in_parts(self._scene, stepper, self._tolerance)
        except (EquilibriumError, PathError) as error:
            lost = self._softened("the initial loads")
            stepper.unload()
            return lost or Outcome("failed", f"no convergence under the initial loads: {error}")
        if lost is not None:
            recorder.iterations += iterations
            through = "; the wall has touched itself before" if recorder.in_contact() else ""
            return lost._replace(message=lost.message + through)
        self._past_limit()
        recorder.accept(0.0, 0.0, iterations, self._stable)
        return None

    # --- steps ----------------------------------------------------------------------------

    def _propose(self) -> float | None:
        """Return the end of the next step; where nothing will change, the next milestone."""
        rows, controller = self._recorder.rows, self._controller
        changed = abs(rows[-1].volume_um3 - rows[max(0, len(rows) - 2)].volume_um3)
        if changed <= _UNCHANGED * rows[-1].volume_um3:
            milestone = controller.propose_milestone(self._time)
            steady = milestone is None or not self._pressure_changes(milestone)
            if steady and self._stepper.at_rest:
                return milestone
        proposed, longest = controller.propose(self._time), self._stepper.longest_step
        if proposed is None or proposed - self._time <= longest:
            return proposed
        self._reduced = self._reduced or self._scene.numerics.step is not None
        return controller.propose(self._time, longest)

    def _pressure_changes(self, end: float) -> bool:
        """Whether the pressure changes from now to a time before the next kink."""
        return self._stepper.pressure(end) != self._stepper.pressure(self._time)

    def _past_limit(self) -> bool:
        """Whether the trial is past a limit point, or inside out; notes whether it is stable."""
        self._stable = self._stability.negative_modes() == 0
        if self._stable:
            return False
        inside_out = self._scene.cell.closed and self._shell.volume() <= 0
        return self._equilibrium.compliance() < 0 or inside_out

    def _accurate(self, step: StepResult, end: float) -> bool:
        """Whether the trial is accurate enough; adapts the steps and adds up their errors."""
        volume, before, start = self._shell.volume(), self._recorder.rows[-1], self._time
        error, change = self._stepper.volume_error(step), volume - before.volume_um3
        smooth = start >= self._scene.turgor.ramp and not among(start, self._kinks)
        adaptive, relative = self._scene.numerics.step is None, 0.0
        if adaptive and self._scene.growth_time is not None:
            relative = self._errors.relative(error, volume, change, end - start, smooth)
        if not self._controller.accepts(relative):
            return False
        saved = self._scene.run is not None and among(end, self._scene.run.save)
        self._errors.accept(error, volume, change, end - start, smooth=smooth, saved=saved)
        return True

    # --- ends -----------------------------------------------------------------------------

    def _find_limit(self, end: float) -> Generator[Row, None, Outcome | None]:
        """Return how the wall loses its equilibrium on the way to a time; None if it does not."""
        if self._shell.growth is not None and (yield from self._meets_growth_limit(end)):
            return self._lost(end)
        if not self._pressure_changes(end):
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
        return limit_pressure_exceeded(limit.pressure, time)

    def _blow_up(self) -> float | None:
        """Return the time in min at which the volume becomes infinite before any milestone."""
        infinite = blow_up_time(self._recorder.rows)
        milestone = self._controller.propose_milestone(self._time)
        return infinite if infinite and milestone and infinite < milestone else None

    def _meets_growth_limit(self, end: float) -> Generator[Row, None, bool]:
        """Whether a growing wall loses its equilibrium on the way to a time, followed by volume."""
        rate = self._volume_rate(end)
        if rate == 0:
            return False
        found, iterations = yield from approach_limit_point(
            self._stepper,
            self._tolerance,
            SHARES.steps * self._scene.numerics.tolerance,
            rate,
            end,
            self._accept,
        )
        self._stepper.reset_predictor()
        self._recorder.iterations += iterations
        return found

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
        """Which of growth and pressure has brought a growing wall to its limit point."""
        last, growth_time = self._recorder.rows[-1], self._scene.growth_time
        if growth_time is not None and self._slope(end) * growth_time / last.pressure_MPa > 1:
            return limit_pressure_exceeded(last.pressure_MPa, last.time_min)
        return growth_limit_reached(last, self._scene.wall.energy_per == "reference")

    def _accept(self, iterations: int, step: float) -> Row:
        """Record a state accepted on the approach to a limit point."""
        stable = self._stability.negative_modes() == 0
        return self._recorder.accept(self._time, step, iterations, stable)

    def _finished(self, end: float) -> Outcome:
        message = f"reached {end:g} min"
        if self._shell.growth is not None and self._recorder.rows[-1].max_growth_strain == 0:
            late = all(growth.begins >= end for growth in self._scene.growing)
            why = "growth.from is later" if late else "the stress stays below growth.threshold"
            message += f"; nothing grew: {why}"
        if self._reduced:
            message += f"; steps reduced to the stability limit of {self._tableau.name}"
        elif self._controller.reductions and self._scene.numerics.step is not None:
            reductions = self._controller.reductions
            message += f"; {reductions} fixed step{'s' * (reductions != 1)} reduced"
        return Outcome("finished", message)

    def _failed(self, reason: EquilibriumError | str) -> Outcome:
        where = f"{self._time:g} min"
        failed = f"no convergence beyond {where}, even with the smallest step: {reason}"
        rows = self._recorder.rows
        if (infinite := blow_up_time(rows, broken_off=True)) is not None:
            return growth_unbounded(infinite, rows[-1])
        return self._softened(where) or Outcome("failed", failed)

    def _softened(self, where: str) -> Outcome | None:
        """Return the end of a run if the wall, in its trial state, has no stiffness."""
        stretch = self._recorder.softest_stretch(self._scene.wall)
        return None if stretch is None else wall_softened(stretch, where)
