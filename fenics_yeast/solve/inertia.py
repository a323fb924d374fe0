"""Negative modes of a mixed form, by the inertia of a factorisation.

By Sylvester's law of inertia, the factors L D Lᵀ of a symmetric matrix have as many negative
entries in D as it has negative eigenvalues.
"""

from typing import Any, Literal

from .. import _dolfinx as dx


class Inertia:
    """Factorises a compiled symmetric form again and again.

    A shear force is a multiplier in the mixed potential: each of its DOFs gives the matrix one
    negative eigenvalue. The further ones are negative modes: they reduce the potential.

    Parameters
    ----------
    form, space, comm
        The form, the space of its arguments, and the ranks that share it.
    solver
        The library that factorises: MUMPS pivots and works on any number of ranks.

    Attributes
    ----------
    matrix
        The form as it was assembled last.
    """

    def __init__(
        self, form: Any, space: Any, comm: Any, solver: Literal["petsc", "mumps"] = "mumps"
    ) -> None:
        self._form, self._multipliers = form, dx.size_of_second(space)
        self.matrix = dx.create_matrix(form)
        self.matrix.setOption(dx.PETSc.Mat.Option.SYMMETRIC, True)
        self.matrix.setOption(dx.PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self._solver = dx.PETSc.PC().create(comm)
        self._solver.setOperators(self.matrix)
        self._solver.setType("cholesky")
        self._solver.setFactorSolverType(solver)
        if solver == "mumps":
            self._solver.setFactorSetUpSolverType()
            factors = self._solver.getFactorMatrix()
            factors.setMumpsIcntl(13, 1)  # without ScaLAPACK, which counts no inertia
            factors.setMumpsIcntl(24, 1)  # detect null pivots

    def destroy(self) -> None:
        """Destroy the matrix and its factors."""
        self._solver.destroy()
        self.matrix.destroy()

    def negative_modes(self, conditions: Any) -> int:
        """Return the number of negative modes of the form, in its coefficients' present values."""
        dx.assemble_matrix(self.matrix, self._form, conditions)
        return self.count()

    def count(self) -> int:
        """Return the number of negative modes of the matrix as it is."""
        self._solver.setUp()
        negative, _, _ = self._solver.getFactorMatrix().getInertia()
        return int(negative) - self._multipliers
