"""Locate the first bifurcation: in a time step, or between two points of an equilibrium path."""

from collections.abc import Callable
from typing import Any

from ..mechanics import Shell, ShellState
from ..solve import BorderedNewton, EquilibriumError, StepResult, TimeStepper

_LOCATED = 5e-5  # of the time and of the load
_MOST_HALVINGS = 40


def end_before(
    stepper: TimeStepper, falls: Callable[[], bool], end: float
) -> tuple[StepResult, float]:
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
    tuple of StepResult, float
        The new trial step and its end; the given end if a mode falls from the start on.
    """
    start = stable = stepper.accepted.time
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
            stepper.attempt(middle)
            beyond = falls()
        except EquilibriumError:
            beyond = True
        stable, unstable = (stable, middle) if beyond else (middle, unstable)
    stepper.reject()
    end = stable if stable > start else end
    return stepper.attempt(end), end


def point_before(
    shell: Shell, load: Any, falls: Callable[[], bool], last: tuple[ShellState, float],
    tolerance: float,
) -> bool:  # fmt: skip
    """Move a shell along its path to the point just before any mode falls.

    Parameters
    ----------
    shell, load, tolerance
        The wall at a point at which a mode falls, the varying load, the residual that is zero.
    falls
        Whether a mode falls in the trial state.
    last
        State and load of the point before.

    Returns
    -------
    bool
        Whether there is a stable point after the last one; otherwise the shell is at that one.
    """
    lower, low = last
    upper, high = shell.state(), float(load.value)
    with BorderedNewton(shell, load, tolerance) as solver:
        conjugates = [solver.conjugate()]
        _move(shell, load, lower, low)
        conjugates.insert(0, solver.conjugate())
        while abs(high - low) > _LOCATED * abs(high):
            shell.w.x.array[:] = (lower.w + upper.w) / 2
            load.value = (low + high) / 2
            try:
                solver.solve(sum(conjugates) / 2)
            except EquilibriumError:  # the conjugate turns back between the two
                break
            if falls():
                upper, high, conjugates[1] = shell.state(), float(load.value), solver.conjugate()
            else:
                lower, low, conjugates[0] = shell.state(), float(load.value), solver.conjugate()
    _move(shell, load, lower, low)
    return low != last[1]


def _move(shell: Shell, load: Any, state: ShellState, value: float) -> None:
    shell.restore(state)
    load.value = value
