"""Growth strains of the growing elements: storage, rate and implicit update.

An implicit stage of a time step solves at every point

    ε^g = base + stage · rate(τ(ε - ε^g), ε, ε^g)

for `ε^g`. The update, its consistent derivative and the rate are compiled from one law in UFL.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl

from .. import _dolfinx as dx
from ..geometry import Array
from .growth_laws import GrowthRate, WallPoint
from .growth_weights import WeightField, Weights
from .hyperelasticity import Material
from .quadrature import QuadraturePoints

_CONVERGED = 1e-6  # change of growth strain; the error left by Newton's method is its square
_MOST_ITERATIONS = 60
_HALVING = 6  # every sixth step is halved


class GrowthState:
    """Growth strains at the quadrature points of the growing elements.

    Parameters
    ----------
    points
        Quadrature points of the growing elements.
    eps
        Logarithmic strains at each through-thickness integration point, UFL vectors.
    material, growth_rate, weights
        Material of the wall; growth rate, and the weights in it.

    Attributes
    ----------
    stage
        Length in min of the implicit part of the stage, `a Δt`, a constant of the forms.
    span
        Times in min of the interval that the weights are set for.
    wall_points, rates, by_strain, by_stage
        At each through-thickness integration point in UFL: state of the wall, growth rate, and
        derivatives of the implicit update, `dε^g/dε` and `dε^g/d(a Δt)`.
    """

    def __init__(
        self,
        points: QuadraturePoints,
        eps: Sequence[Any],
        material: Material,
        growth_rate: GrowthRate,
        weights: Sequence[WeightField] = (),
    ) -> None:
        self._eps_g, self._dofs = points.function(2 * len(eps))
        base, _ = points.function(2 * len(eps))
        self._trial, self._base = self._eps_g.x.array, base.x.array
        self.stage = dx.fem.Constant(points.mesh, np.float64(0))
        self.span = (0.0, 0.0)
        self._weights = weights
        self.wall_points: list[WallPoint] = []
        self.rates: list[Any] = []
        self.by_strain: list[Any] = []
        self.by_stage: list[Any] = []
        steps: list[Any] = []
        for j, strain in enumerate(eps):
            eps_j = ufl.variable(strain)
            eps_g = ufl.variable(self.strain(j))
            tau, eps_3 = material.stress(eps_j, eps_g), material.thickness_strain(eps_j, eps_g)
            point = WallPoint(tau, eps_j, eps_g, eps_3)
            rate = growth_rate(point)
            residual = eps_g - ufl.as_vector([base[2 * j], base[2 * j + 1]]) - self.stage * rate
            inverse = ufl.inv(ufl.diff(residual, eps_g))
            self.wall_points.append(point)
            self.rates.append(rate)
            self.by_strain.append(-inverse * ufl.diff(residual, eps_j))
            self.by_stage.append(inverse * rate)
            steps.append(eps_g - inverse * residual)
        self._newton_step = points.compile([step[i] for step in steps for i in range(2)])
        self._rate = points.compile([rate[i] for rate in self.rates for i in range(2)])

    def strain(self, j: int) -> Any:
        """Return the trial growth strains at integration point j, a UFL vector."""
        return ufl.as_vector([self._eps_g[2 * j], self._eps_g[2 * j + 1]])

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
        return self._rate()

    def update(self) -> bool:
        """Solve the stage equation at every point; return False if that fails."""
        self.update_weights()
        current = start = self.get()
        for iteration in range(_MOST_ITERATIONS):
            following = self._newton_step()
            change = np.maximum.reduce(np.abs(following - current), axis=None, initial=0.0)
            if change < _CONVERGED:
                self.set(following)
                return True
            if not np.isfinite(change):
                break
            if iteration % _HALVING == _HALVING - 1:
                # Full steps can alternate between the two sides of the threshold.
                following = (following + current) / 2
            self.set(following)
            current = following
        self.set(start)  # from which a smaller change of strain may converge
        return False

    def reset(self, points: QuadraturePoints, weights: Sequence[Weights]) -> None:
        """Reset to no growth, in another wall of the same structure."""
        self._trial[:] = 0
        self._base[:] = 0
        self.stage.value = np.float64(0)
        self.span = (0.0, 0.0)
        for field, values in zip(self._weights, weights, strict=True):
            field.set(points, values)

    def update_weights(self) -> None:
        """Update weights that follow the tip to the trial state."""
        for weight in self._weights:
            weight.update()
