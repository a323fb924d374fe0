"""The static path of a wall at given growth: its equilibria under changing pressure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import copysign, hypot
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .equilibrium import EquilibriumError
from .shell import Shell
from .volume_control import VolumeControl

Array = NDArray[np.float64]
Control = Literal["pressure", "volume", "arc-length"]

_LEAST_STEP = 2.0**-10  # of the first one
_MOST_POINTS = 20  # times the number of steps asked for
_LARGEST_WALK, _MOST_WALKED = 0.02, 1000  # steps of the volume in search of a limit point
_BEFORE = 2e-4  # of the volume: how far before a limit point it is told and left


class PathError(RuntimeError):
    """The path goes no further under this control; the shell is at its last point."""


@dataclass(frozen=True)
class Goal:
    """Where a path ends: at a volume ratio or at a pressure in MPa; one of them is None."""

    volume_ratio: float | None = None
    pressure: float | None = None

    def coordinate(self, unit: float) -> tuple[int, float]:
        """Which coordinate of the plane of volume ratio and pressure it fixes, and its value."""
        if self.volume_ratio is not None:
            return 0, self.volume_ratio
        return 1, (self.pressure or 0.0) / unit


def follow(
    shell: Shell, control: Control, goal: Goal, steps: int, unit: float, tolerance: float
) -> Iterator[int]:
    """Walk along the equilibria of an unloaded wall until a goal; yields Newton iterations.

    After each point the shell's trial state and pressure are those of the point.

    Parameters
    ----------
    shell
        The wall, unloaded.
    control
        What is prescribed from point to point: pressure, volume, or the length of the arc in the
        plane of `V/V0` and of the pressure in its unit.
    goal
        Where the path ends; that point is hit exactly.
    steps
        Number of steps to begin with; they are cut where Newton's method fails.
    unit
        Pressure in MPa that counts as much as a doubling of the volume.
    tolerance
        Norm of the residual in µN at which it counts as zero.

    Raises
    ------
    PathError
        At a limit point that the control cannot pass, or where no step converges.
    """
    volume_0 = shell.reference_volume
    v, q = _place(shell, volume_0, unit)
    points: deque[tuple[float, Array]] = deque([(0.0, _state(shell))], maxlen=3)
    axis, target = goal.coordinate(unit)
    span = target - (v, q)[axis]
    step = whole = abs(span) / steps
    along = np.array([copysign(1.0, span), 0.0])  # the first step is one in volume
    if control == "pressure":
        along = along[::-1]
    with VolumeControl(shell, shell.pressure, tolerance) as solver:
        for _ in range(_MOST_POINTS * steps):
            try:
                _predict(shell, points, points[-1][0] + step)
                iterations = _solve(solver, along, float(along @ (v, q)) + step, volume_0, unit)
                new = _place(shell, volume_0, unit)
                passed = _passed(goal, (v, q), new, unit)
                if passed is not None:
                    iterations += _solve(solver, *passed, volume_0, unit)
            except EquilibriumError as error:
                _set_state(shell, points[-1][1])
                step /= 2
                if step < _LEAST_STEP * whole:
                    raise PathError(f"no step from here converged: {error}") from error
                continue
            points.append((points[-1][0] + step, _state(shell)))
            yield iterations
            if passed is not None:
                return
            if control == "arc-length":
                along = np.array([new[0] - v, new[1] - q]) / hypot(new[0] - v, new[1] - q)
            (v, q), step = new, min(whole, 1.5 * step)
    raise PathError(f"{_MOST_POINTS * steps} points did not reach the goal")


def _state(shell: Shell) -> Array:
    """State and pressure of a shell in one array."""
    return np.append(shell.w.x.array, float(shell.pressure.value))


def _set_state(shell: Shell, state: Array) -> None:
    shell.w.x.array[:], shell.pressure.value = state[:-1], state[-1]


def _predict(shell: Shell, points: Sequence[tuple[float, Array]], place: float) -> None:
    """Start a solution from the polynomial through the last points of the path."""
    start = np.zeros_like(points[-1][1])
    for i, (s, state) in enumerate(points):
        others = [t for j, (t, _) in enumerate(points) if j != i]
        start += state * np.prod([(place - t) / (s - t) for t in others])
    _set_state(shell, start)


def _solve(
    solver: VolumeControl, along: np.ndarray, target: float, volume_0: float, unit: float
) -> int:
    """Equilibrium where the point's projection on a direction has a given length."""
    return solver.solve(target, by_volume=along[0] / volume_0, by_parameter=along[1] / unit)


def _place(shell: Shell, volume_0: float, unit: float) -> tuple[float, float]:
    """Point of the path: volume ratio, and pressure in its unit."""
    return shell.volume() / volume_0, float(shell.pressure.value) / unit


def _passed(
    goal: Goal, old: tuple[float, float], new: tuple[float, float], unit: float
) -> tuple[np.ndarray, float] | None:
    """Direction and length that put the last point onto the goal, if it was reached."""
    axis, target = goal.coordinate(unit)
    if (new[axis] - target) * (old[axis] - target) > 0:
        return None
    return np.eye(2)[axis], target


@dataclass(frozen=True)
class LimitPoint:
    """A largest pressure on a path: in MPa, and the iterations it took to find it."""

    pressure: float
    iterations: int


def limit_point(shell: Shell, pressure: float, tolerance: float) -> LimitPoint | None:
    """Look for a limit point on the way from the trial state to a pressure.

    The walk is one in volume, at given growth. The trial state is moved to just before the limit
    point or, where there is none, to about the given pressure.

    Parameters
    ----------
    shell
        The wall in equilibrium.
    pressure
        Pressure in MPa to be reached, of either sign.
    tolerance
        Norm of the residual in µN at which it counts as zero.

    Returns
    -------
    LimitPoint or None
        None if the given pressure was reached.

    Raises
    ------
    PathError
        If no step in volume converges.
    """
    sign = copysign(1.0, pressure - float(shell.pressure.value))
    points = [(shell.volume(), float(shell.pressure.value))]
    step, spent, size = _LARGEST_WALK, 0, shell.reference_volume
    with VolumeControl(shell, shell.pressure, tolerance) as solver:
        for _ in range(_MOST_WALKED):
            try:
                spent += solver.solve(points[-1][0] + sign * step * size)
            except EquilibriumError as error:
                spent += error.iterations
                step /= 2
                if step < _LEAST_STEP * _LARGEST_WALK:
                    raise PathError(f"no step from here converged: {error}") from error
                continue
            points.append((shell.volume(), float(shell.pressure.value)))
            step = min(_LARGEST_WALK, 1.5 * step)
            if len(points) > 2 and sign * (points[-1][1] - points[-2][1]) < 0:
                volumes, pressures = np.array(points[-3:]).T
                top = np.polynomial.Polynomial.fit(volumes, pressures, 2).deriv().roots()[0]
                spent += solver.solve(float(np.real(top)) - sign * _BEFORE * size)
                return LimitPoint(float(shell.pressure.value), spent)
            if sign * (pressure - points[-1][1]) <= 0:
                return None
    raise PathError(f"{_MOST_WALKED} steps in volume did not reach the pressure")
