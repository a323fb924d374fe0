"""Growth in time, one step after the other: attempt a trial step, then accept or reject it.

    `attempt` -> stages of the Runge-Kutta method -> an equilibrium each -> `accept` or `reject`

Which of the two is the caller's decision, by `StepController.accepts` and `Stability`. A step
without an equilibrium is rejected here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..mechanics import DofValues, PointValues, Shell, ShellState
from .equilibrium import Equilibrium, EquilibriumError
from .predictor import Predictor
from .runge_kutta import ButcherTableau

Array = NDArray[np.float64]

_STABLE = 1.8  # step times decay rate at which forward Euler damps; its stability limit is 2
_INCREMENT = 1e-7  # of the growth strain, to differentiate the growth rate
_POWER_ITERATIONS = 3


@dataclass(frozen=True)
class StepperState:
    """The accepted state of a time stepper.

    Attributes
    ----------
    time
        In min.
    w, eps_g
        The state of the shell, as in `ShellState`.
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
    """Newton iterations of a trial step and its estimated error.

    Attributes
    ----------
    iterations
        Newton iterations.
    error
        Estimated error of the growth strains, in the layout of `GrowthState.get`; None for an
        elastic wall.
    """

    iterations: int
    error: Array | None


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

    Attributes
    ----------
    time, accepted
        Time in min and shell of the accepted state, which any failure restores.

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
    ) -> None:
        if not tableau.is_stiffly_accurate:
            raise ValueError(f"{tableau.name} must be stiffly accurate: b the last row of A")
        self.shell, self._equilibrium = shell, equilibrium
        self._tableau, self.pressure = tableau, pressure
        self._predictor = Predictor(shell.constrained)
        self._rate: Array | None = None  # of growth in the accepted state, if known
        self._trial_rate: Array | None = None
        self._stiffest: Array | None = None
        self.time = 0.0
        self._unloaded = self.accepted = shell.state()
        self.reset_predictor()

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
        self.time, self.accepted = time, self.shell.state()
        self._accepted_solutions = self._predictor.solutions
        self._rate, self._trial_rate = self._trial_rate, None

    def reject(self) -> None:
        """Reject the trial step: return to the accepted state, as if it had never been tried.

        Shell, pressure and predictor are restored to the last bit.
        """
        self.shell.restore(self.accepted)
        self.shell.pressure.value = self.pressure(self.time)
        if self.shell.growth is not None:
            self.shell.growth.stage.value = 0.0
        self._predictor.solutions = self._accepted_solutions
        self._trial_rate = None

    def step(self, end: float) -> StepResult:
        """Make a step to a time in min and accept it.

        Raises
        ------
        EquilibriumError
            If a stage has no solution; the accepted state is then unchanged.
        """
        result = self.attempt(end)
        self.accept(end)
        return result

    def volume_error(self, step: StepResult) -> float:
        """Return the estimated error of the trial volume in µm³, right after `attempt`."""
        exact = step.error is None or not step.error.any()
        if self.shell.comm.allreduce(exact, op=dx.MPI.LAND) or step.error is None:
            return 0.0
        return self._equilibrium.volume_change(step.error)

    # --- loading and the state ------------------------------------------------------------

    def load(self) -> int:
        """Find the equilibrium at time 0 from the trial state; return its Newton iterations.

        Raises
        ------
        EquilibriumError
            If there is none; the trial state is then unchanged.
        """
        self.shell.pressure.value = self.pressure(0.0)
        iterations = self._equilibrium.solve()
        self.accept(0.0)
        self.reset_predictor()
        return iterations

    def unload(self) -> None:
        """Return the shell to its initial state, without pressure."""
        self.time, self.accepted = 0.0, self._unloaded
        self.reset_predictor()
        self.reject()
        self.shell.pressure.value = 0.0

    def reset_predictor(self) -> None:
        """Extrapolate only from the accepted state on: load or growth rate have a kink here."""
        self._rate = None
        self._predictor.solutions = self._accepted_solutions = ((self.time, self.accepted.w),)

    def state(self) -> StepperState:
        """Return the accepted state."""
        times = tuple(time for time, _ in self._accepted_solutions)
        solutions = tuple(w for _, w in self._accepted_solutions)
        w, eps_g = self.accepted.w, self.accepted.eps_g
        return StepperState(self.time, w, eps_g, self._rate, self._stiffest, times, solutions)

    def restore(self, state: StepperState) -> None:
        """Continue from an accepted state."""
        self.time, self.accepted = state.time, ShellState(state.w, state.eps_g)
        self._rate, self._stiffest = state.rate, state.stiffest
        self._accepted_solutions = tuple(zip(state.solution_times, state.solutions, strict=True))
        self.reject()

    # --- the growth rate ------------------------------------------------------------------

    @property
    def at_rest(self) -> bool:
        """Whether nothing grows in the accepted state."""
        growth, grows = self.shell.growth, False
        if growth is not None:
            growth.set_interval(self.time, self.time)
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
        growth.set_interval(self.time, self.time)
        accepted, rate = growth.get(), growth.rate()
        pairs = (*accepted.shape[:-1], -1, 2)
        v = rate if self._stiffest is None else self._stiffest
        size = np.zeros(1)
        for _ in range(_POWER_ITERATIONS):
            length = np.linalg.norm(v.reshape(pairs), axis=-1, keepdims=True)
            v = (v.reshape(pairs) / np.where(length > 0, length, 1)).reshape(rate.shape)
            growth.set(accepted + _INCREMENT * v)
            v = (rate - growth.rate()) / _INCREMENT
            size = np.linalg.norm(v.reshape(pairs), axis=-1)
        growth.set(accepted)
        self._stiffest = v
        largest = self.shell.comm.allreduce(float(size.max(initial=0.0)), op=dx.MPI.MAX)
        return _STABLE / largest if largest > 0 else np.inf

    # --- stages ---------------------------------------------------------------------------

    def _solve_stages(self, end: float) -> StepResult:
        growth, start = self.shell.growth, self.time
        if growth is None or self.accepted.eps_g is None:
            return StepResult(self._solve(end), None)
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
                iterations += self._solve(end if i == len(c) - 1 else start + c[i] * dt)
            if A[i, i] > 0:
                rates.append((growth.get() - base) / (A[i, i] * dt))
            elif i == 0 and self._rate is not None:
                rates.append(self._rate)  # the accepted state is the last stage of its step
            else:
                rates.append(growth.rate())
        weights = self._tableau.b - self._tableau.embedded
        error = dt * sum(b * k for b, k in zip(weights, rates, strict=True))
        growth.stage.value = 0.0
        self._trial_rate = rates[-1]
        return StepResult(iterations, error)

    def _solve(self, time: float) -> int:
        """Find the equilibrium at a time from the predicted state, else from the accepted one."""
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
        return failed + iterations
