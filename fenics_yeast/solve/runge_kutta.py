"""Runge-Kutta methods for the growth strain, as tableaux.

Every method here has `b` equal to the last row of `A`: its last stage is the end of the step, in
equilibrium there. A stage whose diagonal entry is zero is explicit; a first explicit stage is the
accepted state itself and costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ButcherTableau:
    """A stiffly accurate diagonally implicit Runge-Kutta method with an error estimate.

    Attributes
    ----------
    A
        Coefficients of the stages, lower triangular, shape ``(s, s)``.
    order
        Order of the solution.
    embedded
        Weights of a second solution, of the order below or above, whose distance from the first
        estimates the error of a step, shape ``(s,)``.
    estimate_order
        Power of the step with which the estimate falls.
    caution
        Part of the wanted error at the end that the estimate of one step may reach. Measured on
        growing buds: the estimate is that of the lower order, far above the error of `sdirk3`.
    """

    name: str
    A: Array
    order: int
    embedded: Array
    estimate_order: int
    caution: float

    @property
    def c(self) -> Array:
        """Times of the stages in parts of the step, shape ``(s,)``."""
        return self.A.sum(axis=1)


def _forward_euler() -> ButcherTableau:
    """Its estimate is the distance from Heun's method."""
    A = np.array([[0.0, 0.0], [1.0, 0.0]])
    return ButcherTableau("forward-euler", A, 1, np.array([0.5, 0.5]), 2, 0.02)


def _backward_euler() -> ButcherTableau:
    """Its estimate is the distance from the trapezoidal rule."""
    A = np.array([[0.0, 0.0], [0.0, 1.0]])
    return ButcherTableau("backward-euler", A, 1, np.array([0.5, 0.5]), 2, 0.02)


def _sdirk2() -> ButcherTableau:
    """Two stages, L-stable: Alexander (1977), SIAM J. Numer. Anal. 14, 1006-1021."""
    g = 1 - np.sqrt(0.5)
    return ButcherTableau(
        "sdirk2", np.array([[g, 0.0], [1 - g, g]]), 2, np.array([1.0, 0.0]), 2, 1.0
    )


def _sdirk3() -> ButcherTableau:
    """Three stages, L-stable: Alexander (1977); embedded the second order of two stages."""
    g = float(np.roots([1, -3, 1.5, -1 / 6])[1].real)  # the root between 1/6 and 1/2
    b1, b2 = -(6 * g**2 - 16 * g + 1) / 4, (6 * g**2 - 20 * g + 5) / 4
    A = np.array([[g, 0.0, 0.0], [(1 - g) / 2, g, 0.0], [b1, b2, g]])
    return ButcherTableau("sdirk3", A, 3, np.array([g, 1 - 2 * g, 0.0]) / (1 - g), 3, 20.0)


TABLEAUX = {
    tableau.name: tableau for tableau in (_forward_euler(), _backward_euler(), _sdirk2(), _sdirk3())
}
