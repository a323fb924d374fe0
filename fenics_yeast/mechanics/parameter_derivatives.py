"""Derivatives of a wall's equations by strain, growth and parameters, at the quadrature points.

They come by UFL from the laws of the residual, and are evaluated for all parameters at once: what
remains for each parameter is products of small arrays.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from operator import add
from typing import Any, NamedTuple

import numpy as np
import ufl

from .. import _dolfinx as dx
from ..geometry import Array
from .deformation import Deformation, resultants
from .growth_state import GrowthState
from .parameters import GROWTH, Parameters
from .quadrature import QuadraturePoints
from .reference import Reference
from .section import Section


class GrowthDerivatives(NamedTuple):
    """Derivatives at the points of the growing elements, in 1/min and µN/µm.

    For n through-thickness integration points; a last axis of ``2 n`` has two components for each.

    Attributes
    ----------
    rate_by_growth, rate_by_strain, rate_by_coefficient
        Of the growth rate, shapes ``(points, n, 2, 2)``, ``(points, strains, 2 n)`` and
        ``(points, coefficients, 2 n)``.
    resultants_by_growth
        Of the stress resultants, shape ``(points, strains, 2 n)``.
    """

    rate_by_growth: Array
    rate_by_strain: Array
    rate_by_coefficient: Array
    resultants_by_growth: Array


class ParameterDerivatives:
    """Derivatives of a wall's equations in its trial state, compiled once.

    Strains are `(E1m, E2m, E1b, E2b)`, or `(E1m, E2m)` of a membrane. Of a shell, the generalised
    strains have the shear force Q as a fifth one, to which the shear strain is conjugate.

    Parameters
    ----------
    reference, section, w, deformation, growth, parameters
        Parts of the shell.
    names
        Coefficients of its forms by which to differentiate, by their names in `Parameters`.

    Attributes
    ----------
    strains, generalised
        Numbers of strains and of generalised strains.
    grows
        Which of the local elements grow.
    """

    def __init__(
        self,
        reference: Reference,
        section: Section,
        w: Any,
        deformation: Deformation,
        growth: GrowthState | None,
        parameters: Parameters,
        names: Sequence[str],
    ) -> None:
        self._section, self._deformation = section, deformation
        self._coefficients, self._substitution = parameters.vary(names)
        strains = [*deformation.strain]
        self.strains = len(strains)
        strains += [] if deformation.Q is None else [deformation.Q]
        self.generalised = len(strains)
        argument = ufl.TestFunction(dx.argument_space(w.function_space))
        by_state = ufl.derivative(ufl.as_vector(strains), w, argument)
        self._by_state = reference.points.compile_vector(by_state)
        self.grows = np.zeros(len(reference.points.elements), dtype=bool)
        self._by_growth = None
        parts = {False: resultants(section, deformation, [])}
        if growth is not None:
            self.grows[reference.growing_points.elements] = True
            eps_g = [ufl.variable(growth.strain(j)) for j in range(len(deformation.eps))]
            parts[True] = resultants(section, deformation, eps_g)
            at_points = self._growth_derivatives(growth, parts[True], eps_g)
            self._by_growth = _compile(reference.growing_points, at_points)
        # Parameters of growth have no part in the stress at given strains.
        self._stressing = [i for i, name in enumerate(names) if not name.startswith(GROWTH)]
        self._by_coefficient = []
        for grows, N in parts.items() if self._stressing else ():
            points = reference.points.at(self.grows == grows)
            values = self._resultant_derivatives(reduce(add, N))
            self._by_coefficient.append((self.grows == grows, _compile(points, values)))
        self._shape = len(self.grows), reference.points.S.shape[1]

    def by_state(self) -> Array:
        """Return the derivative of the generalised strains by the DOFs of each element.

        The shape is ``(elements, points, generalised strains, DOFs)``.
        """
        return self._by_state().reshape(*self._shape, self.generalised, -1)

    def by_coefficient(self) -> Array:
        """Return the derivative of the generalised resultants by the coefficients.

        The shape is ``(elements, points, coefficients, generalised strains)``.
        """
        values = np.zeros((*self._shape, len(self._coefficients), self.generalised))
        for chosen, evaluate in self._by_coefficient:
            found = evaluate().reshape(-1, self._shape[1], len(self._stressing), self.generalised)
            whole = np.zeros((len(found), *values.shape[1:]))
            whole[:, :, self._stressing] = found
            values[chosen] = whole
        return values

    def by_growth(self) -> GrowthDerivatives:
        """Return the derivatives of growth and by growth; the wall must grow."""
        assert self._by_growth is not None
        n, points = len(self._deformation.eps), int(self.grows.sum()) * self._shape[1]
        counts = self.strains, len(self._coefficients), self.strains
        ends = 4 * n + 2 * n * np.cumsum([0, *counts])
        values = self._by_growth().reshape(points, ends[-1])
        first, *others = np.split(values, ends[:-1], axis=1)
        tables = (x.reshape(points, m, 2 * n) for x, m in zip(others, counts, strict=True))
        return GrowthDerivatives(first.reshape(points, n, 2, 2), *tables)

    def _growth_derivatives(
        self, growth: GrowthState, parts: list[Any], eps_g: list[Any]
    ) -> list[Any]:
        """Return the entries of `GrowthDerivatives` in UFL."""
        wall = self._deformation
        rates, points = growth.rates, growth.wall_points
        by_growth = [ufl.diff(r, p.eps_g) for r, p in zip(rates, points, strict=True)]
        by_strain = [
            ufl.diff(r, p.eps) * ufl.diff(eps, wall.E)
            for r, p, eps in zip(rates, points, wall.eps, strict=True)
        ]
        varied = [ufl.replace(rate, self._substitution) for rate in rates]
        resultants = [ufl.diff(N, own) for N, own in zip(parts, eps_g, strict=True)]
        pair, strains = range(2), range(self.strains)
        return [
            *(matrix[i, j] for matrix in by_growth for i in pair for j in pair),
            *(matrix[i, s] for s in strains for matrix in by_strain for i in pair),
            *(ufl.diff(rate, c)[i] for c in self._coefficients for rate in varied for i in pair),
            *(matrix[s, i] for s in strains for matrix in resultants for i in pair),
        ]

    def _resultant_derivatives(self, N: Any) -> list[Any]:
        """Return the derivatives of the generalised resultants in UFL, by each coefficient."""
        varied = ufl.replace(N, self._substitution)
        compliance = ufl.replace(self._section.compliance, self._substitution)
        values: list[Any] = []
        for coefficient in (self._coefficients[i] for i in self._stressing):
            values += [*ufl.diff(varied, coefficient)]
            if self._deformation.Q is not None:
                values.append(-self._deformation.Q * ufl.diff(compliance, coefficient))
        return values


def _compile(points: QuadraturePoints, values: list[Any]) -> Callable[[], Array]:
    """Compile UFL scalars with their derivatives expanded.

    What is linear in a constant loses it by differentiation. It must not be in the expression then,
    because dolfinx would pack it.
    """
    return points.compile_vector(ufl.algorithms.expand_derivatives(ufl.as_vector(values)))
