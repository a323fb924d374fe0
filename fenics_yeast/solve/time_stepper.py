"""Growth in time, one step after the other: attempt a trial step, then accept or reject it.

    `attempt` -> stages of the Runge-Kutta method -> an equilibrium each -> `accept` or `reject`

Which of the two is the caller's decision, by `StepController.accepts` and `Stability`. A step
without an equilibrium is rejected here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import DofValues, PointValues, Shell, ShellState
from .equilibrium import Equilibrium, EquilibriumError
from .predictor import Predictor
from .runge_kutta import ButcherTableau

_STABLE = 1.8  # step times decay rate at which forward Euler damps; its stability limit is 2
_INCREMENT = 1e-7  # of the growth strain, to differentiate the growth rate
_POWER_ITERATIONS = 3


@dataclass(frozen=True)
class StepperState:
    """An accepted state of a shell and what the next step depends on.

    Attributes
    ----------
    time, w, eps_g
        Time in min, and the state of the shell as in `ShellState`.
    rate, stiffest
        Growth rate in 1/min and the direction in which growth is stiffest; None if unknown.
    solution_times, solutions
        The last solutions, from which the predictor extrapolates, and their times in min.
    """

    time: float
    w: DofValues
    eps_g: PointValues | None
    rate: PointValues | None
    stiffest: PointValues | None
    solution_times: tuple[float, ...]
    solutions: tuple[DofValues, ...]


@dataclass(frozen=True)
class StepResult:
    """Newton iterations of a trial step, and the estimated error of its growth strains.

    The error has the layout of `GrowthState.get`; it is None for an elastic wall.
    """

    iterations: int
    error: Array | None


class Follower(Protocol):
    """What follows the steps of a wall, such as their derivatives by parameters."""

    def solved(self, time: float, row: Array) -> None:
        """Receive the shell in the solution of a stage at a time in min.

        `row` is that of the tableau up to the diagonal; empty for an equilibrium at given growth.
        """

    def accepted(self, start: StepperState, duration: float) -> None:
        """Follow the last stages as a step of a duration in min that is accepted."""

    def rejected(self) -> None:
        """Forget the last stages."""


class TimeStepper:
    """A shell that is advanced in time.

    Parameters
    ----------
    shell, equilibrium
        The wall, unloaded and at time 0, and its solver.
    tableau
        Runge-Kutta method for the growth strains.
    pressure
        Turgor in MPa as a function of time in min.
    memory
        From how many solutions the next one is predicted; see `Predictor`.
    follower
        Notes the solution of each stage, and which steps are accepted.

    Attributes
    ----------
    accepted
        The accepted state, which is restored after any failure.

    Raises
    ------
    ValueError
        If the method's last stage is not the end of the step.
    """

    def __init__(
        self,
        shell: Shell,
        equilibrium: Equilibrium,
        tableau: ButcherTableau,
        pressure: Callable[[float], float],
        memory: int = 5,
        follower: Follower | None = None,
    ) -> None:
        if not tableau.is_stiffly_accurate:
            raise ValueError(f"{tableau.name} must be stiffly accurate: b the last row of A")
        self.shell, self._equilibrium = shell, equilibrium
        self._tableau, self.pressure = tableau, pressure
        self._predictor, self._follower = Predictor(shell.constrained, memory), follower
        self._trial_rate: Array | None = None
        wall = shell.state()
        self._predictor.solutions = ((0.0, wall.w),)
        unloaded = StepperState(0.0, wall.w, wall.eps_g, None, None, (0.0,), (wall.w,))
        self._unloaded = self.accepted = unloaded

    # --- one step -------------------------------------------------------------------------

    def attempt(self, end: float) -> StepResult:
        """Make a trial step to a time in min; `accept` or `reject` it next.

        Raises
        ------
        EquilibriumError
            If a stage has no solution; the step has then been rejected.
        """
        try:
            return self._solve_stages(end)
        except BaseException:
            self.reject()
            raise

    def accept(self, time: float) -> None:
        """Accept the trial step: its end, at a time in min, becomes the accepted state."""
        if self._follower is not None:
            self._follower.accepted(self.accepted, time - self.accepted.time)
        wall, rate, stiffest = self.shell.state(), self._trial_rate, self.accepted.stiffest
        times, solutions = zip(*self._predictor.solutions, strict=True)
        self.accepted = StepperState(time, wall.w, wall.eps_g, rate, stiffest, times, solutions)
        self._trial_rate = None

    def reject(self) -> None:
        """Reject the trial step: return to the accepted state, as if it had never been tried.

        Shell, pressure and predictor are restored to the last bit.
        """
        accepted, growth = self.accepted, self.shell.growth
        self.shell.restore(ShellState(accepted.w, accepted.eps_g))
        self.shell.pressure.value = self.pressure(accepted.time)
        if growth is not None:
            growth.stage.value = 0.0
        solutions = zip(accepted.solution_times, accepted.solutions, strict=True)
        self._predictor.solutions = tuple(solutions)
        self._trial_rate = None
        if self._follower is not None:
            self._follower.rejected()

    def step(self, end: float) -> StepResult:
        """Make a step to a time in min and accept it; raises what `attempt` raises."""
        result = self.attempt(end)
        self.accept(end)
        return result

    def volume_error(self, step: StepResult) -> float:
        """Return the estimated error of the trial volume in µm³, right after `attempt`."""
        exact, comm = step.error is None or not step.error.any(), self.shell.comm
        if comm.size > 1:
            exact = comm.allreduce(exact, op=dx.MPI.LAND)
        if exact or step.error is None:
            return 0.0
        return self._equilibrium.volume_change(step.error)

    # --- loading and the state ------------------------------------------------------------

    def load(self) -> int:
        """Find the equilibrium at time 0 from the trial state; return its Newton iterations.

        Raises
        ------
        EquilibriumError
            If none was found; the trial state is then unchanged.
        """
        self.shell.pressure.value = self.pressure(0.0)
        iterations = self._equilibrium.solve()
        self.note_stage(0.0, np.empty(0))
        self.accept(0.0)
        self.reset_predictor()
        return iterations

    def unload(self) -> None:
        """Return the shell to its initial state, without pressure."""
        self.accepted = self._unloaded
        self.reject()
        self.shell.pressure.value = 0.0

    def reset_predictor(self) -> None:
        """Extrapolate only from the accepted state on: load or growth rate have a kink here."""
        accepted = self.accepted
        self.accepted = replace(
            accepted, rate=None, solution_times=(accepted.time,), solutions=(accepted.w,)
        )
        self._predictor.solutions = ((accepted.time, accepted.w),)

    def state(self) -> StepperState:
        """Return the accepted state."""
        return self.accepted

    def restore(self, state: StepperState) -> None:
        """Continue from an accepted state."""
        self.accepted = state
        self.reject()

    # --- the growth rate ------------------------------------------------------------------

    @property
    def at_rest(self) -> bool:
        """Whether nothing grows in the accepted state."""
        growth, grows = self.shell.growth, False
        if growth is not None:
            growth.set_interval(self.accepted.time, self.accepted.time)
            grows = bool(growth.rate().any())
        return not self.shell.comm.allreduce(grows, op=dx.MPI.LOR)

    @property
    def longest_step(self) -> float:
        """Longest step in min in which the method is stable; infinite if it is implicit.

        Growth at given strain relaxes the stress, at the rate of the largest eigenvalue of
        `-d rate/d ε^g`, found at each point by power iterations. An equilibrium in which all
        strains can adapt is slower, but growth that varies through the wall is as fast.
        """
        growth = self.shell.growth
        if growth is None or not self._tableau.is_explicit:
            return np.inf
        growth.set_interval(self.accepted.time, self.accepted.time)
        accepted, rate = growth.get(), growth.rate()
        pairs = (*accepted.shape[:-1], -1, 2)
        v = rate if self.accepted.stiffest is None else self.accepted.stiffest
        size = np.zeros(1)
        for _ in range(_POWER_ITERATIONS):
            length = np.linalg.norm(v.reshape(pairs), axis=-1, keepdims=True)
            v = (v.reshape(pairs) / np.where(length > 0, length, 1)).reshape(rate.shape)
            growth.set(accepted + _INCREMENT * v)
            v = (rate - growth.rate()) / _INCREMENT
            size = np.linalg.norm(v.reshape(pairs), axis=-1)
        growth.set(accepted)
        self.accepted = replace(self.accepted, stiffest=v)
        largest = self.shell.comm.allreduce(float(size.max(initial=0.0)), op=dx.MPI.MAX)
        return _STABLE / largest if largest > 0 else np.inf

    # --- stages ---------------------------------------------------------------------------

    def _solve_stages(self, end: float) -> StepResult:
        growth, start = self.shell.growth, self.accepted.time
        if growth is None or self.accepted.eps_g is None:
            return StepResult(self._solve(end, np.empty(0)), None)
        growth.set_interval(start, end)
        dt, A, c = end - start, self._tableau.A, self._tableau.c
        rates: list[Array] = []
        iterations = 0
        for i in range(len(c)):
            base = self.accepted.eps_g + dt * sum(a * k for a, k in zip(A[i], rates, strict=False))
            if i > 0 or A[i, i] > 0:
                growth.stage.value = A[i, i] * dt
                growth.set_base(base)
                growth.set(base + A[i, i] * dt * rates[-1] if rates else base)
                time = end if i == len(c) - 1 else start + c[i] * dt
                iterations += self._solve(time, A[i, : i + 1])
            if A[i, i] > 0:
                rates.append((growth.get() - base) / (A[i, i] * dt))
            elif i == 0 and self.accepted.rate is not None:
                rates.append(self.accepted.rate)  # the accepted state is the last stage of its step
            else:
                rates.append(growth.rate())
        weights = self._tableau.b - self._tableau.embedded
        error = dt * sum(b * k for b, k in zip(weights, rates, strict=True))
        growth.stage.value = 0.0
        self._trial_rate = rates[-1]
        return StepResult(iterations, error)

    def _solve(self, time: float, row: Array) -> int:
        """Find the equilibrium at a time from the predicted state, else from the accepted one.

        `row` is that of the stage in the tableau, up to the diagonal.
        """
        self.shell.pressure.value = self.pressure(time)
        self.shell.w.x.array[:] = self._predictor.predict(time)
        failed = 0
        try:
            iterations = self._equilibrium.solve()
        except EquilibriumError as error:
            failed = error.iterations
            self.shell.w.x.array[:] = self.accepted.w
            try:
                iterations = self._equilibrium.solve()
            except EquilibriumError as again:
                raise EquilibriumError(str(again), failed + again.iterations) from error
        self._predictor.add(time, self.shell.w.x.array.copy())
        self.note_stage(time, row)
        return failed + iterations

    def note_stage(self, time: float, row: Array) -> None:
        """Let the follower, if any, note the trial state: see `Follower.solved`."""
        if self._follower is not None:
            self._follower.solved(time, row)
