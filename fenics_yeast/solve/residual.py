"""The discrete equations of a shell in PETSc: residual, tangent and their linear solver."""

from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import GrowthState, Shell

_PREFIX = "wall_lu_"  # of the PETSc options of all linear solvers
_LU = {
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "petsc",
    "pc_factor_mat_ordering_type": "rcm",  # a banded matrix
    # Without pivoting, a wall without bending stiffness (one fibre) leads to a zero pivot.
    "pc_factor_shift_type": "nonzero",
}
# What is added to a zero pivot, and which pivots count as zero, in parts of the membrane stiffness;
# PETSc relates the latter to other entries unless these are small.
_SHIFT, _ZERO, _LARGEST_ZERO = 1e-11, 2e-15, 2.2e-14


class Equations:
    """Residual and tangent of a shell as functions of its DOFs.

    If the stage of the growth state has a length, growth follows the strain: the residual solves
    for it at every point, and the tangent is the consistent one.

    Attributes
    ----------
    matrix
        The tangent of the last call.
    owned
        Number of DOFs that this rank owns.
    """

    def __init__(self, shell: Shell) -> None:
        self.shell = shell
        self.matrix = dx.create_matrix(shell.forms.tangent)
        self._assembled = dx.fem.Function(shell.space)
        self._b, self._w = self._assembled.x.array, shell.w.x.array
        self._shared = shell.comm.size > 1
        dofmap = shell.space.dofmap
        self.owned = dofmap.index_map.size_local * dofmap.index_map_bs
        self._constrained = shell.constrained[shell.constrained < self.owned]

    def destroy(self) -> None:
        """Destroy the matrix."""
        self.matrix.destroy()

    def _following(self) -> GrowthState | None:
        """Return the growth state if growth follows the strain in a stage."""
        growth = self.shell.growth
        return None if growth is None or growth.stage.value == 0 else growth

    def set_trial(self, values: Any) -> bool:
        """Set the trial state from the owned DOFs; return False if growth cannot follow."""
        self._w[: self.owned] = values
        if self._shared:
            self.shell.w.x.scatter_forward()
        growth = self._following()
        return growth is None or growth.update()

    def set_trial_if_changed(self, values: Any) -> None:
        """Set the trial state unless, on all ranks, it has these values."""
        equal = bool((self._w[: self.owned] == values).all())
        if self.shell.comm.size > 1:
            equal = self.shell.comm.allreduce(equal, op=dx.MPI.LAND)
        if not equal:
            self.set_trial(values)

    def with_ghosts(self, values: Any) -> Array:
        """Return owned values and those of other ranks, like `w`."""
        self._b[: self.owned] = values
        self._assembled.x.scatter_forward()
        return self._b.copy()

    def residual(self, values: Any, out: Any) -> None:
        """Compute the residual at values of the owned DOFs; NaN if growth cannot follow."""
        defined = self.set_trial(values)
        self.assemble(self.shell.forms.residual, out)
        if not defined:
            out[:] = np.nan

    def tangent(self) -> None:
        """Assemble the matrix in the trial state."""
        shell, growth, form = self.shell, self._following(), self.shell.forms.tangent
        if growth is not None:
            shell.forms.update()
            form = shell.forms.consistent_tangent
        dx.assemble_matrix(self.matrix, form, shell.conditions)

    def assemble(self, form: Any, out: Any) -> None:
        """Assemble a linear form for the owned DOFs; zero for constrained ones."""
        self._b[:] = 0
        dx.assemble_vector(self._b, form)
        self._to_owners(out)
        if form is self.shell.forms.residual and self.shell.force is not None:
            self.shell.force.add_to(out)
        out[self._constrained] = 0

    def gather(self, values: Array, out: Any) -> None:
        """Sum local values, ghosts among them, for the owned DOFs; zero for constrained ones."""
        self._b[:] = values
        self._to_owners(out)
        out[self._constrained] = 0

    def _to_owners(self, out: Any) -> None:
        if self._shared:
            dx.accumulate(self._assembled)
        out[:] = self._b[: self.owned]


def use_lu(solver: Any, stiffness: float) -> None:
    """Make a KSP a direct solver with PETSc's own LU; each of several ranks solves all of it.

    The matrices are small and banded: this is faster than sharing the work, and reproducible to
    the last digit. `stiffness` is the size of their entries in µN/µm.
    """
    solver.setType("preonly")
    solver.setOptionsPrefix(_PREFIX)
    options, own = dx.PETSc.Options(), ""
    if solver.getComm().getSize() > 1:
        options[_PREFIX + "pc_type"], own = "redundant", "redundant_"
    small = {
        "pc_factor_shift_amount": _SHIFT * stiffness,
        "pc_factor_zeropivot": min(_LARGEST_ZERO, _ZERO * stiffness),
    }
    for name, value in (_LU | small).items():
        options[_PREFIX + own + name] = value
    solver.setFromOptions()
