"""Locate the first bifurcation: in a time step, or between two points of an equilibrium path."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..geometry import Array
from ..mechanics import Shell, ShellState
from ..solve import BorderedNewton, EquilibriumError, PathCoordinates, StepResult, TimeStepper
from .waves import WaveCheck

_LOCATED = 5e-5  # of the time and of the load
_MOST_HALVINGS = 40


class FallingModes:
    """The modes that fall beyond a bifurcation, of which fewer remain the nearer it is.

    Called at a trial state, it says whether any of them falls there. It begins with all that fall
    in the present trial state.

    Parameters
    ----------
    check
        Finds modes with waves around the axis.
    unstable
        Whether an axisymmetric mode falls in the trial state.
    """

    def __init__(self, check: WaveCheck, unstable: Callable[[], bool]) -> None:
        self._check, self._unstable = check, unstable
        self._numbers = [*([0] if unstable() else []), *check.falling()]

    def __call__(self) -> bool:
        axisymmetric = 0 in self._numbers and self._unstable()
        waves = [n for n in self._numbers if n > 0]
        now = [*([0] if axisymmetric else []), *self._check.falling(waves)]
        self._numbers = now or self._numbers
        return bool(now)

    @property
    def waves(self) -> int:
        """The smallest number of waves of a mode that fell in the last unstable state."""
        return self._numbers[0]


def end_before(
    stepper: TimeStepper, falls: Callable[[], bool], end: float
) -> tuple[StepResult, float, int]:
    """Shorten a trial step to one that ends just before any mode falls.

    Parameters
    ----------
    stepper
        The wall, with a trial step in which a mode falls.
    falls
        Whether a mode falls in the trial state, or it is past a limit point.
    end
        End of the trial step in min.

    Returns
    -------
    tuple of StepResult, float, int
        The new trial step and its end, the given end if a mode falls from the start on; Newton
        iterations of the other trials.
    """
    iterations, start = 0, stepper.accepted.time
    stable = start
    unstable = end
    pressure = stepper.pressure
    for _ in range(_MOST_HALVINGS):
        apart = abs(pressure(unstable) - pressure(stable))
        near = apart <= _LOCATED * abs(pressure(unstable))
        if near and unstable - stable <= _LOCATED * unstable:
            break
        middle = (stable + unstable) / 2
        stepper.reject()
        try:
            iterations += stepper.attempt(middle).iterations
            beyond = falls()
        except EquilibriumError as error:
            iterations += error.iterations
            beyond = True
        stable, unstable = (stable, middle) if beyond else (middle, unstable)
    stepper.reject()
    end = stable if stable > start else end
    return stepper.attempt(end), end, iterations


def point_before(
    shell: Shell,
    coordinates: PathCoordinates,
    falls: Callable[[], bool],
    last: tuple[ShellState, float],
    tolerance: float,
) -> tuple[int, bool]:
    """Move a shell along its path to the point just before any mode falls.

    Halves the chord between two points; the path may turn back between them in its load or in the
    conjugate of that.

    Parameters
    ----------
    shell, coordinates, tolerance
        The wall at a point at which a mode falls, its path, the residual in µN that is zero.
    falls
        Whether a mode falls in the trial state.
    last
        State and load of the point before.

    Returns
    -------
    tuple of int, bool
        Newton iterations, and whether there is a stable point after the last one; otherwise the
        shell is at that one.
    """
    load, iterations = coordinates.load, 0
    units = np.array([coordinates.conjugate_unit, coordinates.load_unit])
    with BorderedNewton(shell, load, tolerance) as solver:

        def here() -> tuple[ShellState, Array]:
            return shell.state(), np.array([solver.conjugate(), load.value])

        upper = here()
        _move(shell, load, *last)
        lower = here()
        for _ in range(_MOST_HALVINGS):
            chord = upper[1] - lower[1]
            if (abs(chord) <= _LOCATED * abs(upper[1])).all():
                break
            direction = chord / units / np.linalg.norm(chord / units)
            weights = direction[0], direction[1] * units[0] / units[1]  # the sum is a conjugate
            middle = (lower[1] + upper[1]) / 2
            shell.w.x.array[:] = (lower[0].w + upper[0].w) / 2
            load.value = middle[1]
            try:
                iterations += solver.solve(float(middle @ weights), weights)
            except EquilibriumError as error:
                iterations += error.iterations
                break
            if falls():
                upper = here()
            else:
                lower = here()
    _move(shell, load, lower[0], lower[1][1])
    return iterations, lower[1][1] != last[1]


def _move(shell: Shell, load: Any, state: ShellState, value: float) -> None:
    shell.restore(state)
    load.value = value
