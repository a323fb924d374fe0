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
class Tableau:
    """A stiffly accurate diagonally implicit Runge-Kutta method.

    Attributes
    ----------
    A
        Coefficients of the stages, lower triangular, shape ``(s, s)``.
    order
        Order of the solution.
    """

    name: str
    A: Array
    order: int

    @property
    def c(self) -> Array:
        """Times of the stages in parts of the step, shape ``(s,)``."""
        return self.A.sum(axis=1)


FORWARD_EULER = Tableau("forward-euler", np.array([[0.0, 0.0], [1.0, 0.0]]), 1)
BACKWARD_EULER = Tableau("backward-euler", np.array([[1.0]]), 1)

TABLEAUX = {tableau.name: tableau for tableau in (FORWARD_EULER, BACKWARD_EULER)}
