"""Errors of time steps: what a step may add, and what the steps of a run have added.

An error δV of the volume acts like a shift in time by `δV/V'`. Shifts add up over the run, and
where growth speeds up, towards bursting or growth without bound, the same shift is a larger error.
"""

from dataclasses import dataclass

from ..solve import ButcherTableau

_SLOW = 0.02  # V'/V0 times the characteristic growth time, below which growth counts as slow
_FAST = 0.25  # the same with V'/V, above which errors are compared with the volume itself


@dataclass(frozen=True)
class StepErrorState:
    """Shift in time in min so far; largest error and speed at saved times.

    The error is that of V, relative; the speed is `V'/V` in 1/min.
    """

    shift: float = 0.0
    error: float = 0.0
    speed: float = 0.0


class StepErrors:
    """Errors of the volume by time steps.

    Parameters
    ----------
    tableau
        Runge-Kutta method, whose estimates exceed the errors where growth is smooth.
    growth_time, reference_volume
        Characteristic growth time in min, volume of the unloaded cell in µm³.
    allowed
        Relative error of V/V0 that the steps may have in all.
    """

    def __init__(
        self, tableau: ButcherTableau, growth_time: float, reference_volume: float, allowed: float
    ) -> None:
        self._tableau, self._growth_time = tableau, growth_time
        self._reference_volume, self._allowed = reference_volume, allowed
        self._state = StepErrorState()

    def relative(
        self, error: float, volume: float, change: float, dt: float, smooth: bool
    ) -> float:
        """Return the estimated error of a step over the largest one allowed.

        Parameters
        ----------
        error, volume, change
            Estimated error of the volume, volume and its change in the step, in µm³.
        dt
            Length of the step in min.
        smooth
            Whether growth is smooth in the step: neither load nor threshold begins in it.
        """
        grown = abs(change) * self._growth_time / dt
        grown = min(max(grown, _SLOW * self._reference_volume), _FAST * volume)
        caution = self._tableau.caution if smooth else min(1.0, self._tableau.caution)
        return abs(error) / (caution * self._allowed * grown)

    def accept(
        self, error: float, volume: float, change: float, dt: float, *, smooth: bool, saved: bool
    ) -> None:
        """Add the error of an accepted step; keep the largest one at saved times."""
        excess = max(1.0, self._tableau.caution) if smooth else 1.0
        before, shift, speed = self._state, 0.0, abs(change) / (dt * volume)
        if change:
            shift = abs(error / change) * dt / excess
        shift += before.shift
        if saved:
            largest = max(before.error, shift * speed), max(before.speed, speed)
            self._state = StepErrorState(shift, *largest)
        else:
            self._state = StepErrorState(shift, before.error, before.speed)

    def state(self) -> StepErrorState:
        """Return the sums so far."""
        return self._state

    def restore(self, state: StepErrorState) -> None:
        """Continue the sums of an earlier run."""
        self._state = state
