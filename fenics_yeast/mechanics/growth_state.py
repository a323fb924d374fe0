"""Growth strains of the growing elements: storage, rate and implicit update.

An implicit stage of a time step solves at every point

    ε^g = base + stage · rate(τ(ε - ε^g), ε, ε^g)

for `ε^g`. The update, its consistent derivative and the rate are compiled from one law in UFL.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from . import growth_laws as growth
from . import hyperelasticity as wall
from .growth_weights import WeightField

Array = NDArray[np.float64]

_CONVERGED = 1e-6  # change of growth strain, whose square the quadratic iteration leaves
_MOST_ITERATIONS = 60
_HALVING = 6  # period of halved steps


class GrowthState:
    """Growth strains at the quadrature points of the growing elements.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    elements
        Local growing elements, ghosts among them.
    degree
        Degree of the quadrature rule of the wall.
    eps
        Logarithmic strains at each through-thickness integration point, UFL vectors.
    material, growth_rate
        Material of the wall; growth rate.
    weights
        Weights in the growth rate.

    Attributes
    ----------
    eps_g, base
        Trial growth strains, and growth strains without the implicit part of the stage:
        quadrature functions of ``2 len(eps)`` numbers.
    stage
        Length in min of the implicit part of the stage, `a Δt`.
    span
        Times in min of the interval that the weights are set for.
    """

    def __init__(
        self,
        mesh: Any,
        elements: NDArray[np.int32],
        degree: int,
        eps: Sequence[Any],
        material: wall.Material,
        growth_rate: growth.GrowthRate,
        weights: Sequence[WeightField] = (),
    ) -> None:
        space = dx.quadrature_space(mesh, 2 * len(eps), degree)
        self.eps_g, self.base = dx.fem.Function(space), dx.fem.Function(space)
        self._trial, self._base = self.eps_g.x.array, self.base.x.array
        self.stage = dx.fem.Constant(mesh, np.float64(0))
        self.span = (0.0, 0.0)
        self._mesh, self._elements, self._weights = mesh, elements, weights
        self._dofs = dx.dof_array(space)[elements]

        self.points: list[growth.WallPoint] = []
        self.rates: list[Any] = []
        self.by_strain: list[Any] = []  # dε^g/dε of the update, 2 by 2
        self.by_stage: list[Any] = []  # its derivative by the stage's length
        steps = []
        for j, strain in enumerate(eps):
            eps_j = ufl.variable(strain)
            eps_g = ufl.variable(self.strain(j))
            base = ufl.as_vector([self.base[2 * j], self.base[2 * j + 1]])
            tau, eps_3 = material.stress(eps_j, eps_g), material.thickness_strain(eps_j, eps_g)
            point = growth.WallPoint(tau, eps_j, eps_g, eps_3)
            rate = growth_rate(point)
            residual = eps_g - base - self.stage * rate
            inverse = ufl.inv(ufl.diff(residual, eps_g))
            self.points.append(point)
            self.rates.append(rate)
            self.by_strain.append(-inverse * ufl.diff(residual, eps_j))
            self.by_stage.append(inverse * rate)
            steps.append(eps_g - inverse * residual)
        points = dx.quadrature_points(degree)
        self._newton_step = dx.compile_expression(_flatten(steps), points)
        self._rate = dx.compile_expression(_flatten(self.rates), points)

    def strain(self, j: int) -> Any:
        """Return the trial growth strains at integration point j, a UFL vector."""
        return ufl.as_vector([self.eps_g[2 * j], self.eps_g[2 * j + 1]])

    def get(self) -> Array:
        """Return a copy of the trial growth strains, shape ``(elements, 2 n points)``."""
        return self._trial[self._dofs]

    def set(self, values: Array) -> None:
        """Set the trial growth strains."""
        self._trial[self._dofs] = values

    def get_base(self) -> Array:
        """Return a copy of the growth strains without the implicit part of the stage."""
        return self._base[self._dofs]

    def set_base(self, values: Array) -> None:
        """Set the growth strains without the implicit part of the stage."""
        self._base[self._dofs] = values

    def set_interval(self, start: float, end: float) -> None:
        """Set the weights of an interval in min or, at equal times, of just after."""
        self.span = (start, end)
        for weight in self._weights:
            weight.set_interval(start, end)

    def rate(self) -> Array:
        """Return the growth rate in the trial state in 1/min, shaped like `get`."""
        self.update_weights()
        return self._evaluate(self._rate)

    def update(self) -> bool:
        """Solve the stage equation at every point; return False if that fails."""
        self.update_weights()
        current = start = self.get()
        for iteration in range(_MOST_ITERATIONS):
            following = self._evaluate(self._newton_step)
            change = np.abs(following - current).max(initial=0.0)
            if change < _CONVERGED:
                self.set(following)
                return True
            if not np.isfinite(change):
                break
            if iteration % _HALVING == _HALVING - 1:
                # At the threshold full steps can alternate between its two sides.
                following = (following + current) / 2
            self.set(following)
            current = following
        self.set(start)  # a smaller change of strain may converge from it
        return False

    def update_weights(self) -> None:
        """Update weights that follow the tip to the trial state."""
        for weight in self._weights:
            weight.update()

    def _evaluate(self, expression: Any) -> Array:
        return dx.evaluate(expression, self._mesh, self._elements)


def _flatten(vectors: Sequence[Any]) -> Any:
    return ufl.as_vector([vector[i] for vector in vectors for i in range(2)])
