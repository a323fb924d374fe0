"""Stability of an equilibrium: the inertia of the tangent at given growth and pressure.

By Sylvester's law of inertia, the factors L D Lᵀ of the tangent have as many negative entries in D
as the tangent has negative eigenvalues.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import _dolfinx as dx
from ..mechanics import Shell

_SAME = 2e-3  # relative change of the volume within which a count remains valid


@dataclass(frozen=True)
class StabilityState:
    """The last count of negative modes, and the volume in µm³ and pressure in MPa of its state."""

    negative_modes: int = 0
    volume: float = 0.0
    pressure: float = 0.0


class Stability:
    """Counts the negative modes of a shell: modes that reduce its potential; a context manager.

    The shear force is a multiplier in the mixed potential: each of its DOFs gives the tangent one
    negative eigenvalue. The further ones are negative modes. Only axisymmetric ones are seen.
    """

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        self._last = StabilityState()
        self._matrix = dx.create_matrix(shell.forms.tangent)
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
            factors.setMumpsIcntl(13, 1)  # without ScaLAPACK, which counts no inertia
            factors.setMumpsIcntl(24, 1)  # detect null pivots

    def __enter__(self) -> Stability:
        return self

    def __exit__(self, *_: object) -> None:
        self._solver.destroy()
        self._matrix.destroy()

    def state(self) -> StabilityState:
        """Return the last count."""
        return self._last

    def restore(self, state: StabilityState) -> None:
        """Continue from a count."""
        self._last = state

    def negative_modes(self) -> int:
        """Return the number of negative modes; 0 if the trial state is stable.

        They are counted again if the volume has changed since the last count, or the pressure:
        towards a limit point of an inflated wall the volume changes ever faster.
        """
        shell, last = self._shell, self._last
        volume, pressure = shell.volume(), float(shell.pressure.value)
        near = abs(volume - last.volume) < _SAME * last.volume and pressure == last.pressure
        # A force or external pressure may buckle the wall at the same volume.
        if not near or pressure <= 0 or shell.force is not None:
            self._last = StabilityState(self._count(), volume, pressure)
        return self._last.negative_modes

    def _count(self) -> int:
        dx.assemble_matrix(self._matrix, self._shell.forms.tangent, self._shell.conditions)
        self._solver.setUp()
        negative, _, _ = self._solver.getFactorMatrix().getInertia()
        return int(negative) - self._multipliers
