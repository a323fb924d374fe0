"""Quadrature points of the wall's elements, and functions with values at them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Array, Intervals


@dataclass(frozen=True)
class QuadraturePoints:
    """The quadrature points of some local elements, ghosts among them, of an interval mesh.

    Attributes
    ----------
    mesh, elements, degree
        The mesh, whose elements point upward; indices of the elements; degree of the rule.
    """

    mesh: Any
    elements: NDArray[np.int32]
    degree: int

    @cached_property
    def ends(self) -> Array:
        """Arc length of the elements' lower and upper ends in µm, shape ``(elements, 2)``."""
        return self.mesh.geometry.x[dx.element_vertices(self.mesh)[self.elements], 0]

    @cached_property
    def S(self) -> Array:
        """Arc length of the points in µm, shape ``(elements, points)``."""
        start, end = self.ends[:, :1], self.ends[:, 1:]
        return start + (end - start) * dx.quadrature_points(self.degree).ravel()

    @cached_property
    def weights(self) -> Array:
        """Lengths in µm that the points stand for, shape ``(elements, points)``."""
        length = self.ends[:, 1:] - self.ends[:, :1]
        return length * dx.quadrature_weights(self.degree)

    @property
    def owned(self) -> NDArray[np.bool_]:
        """Which of the elements this rank owns."""
        return self.elements < self.mesh.topology.index_map(1).size_local

    def inside(self, parts: Intervals) -> NDArray[np.bool_]:
        """Return which of the elements lie inside parts of the meridian."""
        middle = self.S.mean(axis=1)
        inside = np.zeros(len(middle), dtype=bool)
        for part in parts:
            inside |= part.holds(middle)
        return inside

    def at(self, chosen: NDArray[np.bool_]) -> QuadraturePoints:
        """Return the points of some of the elements."""
        return replace(self, elements=self.elements[chosen])

    def function(self, size: int) -> tuple[Any, NDArray[np.int32]]:
        """Return a zero function of vectors and its DOFs, shape ``(elements, points size)``."""
        space = dx.quadrature_space(self.mesh, size, self.degree)
        return dx.fem.Function(space), dx.dof_array(space)[self.elements]

    def compile(self, values: Sequence[Any]) -> Callable[[], Array]:
        """Compile UFL scalars; return what evaluates them, shape ``(elements, points values)``."""
        return self.compile_vector(ufl.as_vector(list(values)))

    def compile_vector(self, vector: Any) -> Callable[[], Array]:
        """Compile a UFL vector, which may be linear in a test function; return what evaluates it.

        The shape is ``(elements, points values)``, with a test function times its DOFs.
        """
        expression = dx.compile_expression(vector, dx.quadrature_points(self.degree))
        return dx.evaluator(expression, self.mesh, self.elements)


class EvaluatedFunction:
    """A quadrature function with the values of UFL scalars; zero outside the given points."""

    def __init__(self, points: QuadraturePoints, values: Sequence[Any]) -> None:
        self.function, self._dofs = points.function(len(values))
        self._values, self._evaluate = self.function.x.array, points.compile(values)

    def update(self) -> None:
        """Evaluate the scalars in the trial state."""
        self.set(self._evaluate())

    def set(self, values: Array) -> None:
        """Set the values that the scalars have, known from elsewhere."""
        self._values[self._dofs] = values.reshape(self._dofs.shape)
