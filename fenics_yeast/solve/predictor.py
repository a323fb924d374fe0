"""Predict the next solution of a series by polynomial extrapolation from the last ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Solution = tuple[float, Array]
"""Parameter (time in min, or length along a path) and the solution there."""

_MOST_SOLUTIONS = 5


def extrapolate(solutions: Sequence[Solution], at: float) -> Array:
    """Return the value at a parameter of the polynomial (Lagrange) through some solutions."""
    predicted = np.zeros_like(solutions[-1][1])
    for i, (t, w) in enumerate(solutions):
        weight = 1.0
        for j, (s, _) in enumerate(solutions):
            if j != i:
                weight *= (at - s) / (t - s)
        predicted += weight * w
    return predicted


class Predictor:
    """Initial guess of Newton's method in time, from the last five solutions.

    Parameters
    ----------
    constrained
        DOFs that no solution moves; they keep their value to the last digit.

    Attributes
    ----------
    solutions
        The last solutions by time in min, stages of the steps included; never changed in place.
    """

    def __init__(self, constrained: NDArray[np.int32]) -> None:
        self._constrained = constrained
        self.solutions: tuple[Solution, ...] = ()

    def predict(self, time: float) -> Array:
        """Return the extrapolated solution at a time in min."""
        predicted, last = extrapolate(self.solutions, time), self.solutions[-1][1]
        predicted[self._constrained] = last[self._constrained]
        return predicted

    def add(self, time: float, w: Array) -> None:
        """Add a solution; it replaces the last one if that has the same time."""
        kept = self.solutions
        if kept and kept[-1][0] == time:  # steps too short to tell apart
            kept = kept[:-1]
        self.solutions = (*kept, (time, w))[-_MOST_SOLUTIONS:]
