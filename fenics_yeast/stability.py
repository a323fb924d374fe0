"""Stability of an equilibrium: the inertia of the tangent at given growth and pressure."""

from __future__ import annotations

from . import _dolfinx as dx
from .shell import Shell

_SAME = 2e-3  # change of the volume up to which a count is taken over


class Stability:
    """Counts the directions in which the potential of a shell falls; a context manager.

    The shear force is a multiplier in the mixed potential: each of its unknowns gives the tangent
    one negative eigenvalue. A state is stable if there are no more. Only axisymmetric
    perturbations are seen.
    """

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        self._falling, self._place = 0, (0.0, 0.0)
        self._matrix = dx.create_matrix(shell.tangent)
        self._matrix.setOption(dx.PETSc.Mat.Option.SYMMETRIC, True)
        self._multipliers = dx.size_of_second(shell.space)
        self._solver = dx.PETSc.PC().create(shell.comm)
        self._solver.setOperators(self._matrix)
        self._solver.setType("cholesky")
        serial = shell.comm.size == 1
        self._solver.setFactorSolverType("petsc" if serial else "mumps")
        if not serial:
            self._solver.setFactorSetUpSolverType()
            factors = self._solver.getFactorMatrix()
            factors.setMumpsIcntl(13, 1)  # no part goes to ScaLAPACK, which counts no inertia
            factors.setMumpsIcntl(24, 1)  # null pivots are told apart

    def __enter__(self) -> Stability:
        return self

    def __exit__(self, *_: object) -> None:
        self._solver.destroy()
        self._matrix.destroy()

    def falling(self) -> int:
        """Number of independent directions in which the potential falls; 0 where stable.

        It is counted anew where the volume has moved since the last count, or the pressure:
        towards a limit point the volume moves ever faster.
        """
        place = (self._shell.volume(), float(self._shell.pressure.value))
        if self._near(place):
            return self._falling
        self._falling, self._place = self._count(), place
        return self._falling

    def _near(self, place: tuple[float, float]) -> bool:
        """Whether the last count was in a state that looks the same from here."""
        volume, pressure = self._place
        if self._shell.force is not None:  # which may move the wall at constant volume
            return False
        return abs(place[0] - volume) < _SAME * volume and place[1] == pressure

    def _count(self) -> int:
        dx.assemble_matrix(self._matrix, self._shell.tangent, self._shell.conditions)
        self._solver.setUp()
        negative, _, _ = self._solver.getFactorMatrix().getInertia()
        return int(negative) - self._multipliers
