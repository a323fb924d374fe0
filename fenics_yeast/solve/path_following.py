"""Path following: the equilibria of a wall at given growth under a changing load.

Along the path the load, its conjugate (volume of a pressure, displacement of a force) or the arc
length between points is prescribed. The arc-length method takes the path over limit points of the
load: Riks (1979) and Keller (1977), cited in `continuation`.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, hypot
from typing import Any, Literal

import numpy as np

from ..geometry import Array
from ..mechanics import Shell
from .continuation import BorderedNewton
from .equilibrium import EquilibriumError
from .predictor import extrapolate

Control = Literal["pressure", "volume", "arc-length", "force", "displacement"]

LEAST_STEP = 2.0**-10  # of the first step
_LENGTHENING = 1.05  # of steps beyond the number asked for
_NEAR = 1e-7  # of a unit: closer to the target is at the target
_MOST_POINTS = 20  # times the number of steps asked for


class PathError(RuntimeError):
    """The path has no further point under this control; the shell is at its last point."""


@dataclass(frozen=True)
class PathCoordinates:
    """The plane in which a path runs: the conjugate of a load, and the load.

    Attributes
    ----------
    load
        `shell.pressure` or `shell.force`, whose value is the unknown.
    conjugate_unit, load_unit
        Units of the coordinates: volume in µm³ and pressure in MPa, or displacement in µm and
        force in µN. The arc length is measured in these units.
    """

    load: Any
    conjugate_unit: float
    load_unit: float


@dataclass(frozen=True)
class PathTarget:
    """Where a path ends: coordinate 0, the conjugate, or 1, the load, and its value in its unit."""

    axis: Literal[0, 1]
    value: float


def follow_path(
    shell: Shell,
    coordinates: PathCoordinates,
    control: Control,
    target: PathTarget,
    steps: int,
    tolerance: float,
    closed: bool,
) -> Iterator[int]:
    """Follow the equilibrium path of a wall from its trial state to a target.

    Yields the Newton iterations of each point, whose state and load are then those of the shell.

    Parameters
    ----------
    shell
        The wall in equilibrium, without this load.
    coordinates
        The load, its conjugate and their units.
    control
        What is prescribed from point to point: the load, its conjugate, or the arc length.
    target
        Where the path ends; the last point meets it exactly.
    steps
        Number of steps to begin with; their size is reduced if Newton's method fails.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    closed
        Whether the wall is closed, so that a volume below 0 means that it is inside out.

    Raises
    ------
    PathError
        At a limit point that the control cannot pass, or if no step converges.
    """
    with BorderedNewton(shell, coordinates.load, tolerance) as solver:

        def position() -> tuple[float, float]:
            return (
                solver.conjugate() / coordinates.conjugate_unit,
                coordinates.load.value / coordinates.load_unit,
            )

        def solve(direction: Array, projection: float) -> int:
            """Find the equilibrium whose position has a given projection on a direction."""
            weights = (
                direction[0] / coordinates.conjugate_unit,
                direction[1] / coordinates.load_unit,
            )
            iterations = solver.solve(projection, weights)
            if closed and shell.volume() <= 0:
                raise EquilibriumError("only a wall that is inside out was found", iterations)
            return iterations

        v, q = position()
        points = deque([(0.0, _state(shell, coordinates))], maxlen=3)  # by length along the path
        span = target.value - (v, q)[target.axis]
        if abs(span) < _NEAR:
            return
        step = whole = abs(span) / steps
        # Also an arc starts as a step in the conjugate.
        direction = np.array([copysign(1.0, span), 0.0])
        if control in ("pressure", "force"):
            direction = direction[::-1]
        for count in range(_MOST_POINTS * steps):
            try:
                _set_state(shell, coordinates, extrapolate(points, points[-1][0] + step))
                iterations = solve(direction, float(direction @ (v, q)) + step)
                new = position()
                ahead = (target.value - new[target.axis]) * copysign(
                    1.0, target.value - (v, q)[target.axis]
                )
                passed = ahead < _NEAR
                if passed:
                    iterations += solve(np.eye(2)[target.axis], target.value)
            except EquilibriumError as error:
                _set_state(shell, coordinates, points[-1][1])
                step /= 2
                if step < LEAST_STEP * whole:
                    raise PathError(f"no step from here converged: {error}") from error
                continue
            points.append((points[-1][0] + step, _state(shell, coordinates)))
            yield iterations
            if passed:
                return
            if control == "arc-length":
                direction = np.array([new[0] - v, new[1] - q]) / hypot(new[0] - v, new[1] - q)
            if count > steps:  # the path is longer than the steps asked for
                whole *= _LENGTHENING
            (v, q), step = new, min(whole, 1.5 * step)
    raise PathError(f"the target was not reached in {_MOST_POINTS * steps} points")


def _state(shell: Shell, coordinates: PathCoordinates) -> Array:
    """Return trial state and load in one array."""
    return np.append(shell.w.x.array, float(coordinates.load.value))


def _set_state(shell: Shell, coordinates: PathCoordinates, state: Array) -> None:
    shell.w.x.array[:], coordinates.load.value = state[:-1], float(state[-1])
