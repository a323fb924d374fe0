"""Limit points, beyond which a wall has no equilibrium: in time, and under rising pressure.

Both searches prescribe the volume, which still increases at a limit point, and solve for what
reaches its maximum there: time or pressure. For a force, its displacement takes that part.
"""

from collections import deque
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import dataclass
from math import ceil, copysign
from typing import TypeVar

import numpy as np

from ..geometry import Array
from ..mechanics import Shell
from .continuation import BorderedNewton
from .equilibrium import EquilibriumError
from .path_following import PathCoordinates, PathTarget, follow_path
from .runge_kutta import TABLEAUX
from .time_stepper import TimeStepper

T = TypeVar("T")

_LARGEST_STEP = 0.02  # of the volume; smaller for a higher precision
_TABLEAU = TABLEAUX["sdirk3"]  # of steps in volume
_SHARPNESS = 2e-5  # of the time: how accurately the limit point is located
_LEAST_GROWTH_STEP = 1e-7  # of the volume
_MOST_GROWTH_STEPS = 400
_FEWEST_STEPS, _LARGEST_DISPLACEMENT = 40, 0.1  # in its unit, under a rising force
_BEFORE = 2e-4  # of the volume: how far before a limit pressure the search stops


# --- in time ------------------------------------------------------------------------------


def approach_limit_point(
    stepper: TimeStepper,
    tolerance: float,
    precision: float,
    growth_rate: float,
    milestone: float,
    record: Callable[[int, float], T],
) -> Generator[T, None, tuple[bool, int]]:
    """Step in volume, with time as an unknown, until time reaches its maximum.

    Yields what `record` returns for each accepted step; returns whether a limit point was found
    before the milestone, and the Newton iterations of rejected steps.

    Parameters
    ----------
    stepper
        The wall at its accepted state, under a pressure that is linear in time up to the milestone.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    precision
        Allowed relative error of the volume.
    growth_rate
        Rate of the volume at the accepted state in µm³/min, not zero.
    milestone
        Time in min that must not be passed.
    record
        Called with Newton iterations and length in min of each accepted step.
    """
    shell = stepper.shell
    if shell.growth is None:
        raise ValueError("an elastic wall does not change in time")
    rejected = 0
    fraction = _LARGEST_STEP * min(1.0, 0.8 * (precision / 1e-4) ** (1 / _TABLEAU.order))
    largest = copysign(fraction * shell.volume(), growth_rate)
    change, first_rate = 0.5 * largest, growth_rate
    beginning, pressure = stepper.accepted.time, stepper.pressure
    slope = (pressure(milestone) - pressure(beginning)) / (milestone - beginning)
    with BorderedNewton(shell, shell.growth.stage, tolerance) as solver:
        for _ in range(_MOST_GROWTH_STEPS):
            start, volume = stepper.accepted.time, shell.volume()
            try:
                guess = change / growth_rate
                iterations, dt = _attempt(stepper, solver, volume + change, guess, slope)
            except EquilibriumError as error:
                rejected += error.iterations
                change /= 4
                if abs(change) < _LEAST_GROWTH_STEP * volume:
                    return False, rejected
                continue
            if dt <= 0:
                stepper.reject()
                rejected += iterations
                # Time is a parabola of the volume here: half of what it could still gain.
                if change / growth_rate < _SHARPNESS * max(start, milestone - beginning):
                    # Towards a limit point the volume changes ever faster; else it turns here.
                    return abs(growth_rate) > abs(first_rate), rejected
                change /= 2
                continue
            if start + dt > milestone:
                stepper.reject()
                return False, rejected + iterations
            stepper.accept(start + dt)
            yield record(iterations, dt)
            growth_rate = change / dt
            change = min(1.5 * change, largest, key=abs)
    return False, rejected


def _attempt(
    stepper: TimeStepper, solver: BorderedNewton, volume: float, dt: float, slope: float
) -> tuple[int, float]:
    """Make a trial step to a volume; return Newton iterations and the time in min that it takes.

    Near a limit point, where the volume changes ever faster in time, time is a smooth function of
    the volume; it is not positive past the limit point. `dt` is its initial guess, and `slope`
    the rate of the pressure in MPa/min.
    """
    growth, accepted = stepper.shell.growth, stepper.accepted.eps_g
    assert growth is not None and accepted is not None
    growth.set_interval(stepper.accepted.time, stepper.accepted.time)  # no milestone is passed
    start, pressure = stepper.shell.volume(), stepper.pressure(stepper.accepted.time)
    A, c = _TABLEAU.A, _TABLEAU.c
    durations: list[float] = []
    changes: list[Array] = []  # of the growth strains, as over the whole step
    iterations = 0
    try:
        for i in range(len(c)):
            base = accepted + sum(a * k for a, k in zip(A[i], changes, strict=False))
            growth.stage.value = A[i, i] * (durations[-1] if durations else dt)
            growth.set_base(base)
            growth.set(base + A[i, i] * changes[-1] if changes else base)
            elapsed = sum(a * d for a, d in zip(A[i], durations, strict=False))
            ramp = (pressure + slope * elapsed, slope)
            iterations += solver.solve(start + c[i] * (volume - start), ramp=ramp)
            time = stepper.accepted.time + elapsed + float(growth.stage.value)
            stepper.note_stage(time, A[i, : i + 1])
            durations.append(float(growth.stage.value) / A[i, i])
            changes.append((growth.get() - base) / A[i, i])
            if durations[-1] <= 0:
                return iterations, durations[-1]
    except BaseException:
        stepper.reject()
        raise
    finally:
        growth.stage.value = 0.0
    return iterations, float(_TABLEAU.b @ durations)


# --- under rising pressure ----------------------------------------------------------------


@dataclass(frozen=True)
class LimitPressure:
    """A limit pressure in MPa, and the Newton iterations of its search."""

    pressure: float
    iterations: int


def find_limit_pressure(shell: Shell, pressure: float, tolerance: float) -> LimitPressure | None:
    """Find the limit point between the trial state and a pressure; None if there is none.

    At given growth. The trial state moves to just before the limit point or, without one, to
    about the given pressure.

    Parameters
    ----------
    shell
        The wall in equilibrium.
    pressure
        Pressure in MPa to be reached, of either sign.
    tolerance
        Norm of the residual in µN at which it counts as zero.

    Raises
    ------
    PathError
        If no step along the path converges.
    """
    sign = copysign(1.0, pressure - float(shell.pressure.value))
    size, unit = shell.reference_volume, shell.membrane_stiffness / (3 * shell.radius)
    coordinates = PathCoordinates(shell.pressure, size, unit)
    target, closed = PathTarget(1, pressure / unit), shell.discretisation.ends == ("pole", "pole")
    ahead = abs(pressure - float(shell.pressure.value)) / unit
    steps, iterations = ceil(ahead / _LARGEST_STEP), 0
    points = deque([(shell.volume(), float(shell.pressure.value), shell.state())], maxlen=3)
    for more in follow_path(shell, coordinates, "volume", target, steps, tolerance, closed):
        iterations += more
        points.append((shell.volume(), float(shell.pressure.value), shell.state()))
        if len(points) > 2 and sign * (points[-1][1] - points[-2][1]) < 0:
            break
    else:
        return None
    volumes, pressures = (np.array([point[i] for point in points]) for i in range(2))
    _, found, before = points[-2]
    shell.restore(before)
    shell.pressure.value = found
    if (sign * np.diff(volumes) > 0).all():
        top = np.polynomial.Polynomial.fit(volumes, pressures, 2).deriv().roots()[0]
        newton = BorderedNewton(shell, shell.pressure, tolerance)
        with suppress(EquilibriumError), newton as solver:  # the last point is near enough
            iterations += solver.solve(float(np.real(top)) - sign * _BEFORE * size)
        found = float(shell.pressure.value)
    return LimitPressure(found, iterations) if sign * (pressure - found) > 0 else None


# --- under a rising force -----------------------------------------------------------------


def find_limit_force(
    shell: Shell, coordinates: PathCoordinates, force: float, tolerance: float, closed: bool
) -> float | None:
    """Find the limit point between the trial state and a force; None if there is none.

    Returns the limit force in µN. The trial state moves along the path, by displacement.

    Parameters
    ----------
    shell, tolerance
        As in `find_limit_pressure`.
    coordinates
        Displacement and force, and their units.
    force
        Force in µN to be reached, of either sign.
    closed
        Whether the wall is closed, as in `follow_path`.

    Raises
    ------
    PathError
        If no step along the path converges.
    """
    largest, target = 0.0, PathTarget(1, force / coordinates.load_unit)
    steps = max(_FEWEST_STEPS, ceil(abs(target.value) / _LARGEST_DISPLACEMENT))
    for _ in follow_path(shell, coordinates, "displacement", target, steps, tolerance, closed):
        reached = float(coordinates.load.value)
        if abs(reached) < abs(largest):
            return largest
        largest = reached
    return None
