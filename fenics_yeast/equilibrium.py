"""Equilibrium of a shell by PETSc's SNES, at given growth or with growth implicit in its stage."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _dolfinx as dx
from .shell import Shell

Array = NDArray[np.float64]

REASONS = {
    -1: "the residual is not defined at the start",
    -2: "too many evaluations of the residual",
    -3: "the linear solver failed",
    -4: "the residual is not a number",
    -5: "no convergence within the most iterations allowed",
    -6: "the line search found no smaller residual",
    -7: "the inner solve failed",
    -8: "a local minimum of the residual that is no equilibrium",
    -9: "the residual grew without bound",
    -10: "the Jacobian is not defined",
    -11: "the trust region shrank to nothing",
}

_MOST_ITERATIONS = 40


class EquilibriumError(RuntimeError):
    """No equilibrium was found; the shell is as it was before the attempt.

    Attributes
    ----------
    iterations
        Newton iterations spent.
    """

    def __init__(self, message: str, iterations: int) -> None:
        super().__init__(message)
        self.iterations = iterations


class Equilibrium:
    """Newton's method with line search for one shell; a context manager.

    Parameters
    ----------
    shell
        The wall; the solver moves its trial state.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    """

    def __init__(self, shell: Shell, tolerance: float) -> None:
        self._shell = shell
        self._matrix = dx.create_matrix(shell.tangent)
        self._x = self._matrix.createVecRight()
        self._f = self._matrix.createVecLeft()
        self._assembled = dx.fem.Function(shell.space)
        self._b, self._w = self._assembled.x.array, shell.w.x.array
        owned = shell.space.dofmap.index_map.size_local
        self._held = shell.constrained[shell.constrained < owned]
        self._owned = owned
        self.snes = snes = dx.PETSc.SNES().create(shell.comm)
        snes.setOptionsPrefix("equilibrium_")
        snes.setType("newtonls")
        snes.setFunction(self._residual, self._f)
        snes.setJacobian(self._jacobian, self._matrix)
        snes.setTolerances(rtol=0.0, atol=tolerance, stol=0.0, max_it=_MOST_ITERATIONS)
        ksp = snes.getKSP()
        ksp.setType("preonly")
        ksp.getPC().setType("lu")
        serial = shell.comm.size == 1
        ksp.getPC().setFactorSolverType("petsc" if serial else "mumps")
        if serial:
            ksp.getPC().setFactorOrdering("rcm")  # a banded matrix
            # Without pivoting, no shear (κ = inf) or no bending (one fibre) is a zero pivot.
            ksp.getPC().setFactorShift(dx.PETSc.Mat.FactorShiftType.NONZERO, 1e-10)
        snes.setFromOptions()

    def __enter__(self) -> Equilibrium:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for item in (self.snes, self._matrix, self._x, self._f):
            item.destroy()

    def solve(self) -> int:
        """Move the trial state into equilibrium under the shell's pressure, growth and stage.

        Returns
        -------
        int
            Newton iterations.

        Raises
        ------
        EquilibriumError
            With SNES' reason in words; displacement and growth are then as before.
        """
        shell, snes = self._shell, self.snes
        w = self._w.copy()
        eps_g = None if shell.growth is None else shell.growth.get()
        self._x.array[:] = w[: self._owned]
        snes.solve(None, self._x)
        reason, iterations = snes.getConvergedReason(), snes.getIterationNumber()
        if reason > 0:
            if not np.array_equal(self._w[: self._owned], self._x.array_r):
                self._load(self._x)
            return iterations
        self._w[:] = w
        if shell.growth is not None and eps_g is not None:
            shell.growth.set(eps_g)
        words = REASONS.get(reason, f"SNES stopped for its reason {reason}")
        raise EquilibriumError(words, iterations)

    def compliance(self) -> float:
        """Change of volume by pressure `dV/dp` of the trial state at given growth, µm³/MPa.

        It grows without bound towards a limit point and is negative beyond it.
        """
        shell = self._shell
        dx.assemble_matrix(self._matrix, shell.tangent, shell.conditions)
        self.snes.getKSP().setOperators(self._matrix)
        self._assemble(shell.volume_gradient, self._f)
        return 2 * np.pi * self._volume_response()

    def volume_change(self, eps_g: Array) -> float:
        """Change of volume in µm³ that a change of the growth strains would bring.

        To first order, with the tangent of the last iteration: after an implicit stage the
        change is damped where growth is stiff, as an estimate of its error should be.

        Parameters
        ----------
        eps_g
            Change of the growth strains, in the layout of `GrowthState.get`.
        """
        growth = self._shell.growth
        if growth is None:
            return 0.0
        accepted = growth.get()
        growth.set(accepted + eps_g)
        self._assemble(self._shell.residual, self._f)
        growth.set(accepted)
        return -2 * np.pi * self._volume_response()

    def _volume_response(self) -> float:
        """Volume per 2π that the solution for the force in `_f` displaces."""
        force = self._f.copy()
        self.snes.getKSP().solve(force, self._x)
        self._assemble(self._shell.volume_gradient, force)
        response = force.dot(self._x)
        force.destroy()
        return float(response)

    def _assemble(self, form: Any, vector: Any) -> None:
        """Assemble a linear form; it is zero where the motion is held."""
        self._b[:] = 0
        dx.fem.assemble_vector(self._b, form)
        dx.accumulate(self._assembled)
        values = vector.array
        values[:] = self._b[: self._owned]
        values[self._held] = 0

    def _load(self, x: Any) -> bool:
        """Make SNES' iterate the trial state; False if the growth update failed there."""
        self._w[: self._owned] = x.array_r
        self._shell.w.x.scatter_forward()
        growth = self._shell.growth
        return growth is None or growth.stage.value == 0 or growth.update()

    def _residual(self, snes: Any, x: Any, f: Any) -> None:
        defined = self._load(x)
        self._assemble(self._shell.residual, f)
        if not defined:
            f.array[:] = np.nan

    def _jacobian(self, snes: Any, x: Any, J: Any, P: Any) -> None:
        shell = self._shell
        if shell.growth is None or shell.growth.stage.value == 0:
            form = shell.tangent
        else:
            shell.growth.differentiate()
            form = shell.consistent_tangent
        dx.assemble_matrix(P, form, shell.conditions)
