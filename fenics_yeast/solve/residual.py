"""The discrete equations of a shell in PETSc: residual, tangent and the linear solver for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..mechanics import GrowthState, Shell

_SHIFT = 1e-10
_SHARED = "shared_wall_"  # prefix of the options of solvers on several ranks
_LU_OF_EACH = {  # those of `use_lu` on one rank
    "redundant_pc_type": "lu",
    "redundant_pc_factor_mat_solver_type": "petsc",
    "redundant_pc_factor_mat_ordering_type": "rcm",
    "redundant_pc_factor_shift_type": "nonzero",
    "redundant_pc_factor_shift_amount": _SHIFT,
}


class Equations:
    """Residual and tangent of a shell as functions of a PETSc vector of its unknowns.

    Where the stage of the growth state has a length, growth follows the strain: the residual
    solves for it at every point, and the tangent is the consistent one.

    Attributes
    ----------
    matrix
        The tangent of the last call.
    owned
        Number of unknowns of this rank.
    """

    def __init__(self, shell: Shell) -> None:
        self.shell = shell
        self.matrix = dx.create_matrix(shell.forms.tangent)
        self._assembled = dx.fem.Function(shell.space)
        self._b, self._w = self._assembled.x.array, shell.w.x.array
        dofmap = shell.space.dofmap
        self.owned = dofmap.index_map.size_local * dofmap.index_map_bs
        self._held = shell.constrained[shell.constrained < self.owned]

    def destroy(self) -> None:
        """Free the matrix."""
        self.matrix.destroy()

    def _following(self) -> GrowthState | None:
        """The growth state if growth follows the strain in a stage."""
        growth = self.shell.growth
        return None if growth is None or growth.stage.value == 0 else growth

    def load(self, values: Any) -> bool:
        """Make values of the owned unknowns the trial state; False if growth cannot follow."""
        self._w[: self.owned] = values
        self.shell.w.x.scatter_forward()
        growth = self._following()
        return growth is None or growth.update()

    def set_trial_if_changed(self, values: Any) -> None:
        """Load values unless they are, on all ranks, those of the trial state already."""
        loaded = np.array_equal(self._w[: self.owned], values)
        if self.shell.comm.size > 1:
            loaded = self.shell.comm.allreduce(loaded, op=dx.MPI.LAND)
        if not loaded:
            self.load(values)

    def residual(self, values: Any, out: Any) -> None:
        """Residual at values of the owned unknowns; not a number where growth cannot follow."""
        defined = self.load(values)
        self.assemble(self.shell.forms.residual, out)
        if not defined:
            out[:] = np.nan

    def tangent(self) -> None:
        """Bring the matrix up to the trial state."""
        shell, growth, form = self.shell, self._following(), self.shell.forms.tangent
        if growth is not None:
            shell.forms.update()
            form = shell.forms.consistent_tangent
        dx.assemble_matrix(self.matrix, form, shell.conditions)

    def assemble(self, form: Any, out: Any) -> None:
        """Values of a linear form for the owned unknowns; zero where the motion is held."""
        self._b[:] = 0
        dx.fem.assemble_vector(self._b, form)
        dx.accumulate(self._assembled)
        out[:] = self._b[: self.owned]
        if form is self.shell.forms.residual and self.shell.force is not None:
            self.shell.force.add_to(out)
        out[self._held] = 0


def use_lu(solver: Any) -> None:
    """Make a KSP a direct solver by PETSc's own LU; of several ranks each solves the whole.

    The matrices are small and banded: that takes less time than to share the work, and gives the
    same digits again.
    """
    solver.setType("preonly")
    factors = solver.getPC()
    if solver.getComm().getSize() > 1:
        solver.setOptionsPrefix(_SHARED)
        options = dx.PETSc.Options()
        for name, value in _LU_OF_EACH.items():
            options[_SHARED + name] = value
        factors.setType("redundant")
        solver.setFromOptions()
        return
    factors.setType("lu")
    factors.setFactorSolverType("petsc")
    factors.setFactorOrdering("rcm")  # a banded matrix
    # Without pivoting, a wall without bending (one fibre) is a zero pivot.
    factors.setFactorShift(dx.PETSc.Mat.FactorShiftType.NONZERO, _SHIFT)
