"""Derivatives of a run by its parameters: forward sensitivities of the discrete solution.

Each stage of an accepted step is one equation for the state and one for the growth strains,

    R(w, ε^g, θ) = 0,    ε^g = base + stage · rate(w, ε^g, θ)

whose derivative by a parameter θ is linear. Its matrix is the consistent tangent in the solution;
the derivative of `base` comes from the stages before. Steps, mesh and integration points are held:
so this is the derivative of what the run computes, to the last digits.

References
----------
P. Michaleris, D. A. Tortorelli, C. A. Vidal, Tangent operators and design sensitivity formulations
for transient non-linear coupled problems with applications to elastoplasticity, Int. J. Numer.
Methods Eng. 37 (1994) 2471-2499.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import Coefficient, Shell, ShellState
from .residual import Equations, use_lu
from .time_stepper import StepperState


@dataclass(frozen=True)
class Direction:
    """What a parameter changes in the equations of a wall, per unit of the parameter.

    Attributes
    ----------
    coefficients
        Changes of the coefficients of the forms: numbers, or functions of the arc length.
    pressure
        Change of the pressure as a function of time in min.
    force
        Change of the force of a load.
    """

    coefficients: Mapping[str, Coefficient]
    pressure: Callable[[float], float]
    force: float = 0.0


@dataclass(frozen=True)
class _Stage:
    """The solution of a stage, and its row of the Butcher tableau up to the diagonal.

    The row is empty for an equilibrium at given growth. `length` is that of the implicit part in
    min, `a Δt`; `time` is the stage's own.
    """

    time: float
    row: Array
    pressure: float
    length: float
    wall: ShellState
    base: Array | None


class ForwardSensitivities:
    """Derivatives of a shell's accepted state by parameters; must be destroyed.

    It follows the steps of a `TimeStepper`. Rejected steps cost nothing.

    Parameters
    ----------
    shell
        The wall in its initial state, which no parameter changes.
    directions
        What each parameter changes.

    Attributes
    ----------
    w
        Derivatives of the accepted state, shape ``(parameters, DOFs)``, ghosts among them; not
        numbers if no stage led to it.
    """

    def __init__(self, shell: Shell, directions: Sequence[Direction]) -> None:
        self._shell, self._directions = shell, tuple(directions)
        names = sorted({name for each in directions for name in each.coefficients})
        self._forms = forms = shell.parameter_derivatives(names)
        S = shell.points.S
        self._changes = np.zeros((len(directions), len(names), *S.shape))
        for direction, changes in zip(directions, self._changes, strict=True):
            for name, value in direction.coefficients.items():
                changes[names.index(name)] = value(S) if callable(value) else value
        # By point, parameter and coefficient.
        self._changes = np.moveaxis(self._changes, (2, 3), (0, 1)).copy()
        points = int(forms.grows.sum()) * S.shape[1]
        growing = self._changes[forms.grows]
        self._growing_changes = growing.reshape(points, *growing.shape[2:])
        area = shell.points.weights * shell.discretisation.curve.radius(S)
        self._area = (area * shell.points.owned[:, None])[:, :, None, None]
        self._dofs = dx.dof_array(shell.space)
        self._equations = Equations(shell)
        self._x = self._equations.matrix.createVecRight()
        self._f = self._equations.matrix.createVecLeft()
        self._solver = dx.PETSc.KSP().create(shell.comm)
        self._solver.setOperators(self._equations.matrix)
        use_lu(self._solver, shell.membrane_stiffness)
        by_pressure = shell.forms.pressure_force
        self._by_pressure, self._sign = by_pressure, 1.0
        if by_pressure is None:
            self._by_pressure, self._sign = shell.forms.volume_gradient, -1.0
        self._stages: list[_Stage] = []
        self._lost = False
        self.w = np.zeros((len(directions), len(shell.w.x.array)))
        self._eps_g = np.zeros((points, len(directions), 2 * len(shell.eps)))

    def destroy(self) -> None:
        """Destroy matrix, vectors and solver."""
        for item in (self._solver, self._equations, self._x, self._f):
            item.destroy()

    # --- steps ----------------------------------------------------------------------------

    def solved(self, time: float, row: Array) -> None:
        """Note the shell's trial state as the solution of a stage at a time in min.

        `row` is that of the tableau up to the diagonal; empty for an equilibrium at given growth.
        """
        shell, growth = self._shell, self._shell.growth
        base, length = (None, 0.0) if growth is None else (growth.get_base(), growth.stage.value)
        pressure = float(shell.pressure.value)
        self._stages = [stage for stage in self._stages if len(stage.row) < len(row)]
        self._stages.append(_Stage(time, row, pressure, float(length), shell.state(), base))

    def rejected(self) -> None:
        """Drop the stages of the trial step."""
        self._stages = []

    def accepted(self, start: StepperState, duration: float) -> None:
        """Differentiate the trial step, of a duration in min, from the state at its start."""
        stages, self._stages = self._stages, []
        if not stages or self._lost:  # growth without stages is not known, nor what follows it
            self._lost = self._shell.growth is not None
            self.w = np.full_like(self.w, np.nan)
            return
        shell, changes = self._shell, []  # of the growth strains by each stage's rate in the step
        end, eps_g = shell.state(), self._eps_g
        if len(stages[0].row) > 1:  # the first stage is the accepted state
            shell.restore(ShellState(start.w, start.eps_g))
            changes.append(self._explicit(duration, eps_g) if stages[0].row[0] else 0 * eps_g)
        for stage in stages:
            self._restore(stage)
            parts = [a * change for a, change in zip(stage.row[:-1], changes, strict=True)]
            base = sum(parts, self._eps_g)
            eps_g = self._solve(stage, base)
            if stage.length:
                changes.append((eps_g - base) / stage.row[-1])
            elif stage is not stages[-1]:
                changes.append(self._explicit(duration, eps_g))
        self._eps_g = eps_g
        if shell.growth is not None:
            shell.growth.stage.value = np.float64(0)
        shell.restore(end)

    def _restore(self, stage: _Stage) -> None:
        """Return the shell to the solution of a stage."""
        shell, growth = self._shell, self._shell.growth
        shell.restore(stage.wall)
        shell.pressure.value = np.float64(stage.pressure)
        if growth is not None and stage.base is not None:
            growth.stage.value = np.float64(stage.length)
            growth.set_base(stage.base)

    # --- one stage ------------------------------------------------------------------------

    def _solve(self, stage: _Stage, base: Array) -> Array:
        """Solve for the derivatives of the state in a stage; return those of the growth strains."""
        forms, tangents, length = self._forms, self._shell.forms, stage.length
        by_dofs = forms.by_state()
        N = self._changes @ forms.by_coefficient()
        if self._shell.growth is None:
            self._solve_equilibrium(tangents.tangent, by_dofs, N, stage.time)
            return base
        growth = forms.by_growth()
        inverse = _inverse(np.eye(2) - length * growth.rate_by_growth)
        rates = self._growing_changes @ growth.rate_by_coefficient
        eps_g = _times(inverse, base + length * rates)
        by_growth = growth.resultants_by_growth.swapaxes(1, 2)
        grown = N[forms.grows, ..., : forms.strains]
        N[forms.grows, ..., : forms.strains] = grown + (eps_g @ by_growth).reshape(grown.shape)
        if not length:
            self._solve_equilibrium(tangents.tangent, by_dofs, N, stage.time)
            return eps_g
        by_strain = length * _times(inverse, growth.rate_by_strain)
        tangents.set_response((by_strain @ by_growth).swapaxes(1, 2))
        self._solve_equilibrium(tangents.consistent_tangent, by_dofs, N, stage.time)
        return eps_g + self._strains(by_dofs) @ by_strain

    def _explicit(self, duration: float, eps_g: Array) -> Array:
        """Return the derivatives of the growth by the present rate, over a duration in min."""
        growth, strains = self._forms.by_growth(), self._strains(self._forms.by_state())
        rates = self._growing_changes @ growth.rate_by_coefficient
        rates += strains @ growth.rate_by_strain + _times(growth.rate_by_growth, eps_g)
        return duration * rates

    def _strains(self, by_dofs: Array) -> Array:
        """Return the derivatives of the strains where the wall grows, point by point."""
        forms = self._forms
        here = by_dofs[forms.grows, :, : forms.strains]
        elements, points, count, dofs = here.shape
        moved = self.w.T[self._dofs[forms.grows]]
        strains = here.reshape(elements, points * count, dofs) @ moved
        return strains.reshape(elements * points, count, len(self.w)).swapaxes(1, 2)

    def _solve_equilibrium(self, tangent: Any, by_dofs: Array, N: Array, time: float) -> None:
        """Solve for the derivatives of the DOFs, from those of resultants and pressure."""
        elements, dofs = self._dofs.shape  # every rank has some
        weighted = (by_dofs * self._area).reshape(elements, -1, dofs)
        forces = N.swapaxes(1, 2).reshape(elements, N.shape[2], -1) @ weighted
        equations, places = self._equations, self._dofs.ravel()
        dx.assemble_matrix(equations.matrix, tangent, self._shell.conditions)
        self._solver.setOperators(equations.matrix)
        for k, direction in enumerate(self._directions):
            force = np.bincount(places, forces[:, k].ravel(), minlength=self.w.shape[1])
            equations.gather(force.astype(float, copy=False), self._f.array)
            if change := direction.pressure(time):
                equations.assemble(self._by_pressure, self._x.array)
                self._f.axpy(change * self._sign, self._x)
            if direction.force and self._shell.force is not None:
                self._shell.force.direction(self._x.array)
                self._f.axpy(-direction.force / (2 * np.pi), self._x)
            self._solver.solve(self._f, self._x)
            self.w[k] = -equations.with_ghosts(self._x.array_r)


def _times(matrices: Array, vectors: Array) -> Array:
    """Multiply vectors, shape ``(points, k, 2 n)``, with matrices, ``(points, n, 2, 2)``."""
    m, v = matrices[:, None], vectors.reshape(*vectors.shape[:2], matrices.shape[1], 2)
    product = np.empty_like(v)
    for i in range(2):
        product[..., i] = m[..., i, 0] * v[..., 0] + m[..., i, 1] * v[..., 1]
    return product.reshape(vectors.shape)


def _inverse(matrices: Array) -> Array:
    """Return the inverses of 2 by 2 matrices."""
    a, b = matrices[..., 0, 0], matrices[..., 0, 1]
    c, d = matrices[..., 1, 0], matrices[..., 1, 1]
    inverse = np.empty_like(matrices)
    inverse[..., 0, 0], inverse[..., 0, 1] = d, -b
    inverse[..., 1, 0], inverse[..., 1, 1] = -c, a
    inverse *= 1 / (a * d - b * c)[..., None, None]
    return inverse
