"""Numbers at the quadrature points of some cells, taken from a compiled expression."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx


class PointField:
    """A quadrature function whose values an expression gives; zero on all other cells.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    cells
        Local cells on which it has values, ghosts among them.
    degree
        Degree of the quadrature rule.
    values
        Scalars in UFL.
    """

    def __init__(self, mesh: Any, cells: NDArray[np.int32], degree: int, values: list[Any]) -> None:
        space = dx.quadrature_space(mesh, len(values), degree)
        self.function = dx.fem.Function(space)
        self._values = self.function.x.array
        self._dofs = dx.dof_array(space)[cells]
        self._mesh, self._cells = mesh, cells
        points = dx.quadrature_points(degree)
        self._expression = dx.compile_expression(ufl.as_vector(values), points)

    def update(self) -> None:
        """Bring the values up to what the expression now gives."""
        self._values[self._dofs] = dx.evaluate(self._expression, self._mesh, self._cells)
