"""Growth in time: one step of an integrator on a trial copy of the state, accepted or dropped."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..mechanics import DofValues, PointValues, Shell, ShellState
from .continuation import BorderedNewton
from .equilibrium import Equilibrium, EquilibriumError
from .runge_kutta import TABLEAUX, ButcherTableau

Array = NDArray[np.float64]

LIMIT_POINT = TABLEAUX["sdirk3"]  # steps in volume, whatever method is used in time
_STABLE = 1.8  # times its rate: length of a step in which forward Euler damps a decay; below 2
_NUDGE = 1e-7  # growth strain by which the growth rate is differentiated
_POWERS = 3
_MEMORY = 5  # solved states through which the start of the next solution is extrapolated


@dataclass(frozen=True)
class AcceptedState:
    """An accepted state: all that the next step starts from; time in min."""

    time: float
    wall: ShellState


@dataclass(frozen=True)
class StepperState:
    """All of an accepted state that the next steps depend on.

    Attributes
    ----------
    time
        In min.
    w, eps_g
        The state of the shell, as in `ShellState`.
    rate, stiffest
        Growth rate, and the direction in which growth is stiffest, where they are known.
    recent_times, recent
        The last solutions, from which the next one is extrapolated, and their times in min.
    """

    time: float
    w: DofValues
    eps_g: PointValues | None
    rate: PointValues | None
    stiffest: PointValues | None
    recent_times: tuple[float, ...]
    recent: tuple[DofValues, ...]


@dataclass(frozen=True)
class StepResult:
    """What a successful step took and how good it is.

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
    """A shell followed in time.

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
    accepted
        The accepted state. Whatever fails, the shell is brought back to it.
    """

    def __init__(
        self,
        shell: Shell,
        equilibrium: Equilibrium,
        tableau: ButcherTableau,
        pressure: Callable[[float], float],
    ) -> None:
        self.shell, self._equilibrium = shell, equilibrium
        self._tableau, self.pressure = tableau, pressure
        self._recent: deque[tuple[float, Array]] = deque(maxlen=_MEMORY)
        self._before: list[tuple[float, Array]] = []
        self._rate: Array | None = None  # of growth in the accepted state, where it is known
        self._last_rate: Array | None = None  # in the trial
        self._explicit = not tableau.A.diagonal().any()
        self._stiffest: Array | None = None  # direction at each point in which growth is stiffest
        self._unloaded = self.accepted = self._capture(0.0)

    def load(self) -> int:
        """Equilibrium under the pressure at time 0 from the trial state; the Newton iterations.

        Raises
        ------
        EquilibriumError
            If none was found; the trial state is then as before.
        """
        self.shell.pressure.value = self.pressure(0.0)
        iterations = self._equilibrium.solve()
        self.accept(0.0)
        self._recent.append((0.0, self.accepted.wall.w))
        return iterations

    def unload(self) -> None:
        """Bring the shell back to where it began."""
        self.accepted = self._unloaded
        self._recent.clear()
        self.shell.restore(self.accepted.wall)
        self.shell.pressure.value = 0.0

    def step(self, end: float) -> StepResult:
        """Go from the accepted state to a later time in one step, and accept it.

        Raises
        ------
        EquilibriumError
            If a stage has no solution; shell and accepted state are then as before.
        """
        trial = self.attempt(end)
        self.accept(end)
        return trial

    def attempt(self, end: float) -> StepResult:
        """Go to a later time on a trial copy of the state; then `accept` or `reject` it.

        Raises
        ------
        EquilibriumError
            If a stage has no solution; the trial is then rejected already.
        """
        self._before = list(self._recent)
        try:
            return self._stages(end)
        except BaseException:
            self.reject()
            raise

    def attempt_volume_step(
        self, control: BorderedNewton, volume: float, dt: float, slope: float = 0.0
    ) -> tuple[int, float]:
        """Go to a larger volume, in whatever time that takes, on a trial copy of the state.

        The method is that of `step` with the volume in the place of time: near a limit point,
        where the volume grows ever faster in time, time is a smooth function of the volume.

        Parameters
        ----------
        control
            Solver with the stage's length as its unknown.
        volume
            Volume to reach in µm³.
        dt
            First guess of the time in min.
        slope
            Rate of the pressure in MPa/min, constant in that time.

        Returns
        -------
        tuple
            Newton iterations, and the time taken in min; not positive past the limit point.

        Raises
        ------
        EquilibriumError
            If a stage has no solution; the trial is then rejected already.
        """
        growth, accepted = self.shell.growth, self.accepted.wall.eps_g
        if growth is None or accepted is None:
            raise ValueError("an elastic wall does not change in time")
        self._before = list(self._recent)
        growth.set_interval(self.accepted.time, self.accepted.time)  # no milestone is passed
        start, pressure = self.shell.volume(), self.pressure(self.accepted.time)
        A, c = LIMIT_POINT.A, LIMIT_POINT.c
        durations: list[float] = []
        changes: list[Array] = []  # of the growth strains, as over the whole step
        iterations = 0
        try:
            for i in range(len(c)):
                base = accepted + sum(a * k for a, k in zip(A[i], changes, strict=False))
                growth.stage.value = A[i, i] * (durations[-1] if durations else dt)
                growth.set_base(base)
                growth.set(base + A[i, i] * changes[-1] if changes else base)
                spent = sum(a * d for a, d in zip(A[i], durations, strict=False))
                rise = (pressure + slope * spent, slope)
                iterations += control.solve(start + c[i] * (volume - start), rise=rise)
                durations.append(float(growth.stage.value) / A[i, i])
                changes.append((growth.get() - base) / A[i, i])
                if durations[-1] <= 0:
                    return iterations, durations[-1]
        except BaseException:
            self.reject()
            raise
        finally:
            growth.stage.value = 0.0
        return iterations, float(A[-1] @ durations)

    def accept(self, time: float) -> None:
        """Make the trial the accepted state."""
        self.accepted = self._capture(time)
        self._rate, self._last_rate = self._last_rate, None

    @property
    def at_rest(self) -> bool:
        """Whether nothing grows in the accepted state."""
        growth, grows = self.shell.growth, False
        if growth is not None:
            growth.set_interval(self.accepted.time, self.accepted.time)
            grows = bool(growth.rate().any())
        return not self.shell.comm.allreduce(grows, op=dx.MPI.LOR)

    def reject(self) -> None:
        """Bring the shell back to the accepted state."""
        self._restore()
        self._last_rate = None
        self._recent.clear()
        self._recent.extend(self._before)

    def reset_predictor(self) -> None:
        """Do not extrapolate over what came before: load or growth have a kink here."""
        self._rate = None
        self._recent.clear()
        self._recent.append((self.accepted.time, self.accepted.wall.w))

    def state(self) -> StepperState:
        """All that the next steps depend on, right after `accept`; its arrays never change."""
        wall = self.accepted.wall
        times, recent = zip(*self._recent, strict=True) if self._recent else ((), ())
        return StepperState(
            self.accepted.time, wall.w, wall.eps_g, self._rate, self._stiffest, times, recent
        )

    def restore(self, state: StepperState) -> None:
        """Go on from an accepted state of another run."""
        self.accepted = AcceptedState(state.time, ShellState(state.w, state.eps_g))
        self._rate, self._last_rate, self._stiffest = state.rate, None, state.stiffest
        self._recent.clear()
        self._recent.extend(zip(state.recent_times, state.recent, strict=True))
        self._restore()

    def _stages(self, end: float) -> StepResult:
        growth, start = self.shell.growth, self.accepted.time
        if growth is None or self.accepted.wall.eps_g is None:
            return StepResult(self._solve(end), None)
        growth.set_interval(start, end)
        dt, A, c = end - start, self._tableau.A, self._tableau.c
        rates: list[Array] = []
        iterations = 0
        for i in range(len(c)):
            base = self.accepted.wall.eps_g + dt * sum(
                a * k for a, k in zip(A[i], rates, strict=False)
            )
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
        weights = A[-1] - self._tableau.embedded
        error = dt * sum(b * k for b, k in zip(weights, rates, strict=True))
        growth.stage.value = 0.0
        self._last_rate = rates[-1]
        return StepResult(iterations, error)

    @property
    def longest_step(self) -> float:
        """Longest step in min in which the method is stable; infinite where it is implicit.

        Growth at given strain relaxes the stress, at the rate of the largest eigenvalue of
        `-d rate/d ε^g`, found at each point by power iterations. An equilibrium in which all
        strains may give is slower, but growth that varies through the wall is as fast.
        """
        growth = self.shell.growth
        if growth is None or not self._explicit:
            return np.inf
        growth.set_interval(self.accepted.time, self.accepted.time)
        accepted, rate = growth.get(), growth.rate()
        pairs = (*accepted.shape[:-1], -1, 2)
        v = rate if self._stiffest is None else self._stiffest
        size = np.zeros(1)
        for _ in range(_POWERS):
            length = np.linalg.norm(v.reshape(pairs), axis=-1, keepdims=True)
            v = (v.reshape(pairs) / np.where(length > 0, length, 1)).reshape(rate.shape)
            growth.set(accepted + _NUDGE * v)
            v = (rate - growth.rate()) / _NUDGE
            size = np.linalg.norm(v.reshape(pairs), axis=-1)
        growth.set(accepted)
        self._stiffest = v
        largest = self.shell.comm.allreduce(float(size.max(initial=0.0)), op=dx.MPI.MAX)
        return _STABLE / largest if largest > 0 else np.inf

    def volume_error(self, step: StepResult) -> float:
        """Estimated error in µm³ of the volume of the trial that an attempt has just made."""
        exact = step.error is None or not step.error.any()
        if self.shell.comm.allreduce(exact, op=dx.MPI.LAND) or step.error is None:
            return 0.0
        return self._equilibrium.volume_change(step.error)

    def _solve(self, time: float) -> int:
        """Equilibrium at a time, from an extrapolated start; if that fails, from a plain one."""
        self.shell.pressure.value = self.pressure(time)
        self.shell.w.x.array[:] = self._extrapolated(time)
        spent = 0
        try:
            iterations = self._equilibrium.solve()
        except EquilibriumError as error:
            spent = error.iterations
            self.shell.w.x.array[:] = self.accepted.wall.w
            try:
                iterations = self._equilibrium.solve()
            except EquilibriumError as again:
                raise EquilibriumError(str(again), spent + again.iterations) from error
        if self._recent and self._recent[-1][0] == time:  # steps too short to tell apart
            self._recent.pop()
        self._recent.append((time, self.shell.w.x.array.copy()))
        return spent + iterations

    def _extrapolated(self, time: float) -> Array:
        """Value at a time of the polynomial through the last solutions."""
        times = [t for t, _ in self._recent]
        start = np.zeros_like(self.accepted.wall.w)
        for i, (t, w) in enumerate(self._recent):
            weight = 1.0
            for s in (*times[:i], *times[i + 1 :]):
                weight *= (time - s) / (t - s)
            start += weight * w
        held = self.shell.constrained  # where the weights' round-off would add up
        start[held] = self.accepted.wall.w[held]
        return start

    def _capture(self, time: float) -> AcceptedState:
        return AcceptedState(time, self.shell.state())

    def _restore(self) -> None:
        self.shell.restore(self.accepted.wall)
        self.shell.pressure.value = self.pressure(self.accepted.time)
        if self.shell.growth is not None:
            self.shell.growth.stage.value = 0.0
