"""Fields at quadrature points, evaluated from a compiled expression."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx


class PointField:
    """A quadrature function with the values of an expression; zero on all other elements.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    elements
        Local elements on which it has values, ghosts among them.
    degree
        Degree of the quadrature rule.
    values
        Scalars in UFL.
    """

    def __init__(
        self, mesh: Any, elements: NDArray[np.int32], degree: int, values: list[Any]
    ) -> None:
        space = dx.quadrature_space(mesh, len(values), degree)
        self.function = dx.fem.Function(space)
        self._values = self.function.x.array
        self._dofs = dx.dof_array(space)[elements]
        self._mesh, self._elements = mesh, elements
        points = dx.quadrature_points(degree)
        self._expression = dx.compile_expression(ufl.as_vector(values), points)

    def update(self) -> None:
        """Evaluate the expression in the trial state."""
        self._values[self._dofs] = dx.evaluate(self._expression, self._mesh, self._elements)
