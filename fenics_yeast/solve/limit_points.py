"""The approach to a limit point of growth, beyond which the wall finds no equilibrium."""

from __future__ import annotations

from collections.abc import Callable, Generator
from enum import Enum
from math import copysign
from typing import TypeVar

from .continuation import BorderedNewton
from .equilibrium import EquilibriumError
from .time_stepper import LIMIT_POINT, TimeStepper

_SHARPNESS = 2e-5  # of the time: how near the limit point is found
_LARGEST_STEP = 0.02  # of the volume; less of it where more precision is wanted
_LEAST_STEP = 1e-7
_MOST_STEPS = 400

T = TypeVar("T")


class ApproachEnd(Enum):
    """How an approach ended."""

    LIMIT = "the limit point was found"
    MILESTONE = "time came to a milestone; no limit point so far"
    STUCK = "no step in volume converged either"


def approach_limit_point(
    stepper: TimeStepper,
    tolerance: float,
    precision: float,
    growth_rate: float,
    milestone: float,
    note: Callable[[int, float], T],
) -> Generator[T, None, tuple[ApproachEnd, int]]:
    """Step in volume, with time as an unknown, until time no longer goes on.

    Yields the row of each accepted step.

    Parameters
    ----------
    evolution
        The wall at its accepted state, under a pressure that changes linearly up to the milestone.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    precision
        Wanted relative error of the volume.
    growth_rate
        Rate of the volume at the accepted state in µm³/min, not zero.
    milestone
        Time in min that must not be passed.
    note
        Makes the row of an accepted step from its Newton iterations and its length in min.

    Returns
    -------
    tuple
        How it ended, and the iterations of rejected steps.
    """
    shell = stepper.shell
    if shell.growth is None:
        raise ValueError("an elastic wall does not change in time")
    spent = 0
    fraction = _LARGEST_STEP * min(1.0, 0.8 * (precision / 1e-4) ** (1 / LIMIT_POINT.order))
    largest = copysign(fraction * shell.volume(), growth_rate)
    change, first_rate = 0.5 * largest, growth_rate
    beginning, pressure = stepper.accepted.time, stepper.pressure
    slope = (pressure(milestone) - pressure(beginning)) / (milestone - beginning)
    with BorderedNewton(shell, shell.growth.stage, tolerance) as control:
        for _ in range(_MOST_STEPS):
            start, volume = stepper.accepted.time, shell.volume()
            try:
                guess = change / growth_rate
                iterations, dt = stepper.attempt_volume_step(control, volume + change, guess, slope)
            except EquilibriumError as error:
                spent += error.iterations
                change /= 4
                if abs(change) < _LEAST_STEP * volume:
                    return ApproachEnd.STUCK, spent
                continue
            if dt <= 0:
                stepper.reject()
                spent += iterations
                # Time is a parabola of the volume here: half of what it could still gain.
                if change / growth_rate < _SHARPNESS * max(start, milestone - beginning):
                    # Towards a limit point the volume moves ever faster; else it turns here.
                    limit = abs(growth_rate) > abs(first_rate)
                    return ApproachEnd.LIMIT if limit else ApproachEnd.STUCK, spent
                change /= 2
                continue
            if start + dt > milestone:
                stepper.reject()
                return ApproachEnd.MILESTONE, spent + iterations
            stepper.accept(start + dt)
            yield note(iterations, dt)
            growth_rate = change / dt
            change = min(1.5 * change, largest, key=abs)
    return ApproachEnd.STUCK, spent
