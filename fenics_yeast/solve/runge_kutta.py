"""Runge-Kutta methods for the growth strain, by their Butcher tableaux.

A stage whose diagonal entry is zero is explicit; a first explicit stage is the accepted state
and costs nothing. Explicit stages after the first need an equilibrium at given growth, implicit
ones an equilibrium with growth that follows the strain.

References
----------
R. Alexander, Diagonally implicit Runge-Kutta methods for stiff O.D.E.'s, SIAM J. Numer. Anal. 14
(1977) 1006-1021. E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, Springer 1996.
"""

from dataclasses import dataclass

import numpy as np

from ..geometry import Array


@dataclass(frozen=True)
class ButcherTableau:
    """A diagonally implicit or explicit Runge-Kutta method with an error estimate.

    Attributes
    ----------
    A, b
        Coefficients of the stages, lower triangular, shape ``(s, s)``; weights, shape ``(s,)``.
    order
        Order of the solution.
    embedded
        Weights of a second solution, of the order below or above, whose difference from the first
        estimates the error of a step, shape ``(s,)``.
    estimate_order
        Power of the step size with which the estimate falls.
    caution
        Part of the allowed error at the end that the estimate of one step may reach. Measured on
        growing buds: the estimate is that of the lower order, far above the error of `sdirk3`.
    """

    name: str
    A: Array
    b: Array
    order: int
    embedded: Array
    estimate_order: int
    caution: float

    @property
    def c(self) -> Array:
        """Times of the stages in parts of the step, shape ``(s,)``."""
        return self.A.sum(axis=1)

    @property
    def is_explicit(self) -> bool:
        """Whether no stage is implicit; the step size then has a stability limit."""
        return not self.A.diagonal().any()

    @property
    def is_stiffly_accurate(self) -> bool:
        """Whether the last stage is the end of the step, and so an equilibrium."""
        return bool(np.array_equal(self.A[-1], self.b))


def _euler(name: str, A: Array) -> ButcherTableau:
    """First order; the estimate is the difference from Heun's method or the trapezoidal rule."""
    return ButcherTableau(name, A, A[-1], 1, np.array([0.5, 0.5]), 2, 0.02)


def _sdirk2() -> ButcherTableau:
    """Two stages, L-stable: Alexander (1977)."""
    g = 1 - np.sqrt(0.5)
    A = np.array([[g, 0.0], [1 - g, g]])
    return ButcherTableau("sdirk2", A, A[-1], 2, np.array([1.0, 0.0]), 2, 1.0)


def _sdirk3() -> ButcherTableau:
    """Three stages, L-stable: Alexander (1977); embedded the second order of two stages."""
    g = float(np.roots([1, -3, 1.5, -1 / 6])[1].real)  # the root between 1/6 and 1/2
    b1, b2 = -(6 * g**2 - 16 * g + 1) / 4, (6 * g**2 - 20 * g + 5) / 4
    A = np.array([[g, 0.0, 0.0], [(1 - g) / 2, g, 0.0], [b1, b2, g]])
    embedded = np.array([g, 1 - 2 * g, 0.0]) / (1 - g)
    return ButcherTableau("sdirk3", A, A[-1], 3, embedded, 3, 20.0)


TABLEAUX = {
    tableau.name: tableau
    for tableau in (
        _euler("forward-euler", np.array([[0.0, 0.0], [1.0, 0.0]])),
        _euler("backward-euler", np.array([[0.0, 0.0], [0.0, 1.0]])),
        _sdirk2(),
        _sdirk3(),
    )
}
