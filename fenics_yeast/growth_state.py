"""Growth strains of the growing cells: their storage, their rate, and the implicit update.

An implicit stage of a time step asks at every point for the growth strain of

    ε^g = base + stage · rate(τ(ε - ε^g), ε, ε^g)

The update, its consistent derivative and the rate are compiled from one growth law in UFL.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from . import _dolfinx as dx
from . import growth, kinematics, wall

Array = NDArray[np.float64]

_STILL = 1e-6  # a change of the growth strain after which Newton's method leaves its square
_MOST_ITERATIONS = 60


class GrowthState:
    """Growth strains at the quadrature points of the growing cells.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    cells
        Local growing cells, ghosts among them; those of no other cell are touched.
    degree
        Degree of the quadrature rule of the wall.
    eps
        Total logarithmic strains at each thickness point, UFL vectors.
    energy, growth_rate
        Strain energy and rate of growth.

    Attributes
    ----------
    eps_g, base
        Trial growth strains and those without the implicit part of the stage, quadrature
        functions of ``2 len(eps)`` numbers.
    stage
        Length in min of the implicit part of the stage, `a Δt`.
    """

    def __init__(
        self,
        mesh: Any,
        cells: NDArray[np.int32],
        degree: int,
        eps: Sequence[Any],
        energy: wall.StrainEnergy,
        growth_rate: growth.GrowthRate,
    ) -> None:
        space = dx.quadrature_space(mesh, 2 * len(eps), degree)
        self.eps_g, self.base = dx.fem.Function(space), dx.fem.Function(space)
        self._trial, self._base = self.eps_g.x.array, self.base.x.array
        self.stage = dx.fem.Constant(mesh, np.float64(0))
        self._mesh, self._cells = mesh, cells
        self._dofs = dx.dof_array(space)[cells]

        self.points: list[growth.WallPoint] = []
        self.rates: list[Any] = []
        steps, by_strain, by_stage = [], [], []
        for j, strain in enumerate(eps):
            eps_j = ufl.variable(strain)
            eps_g = ufl.variable(self.strain(j))
            base = ufl.as_vector([self.base[2 * j], self.base[2 * j + 1]])
            tau = wall.kirchhoff_stress(energy, kinematics.elastic(eps_j, eps_g))
            point = growth.WallPoint(tau, eps_j, eps_g)
            rate = growth_rate(point)
            residual = eps_g - base - self.stage * rate
            inverse = ufl.inv(ufl.diff(residual, eps_g))
            self.points.append(point)
            self.rates.append(rate)
            steps.append(eps_g - inverse * residual)
            by_stage.append(inverse * rate)
            derivative = -inverse * ufl.diff(residual, eps_j)
            by_strain += [derivative[0, :], derivative[1, :]]
        points = dx.quadrature_points(degree)
        self._newton_step = dx.compile_expression(_flatten(steps), points)
        self._rate = dx.compile_expression(_flatten(self.rates), points)
        self._by_strain = dx.compile_expression(_flatten(by_strain), points)
        self._by_stage = dx.compile_expression(_flatten(by_stage), points)
        self._strain_sensitivity = dx.fem.Function(dx.quadrature_space(mesh, 4 * len(eps), degree))
        self._strain_dofs = dx.dof_array(self._strain_sensitivity.function_space)[cells]
        self._stage_sensitivity = dx.fem.Function(space)

    def strain(self, j: int) -> Any:
        """Trial growth strains at thickness point j, a UFL vector."""
        return ufl.as_vector([self.eps_g[2 * j], self.eps_g[2 * j + 1]])

    def get(self) -> Array:
        """Copy of the trial growth strains of the growing cells, ``(cells, points, 2 n)``."""
        return self._trial[self._dofs]

    def set(self, values: Array) -> None:
        """Set the trial growth strains of the growing cells."""
        self._trial[self._dofs] = values

    def set_base(self, values: Array) -> None:
        """Set the growth strains from which the implicit part of a stage starts."""
        self._base[self._dofs] = values

    def rate(self) -> Array:
        """Rate of the growth strains in the trial state, 1/min, in the layout of `get`."""
        return self._evaluate(self._rate)

    def update(self) -> bool:
        """Solve the stage equation at every point for the trial strains; False if it fails."""
        current = self.get()
        for _ in range(_MOST_ITERATIONS):
            following = self._evaluate(self._newton_step)
            change = np.abs(following - current).max(initial=0.0)
            self.set(following)
            if change < _STILL:
                return True
            if not np.isfinite(change):
                break
            current = following
        return False

    def followed(self, j: int, d_eps: Any) -> Any:
        """Change of the growth strains at thickness point j for a change of strain, in UFL."""
        a = [self._strain_sensitivity[4 * j + i] for i in range(4)]
        return ufl.as_vector([a[0] * d_eps[0] + a[1] * d_eps[1], a[2] * d_eps[0] + a[3] * d_eps[1]])

    def lengthened(self, j: int) -> Any:
        """Change of the growth strains at thickness point j with the stage's length, in UFL."""
        return ufl.as_vector([self._stage_sensitivity[2 * j + i] for i in range(2)])

    def differentiate(self) -> None:
        """Bring `followed`, the derivative of the update by the strain, up to the trial state."""
        values = self._evaluate(self._by_strain)
        self._strain_sensitivity.x.array[self._strain_dofs] = values

    def differentiate_by_stage(self) -> None:
        """Bring `lengthened`, the derivative of the update by the stage, up to the trial state."""
        self._stage_sensitivity.x.array[self._dofs] = self._evaluate(self._by_stage)

    def _evaluate(self, expression: Any) -> Array:
        return dx.evaluate(expression, self._mesh, self._cells)


def _flatten(vectors: Sequence[Any]) -> Any:
    return ufl.as_vector([vector[i] for vector in vectors for i in range(2)])
