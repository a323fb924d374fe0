"""The static path of a wall at given growth: its equilibria under changing pressure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import copysign, hypot
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..mechanics import Shell
from .continuation import BorderedNewton
from .equilibrium import EquilibriumError

Array = NDArray[np.float64]
Control = Literal["pressure", "volume", "arc-length", "force", "displacement"]

_LEAST_STEP = 2.0**-10  # of the first one
_LENGTHENED = 1.05  # growth of steps beyond those asked for
_NEAR = 1e-7  # of a unit: what is nearer to the goal is there
_MOST_POINTS = 20  # times the number of steps asked for
_LARGEST_VOLUME_STEP, _MOST_VOLUME_STEPS = (
    0.02,
    1000,
)  # steps of the volume in search of a limit point
_BEFORE = 2e-4  # of the volume: how far before a limit point it is told and left


class PathError(RuntimeError):
    """The path goes no further under this control; the shell is at its last point."""


@dataclass(frozen=True)
class PathCoordinates:
    """The plane in which a path runs: what a load works on, and the load.

    Attributes
    ----------
    load
        `shell.pressure` or `shell.force`, whose value is the unknown.
    amount_unit, load_unit
        Units of the coordinates: volume in µm³ and pressure in MPa, or displacement in µm and
        force in µN. An arc is as long as it is in these units.
    """

    load: Any
    amount_unit: float
    load_unit: float


@dataclass(frozen=True)
class PathTarget:
    """Where a path ends: the coordinate that is given, 0 the amount and 1 the load, and its value.

    The value is in the unit of the coordinate.
    """

    axis: Literal[0, 1]
    value: float


def follow_path(
    shell: Shell,
    coordinates: PathCoordinates,
    control: Control,
    target: PathTarget,
    steps: int,
    tolerance: float,
) -> Iterator[int]:
    """Walk along the equilibria of a wall under a growing load until a goal.

    Yields the Newton iterations of each point. After each point the shell's trial state and load
    are those of the point.

    Parameters
    ----------
    shell
        The wall in equilibrium, without this load.
    plane
        What the load is.
    control
        What is prescribed from point to point: the load, the amount that it works on, or the
        length of the arc.
    goal
        Where the path ends; that point is hit exactly.
    steps
        Number of steps to begin with; they are cut where Newton's method fails.
    tolerance
        Norm of the residual in µN at which it counts as zero.

    Raises
    ------
    PathError
        At a limit point that the control cannot pass, or where no step converges.
    """
    with BorderedNewton(shell, coordinates.load, tolerance) as solver:

        def place() -> tuple[float, float]:
            return (
                solver.amount() / coordinates.amount_unit,
                coordinates.load.value / coordinates.load_unit,
            )

        def solve(along: Array, target: float) -> int:
            """Equilibrium where the point's projection on a direction has a given length."""
            return solver.solve(
                target,
                by_amount=along[0] / coordinates.amount_unit,
                by_parameter=along[1] / coordinates.load_unit,
            )

        def find(along: Array, target: float) -> int:
            """The same, on this side of nothing: a closed wall inside out is another branch."""
            iterations = solve(along, target)
            if closed and shell.volume() <= 0:
                raise EquilibriumError("only a wall that is inside out was found", iterations)
            return iterations

        closed = shell.discretisation.ends == ("pole", "pole")
        v, q = place()
        points = deque([(0.0, _state(shell, coordinates))], maxlen=3)
        span = target.value - (v, q)[target.axis]
        if abs(span) < _NEAR:
            return
        step = whole = abs(span) / steps
        along = np.array([copysign(1.0, span), 0.0])  # the first step is one in the amount
        if control in ("pressure", "force"):
            along = along[::-1]
        for count in range(_MOST_POINTS * steps):
            try:
                _predict(shell, coordinates, points, points[-1][0] + step)
                iterations = find(along, float(along @ (v, q)) + step)
                new = place()
                ahead = (target.value - new[target.axis]) * copysign(
                    1.0, target.value - (v, q)[target.axis]
                )
                passed = ahead < _NEAR
                if passed:
                    iterations += find(np.eye(2)[target.axis], target.value)
            except EquilibriumError as error:
                _set_state(shell, coordinates, points[-1][1])
                step /= 2
                if step < _LEAST_STEP * whole:
                    raise PathError(f"no step from here converged: {error}") from error
                continue
            points.append((points[-1][0] + step, _state(shell, coordinates)))
            yield iterations
            if passed:
                return
            if control == "arc-length":
                along = np.array([new[0] - v, new[1] - q]) / hypot(new[0] - v, new[1] - q)
            if count > steps:  # the way is longer than the steps asked for
                whole *= _LENGTHENED
            (v, q), step = new, min(whole, 1.5 * step)
    raise PathError(f"{_MOST_POINTS * steps} points did not reach the goal")


def _state(shell: Shell, coordinates: PathCoordinates) -> Array:
    """State of a shell and its load in one array."""
    return np.append(shell.w.x.array, float(coordinates.load.value))


def _set_state(shell: Shell, coordinates: PathCoordinates, state: Array) -> None:
    shell.w.x.array[:], coordinates.load.value = state[:-1], float(state[-1])


def _predict(
    shell: Shell, coordinates: PathCoordinates, points: Sequence[tuple[float, Array]], place: float
) -> None:
    """Start a solution from the polynomial through the last points of the path."""
    start = np.zeros_like(points[-1][1])
    for i, (s, state) in enumerate(points):
        others = [t for j, (t, _) in enumerate(points) if j != i]
        start += state * np.prod([(place - t) / (s - t) for t in others])
    _set_state(shell, coordinates, start)


@dataclass(frozen=True)
class LimitPressure:
    """A largest pressure on a path: in MPa, and the iterations it took to find it."""

    pressure: float
    iterations: int


def find_limit_pressure(shell: Shell, pressure: float, tolerance: float) -> LimitPressure | None:
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
    step, spent, size = _LARGEST_VOLUME_STEP, 0, shell.reference_volume
    with BorderedNewton(shell, shell.pressure, tolerance) as solver:
        for _ in range(_MOST_VOLUME_STEPS):
            try:
                spent += solver.solve(points[-1][0] + sign * step * size)
            except EquilibriumError as error:
                spent += error.iterations
                step /= 2
                if step < _LEAST_STEP * _LARGEST_VOLUME_STEP:
                    raise PathError(f"no step from here converged: {error}") from error
                continue
            points.append((shell.volume(), float(shell.pressure.value)))
            step = min(_LARGEST_VOLUME_STEP, 1.5 * step)
            if len(points) > 2 and sign * (points[-1][1] - points[-2][1]) < 0:
                volumes, pressures = np.array(points[-3:]).T
                top = np.polynomial.Polynomial.fit(volumes, pressures, 2).deriv().roots()[0]
                spent += solver.solve(float(np.real(top)) - sign * _BEFORE * size)
                found = float(shell.pressure.value)
                return LimitPressure(found, spent) if sign * (pressure - found) > 0 else None
            if sign * (pressure - points[-1][1]) <= 0:
                return None
    raise PathError(f"{_MOST_VOLUME_STEPS} steps in volume did not reach the pressure")
