"""Runs in time: find the first equilibrium, take steps, and report how the run ends."""

from collections.abc import Generator, Sequence
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
)
from .bifurcation import FallingModes, end_before
from .blow_up import blow_up_time
from .build import turgor
from .checkpoint import Checkpoint
from .error_estimate import estimate_error
from .history import Row
from .kinks import kinks, switches
from .limit_search import LimitSearch
from .loading import load_in_parts
from .milestones import among, memory, step_controller
from .outcome import (
    Outcome,
    buckled,
    growth_unbounded,
    reached_end,
    stopped_at_bifurcation,
    stopped_at_contact,
    wall_softened,
)
from .recorder import Recorder
from .result import ErrorEstimate, Timings
from .step_errors import StepErrors
from .waves import WaveCheck

_SHORTEST = 5  # last steps before no further one is found, in which the wall hardly moves
_FAILURES = 2  # failed fixed steps in a row after which a limit point is looked for
_UNCHANGED = 1e-7  # relative change of the volume in a step after which the wall may be at rest


class Transient:
    """A run of a scene in time, or to a single equilibrium; a context manager.

    `tolerance` is the norm of the residual in µN that counts as zero, `isotropic` says that the law
    is the scene's; `steps` are the ends of given steps in min. `checkpoint` is the last one, with
    this rank's arrays and without timings; None before the first step.
    """

    def __init__(
        self,
        scene: Scene,
        shell: Shell,
        recorder: Recorder,
        tolerance: float,
        isotropic: bool,
        steps: Sequence[float] = (),
    ) -> None:
        self._scene, self._shell = scene, shell
        self._recorder, self._tolerance = recorder, tolerance
        self._resources = ExitStack()
        self._equilibrium = self._resources.enter_context(Equilibrium(shell, tolerance))
        self._stability = self._resources.enter_context(Stability(shell))
        self._tableau = TABLEAUX[scene.numerics.integrator]
        parts = self._equilibrium, self._tableau, turgor(scene), memory(scene), recorder.follower
        self._stepper = TimeStepper(shell, *parts)
        self._stable, self._reduced = True, False
        self._passed: int | None = None
        self._waves = self._resources.enter_context(WaveCheck(scene, shell, recorder, isotropic))
        self._switches, self._kinks = switches(scene), kinks(scene)
        self._controller = step_controller(
            scene, self._stepper.pressure, self._tableau.estimate_order, steps
        )
        growth_time, allowed = scene.growth_time or 1.0, SHARES.steps * scene.numerics.tolerance
        self._errors = StepErrors(self._tableau, growth_time, shell.reference_volume, allowed)
        self._limits = LimitSearch(
            scene, self._stepper, self._equilibrium, recorder, tolerance, self._accept
        )
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
        if (lost := self._limits.thinned()) is not None:
            return lost
        if self._scene.run is None:
            return Outcome("finished", "equilibrium found")
        while (end := self._propose()) is not None:
            if self._scene.run.stop_at_contact and recorder.contact is not None:
                return stopped_at_contact(recorder.rows[recorder.contact])
            if self._scene.run.stop_at_bifurcation and recorder.bifurcation:
                return stopped_at_bifurcation(recorder.bifurcation[1])
            try:
                step, waves = self._stepper.attempt(end), None
                if not (past := self._past_limit() or self._limits.jumped()):
                    step, end, waves = self._stop_at_bifurcation(step, end)
            except EquilibriumError as error:
                problem: EquilibriumError | None = error
                iterations = error.iterations
            else:
                if not past:
                    if row := self._accept_or_reject(step, end, waves):
                        yield row
                        if (infinite := self._blow_up()) is not None:
                            return growth_unbounded(infinite, row)
                        if (lost := self._limits.thinned()) is not None:
                            return lost
                    continue
                self._stepper.reject()
                problem, iterations = None, step.iterations
            recorder.reject(iterations)
            controller.failed()
            if problem is None or controller.failures >= patience or controller.exhausted:
                lost = yield from self._limits.find(end)
                if lost is not None:
                    return lost
                if controller.exhausted:
                    return self._failed(problem or "only states past a limit point were found")
        return self._finished(self._time)

    def _stop_at_bifurcation(
        self, step: StepResult, end: float
    ) -> tuple[StepResult, float, int | None]:
        """Shorten a trial that passes the first bifurcation to one that ends just before it.

        Returns the trial step, its end in min and the waves of its falling mode.
        """
        self._passed, waves = None, self._falling_waves_if_due()
        if waves is None or self._recorder.bifurcation:
            return step, end, waves
        passed, falling = end, FallingModes(self._waves, self._unstable)
        self._recorder.iterations += step.iterations
        step, end, iterations = end_before(self._stepper, falling, end)
        self._recorder.iterations += iterations
        self._past_limit()
        self._passed = falling.waves if end < passed else None
        return step, end, waves if self._passed is None else None

    def _accept_or_reject(self, step: StepResult, end: float, waves: int | None) -> Row | None:
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
        row = recorder.accept(end, end - start, step.iterations, waves)
        if self._passed is not None:
            recorder.pass_bifurcation(self._passed)
        self._settle(end)
        return row

    def _settle(self, time: float) -> None:
        """Save a profile of the accepted state at a time in min, if due, and a checkpoint."""
        run, recorder = self._scene.run, self._recorder
        self._waves.keep_mode()
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
                recorder.accept(0.0, 0.0, iterations, self._falling_waves())
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
        recorder.accept(0.0, 0.0, iterations, self._falling_waves())
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

    def _falling_waves(self) -> int | None:
        """Return the smallest number of waves of a falling direction; None if stable."""
        return self._waves.first() if self._stable else 0

    def _falling_waves_if_due(self) -> int | None:
        """Return the same; None where the trial state is too near to the last one to differ."""
        return self._falling_waves() if not self._stable or self._waves.due() else None

    def _unstable(self) -> bool:
        """Whether an axisymmetric mode falls in the trial state."""
        self._past_limit()
        return not self._stable

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

    def _blow_up(self) -> float | None:
        """Return the time in min at which the volume becomes infinite before any milestone."""
        infinite = blow_up_time(self._recorder.rows)
        milestone = self._controller.propose_milestone(self._time)
        return infinite if infinite and milestone and infinite < milestone else None

    def _accept(self, iterations: int, step: float) -> Row:
        """Record a state accepted on the approach to a limit point."""
        self._stable = self._stability.negative_modes() == 0
        row = self._recorder.accept(self._time, step, iterations, self._falling_waves_if_due())
        self._waves.keep_mode()
        return row

    def _finished(self, end: float) -> Outcome:
        last, controller = self._recorder.rows[-1], self._controller
        grew = self._shell.growth is None or last.max_growth_strain > 0
        late = all(growth.begins >= end for growth in self._scene.growing)
        reductions = controller.reductions if self._scene.numerics.step is not None else 0
        limited = self._tableau.name if self._reduced else None
        return reached_end(end, grew, late, reductions, limited)

    def _failed(self, reason: EquilibriumError | str) -> Outcome:
        where, rows = f"{self._time:g} min", self._recorder.rows
        if (infinite := blow_up_time(rows, broken_off=True)) is not None:
            return growth_unbounded(infinite, rows[-1])
        if (softened := self._softened(where)) is not None:
            return softened
        bifurcation = self._recorder.bifurcation
        unstable = not all(row.stable for row in rows[-_SHORTEST:])
        if unstable or (bifurcation and bifurcation[0] == len(rows) - 1):
            return buckled(where)
        if isinstance(reason, str):
            return Outcome("no-equilibrium", f"no equilibrium found beyond {where}: {reason}")
        why = f"no convergence beyond {where}, even with the smallest step: {reason}"
        return Outcome("failed", why)

    def _softened(self, where: str) -> Outcome | None:
        """Return the end of a run if the wall, in its trial state, has no stiffness."""
        stretch = self._recorder.softest_stretch(self._scene.wall)
        return None if stretch is None else wall_softened(stretch, where)
