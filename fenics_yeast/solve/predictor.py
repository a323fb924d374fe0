"""Predict the next solution of a series by polynomial extrapolation from the last ones."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry import Array

Solution = tuple[float, Array]
"""Parameter (time in min, or length along a path) and the solution there."""


def extrapolate(solutions: Sequence[Solution], at: float) -> Array:
    """Return the value at a parameter of the polynomial (Lagrange) through some solutions."""
    predicted = np.zeros(len(solutions[-1][1]))
    for i, (t, w) in enumerate(solutions):
        weight = 1.0
        for j, (s, _) in enumerate(solutions):
            if j != i:
                weight *= (at - s) / (t - s)
        predicted += weight * w
    return predicted


class Predictor:
    """Initial guess of Newton's method in time, from the last solutions.

    Parameters
    ----------
    constrained
        DOFs that no solution moves; they keep their value to the last digit.
    memory
        From how many solutions it extrapolates: more for short and equal steps, fewer for steps
        that adapt.

    Attributes
    ----------
    solutions
        The last solutions and their times in min, those of stages among them; at least one.
    """

    def __init__(self, constrained: NDArray[np.int32], memory: int) -> None:
        self._constrained, self._memory = constrained, memory
        self.solutions: tuple[Solution, ...] = ()

    def predict(self, time: float) -> Array:
        """Return the extrapolated solution at a time in min."""
        predicted, last = extrapolate(self.solutions, time), self.solutions[-1][1]
        predicted[self._constrained] = last[self._constrained]
        return predicted

    def add(self, time: float, w: Array) -> None:
        """Add a solution; it replaces one at the same time."""
        earlier = tuple(solution for solution in self.solutions if solution[0] != time)
        self.solutions = (*earlier, (time, w))[-self._memory :]
