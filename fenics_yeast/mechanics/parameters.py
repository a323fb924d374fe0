"""The values in the forms of a wall, by name: constants, and functions of the arc length."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import ufl

from .. import _dolfinx as dx
from .laws import Law, Parameter
from .quadrature import QuadraturePoints

GROWTH = "growth."  # before the names of a growth law's parameters


class Parameters:
    """Coefficients of compiled forms, whose values can be set again.

    Parameters
    ----------
    mesh, values
        The mesh of the wall; numbers, and functions of the arc length, by name.
    points
        The quadrature points of all local elements.
    """

    def __init__(
        self, mesh: Any, points: QuadraturePoints, values: Mapping[str, Parameter]
    ) -> None:
        self._mesh, self._points = mesh, points
        self._setters: dict[str, Callable[[Any, QuadraturePoints], None]] = {}
        self._coefficients = {name: self._create(name, value) for name, value in values.items()}

    def __getitem__(self, name: str) -> Any:
        """Return a coefficient in UFL."""
        return self._coefficients[name]

    def of(self, law: Law, kind: str, **weights: Any) -> Callable[[Any], Any]:
        """Return the function of a law, in UFL, with its parameters of a kind and its weights."""
        own = {name: self[f"{kind}.{name}"] for name in law.parameters if name not in weights}
        return lambda argument: law.function(argument, **own, **weights)

    def vary(self, names: Iterable[str]) -> tuple[list[Any], dict[Any, Any]]:
        """Return some coefficients as UFL variables, and a substitution that puts them in place."""
        variables, substitution = [], {}
        for name in names:
            coefficient = self[name]
            variable = ufl.variable(coefficient)
            variables.append(variable)
            if isinstance(coefficient, ufl.indexed.Indexed):  # a function of one component
                substitution[coefficient.ufl_operands[0]] = ufl.as_vector([variable])
            else:
                substitution[coefficient] = variable
        return variables, substitution

    def set(self, values: Mapping[str, Parameter], points: QuadraturePoints) -> None:
        """Set the values of another wall of the same structure, at its quadrature points."""
        for name, value in values.items():
            self._setters[name](value, points)

    def _create(self, name: str, value: Parameter) -> Any:
        if isinstance(value, tuple):
            raise TypeError("only parameters of a growth law can be weights")
        if not callable(value):
            constant = dx.fem.Constant(self._mesh, np.float64(value))
            self._setters[name] = lambda number, _: _assign(constant, number)
            return constant
        function, dofs = self._points.function(1)
        array = function.x.array

        def at_points(field: Callable[..., Any], points: QuadraturePoints) -> None:
            array[dofs] = field(points.S)

        self._setters[name] = at_points
        at_points(value, self._points)
        return function[0]


def _assign(constant: Any, number: float) -> None:
    constant.value = np.float64(number)


def values_of(law: Law | None, kind: str) -> dict[str, Parameter]:
    """Return the parameters of a law, if there is one, by their names in the forms."""
    return {} if law is None else {f"{kind}.{name}": x for name, x in law.parameters.items()}
