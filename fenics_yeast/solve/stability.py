"""Stability of an equilibrium: the inertia of the tangent at given growth and pressure."""

from __future__ import annotations

from dataclasses import dataclass

from .. import _dolfinx as dx
from ..mechanics import Shell

_SAME = 2e-3  # change of the volume up to which a count is taken over


@dataclass(frozen=True)
class StabilityState:
    """Number of directions in which the potential fell, at a volume in µm³ and pressure in MPa."""

    negative_modes: int = 0
    volume: float = 0.0
    pressure: float = 0.0


class Stability:
    """Counts the directions in which the potential of a shell falls; a context manager.

    The shear force is a multiplier in the mixed potential: each of its unknowns gives the tangent
    one negative eigenvalue. A state is stable if there are no more. Only axisymmetric
    perturbations are seen.

    Attributes
    ----------
    last
        The last count.
    """

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        self.last = StabilityState()
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
            factors.setMumpsIcntl(13, 1)  # no part goes to ScaLAPACK, which counts no inertia
            factors.setMumpsIcntl(24, 1)  # null pivots are told apart

    def __enter__(self) -> Stability:
        return self

    def __exit__(self, *_: object) -> None:
        self._solver.destroy()
        self._matrix.destroy()

    def state(self) -> StabilityState:
        return self.last

    def restore(self, state: StabilityState) -> None:
        self.last = state

    def negative_modes(self) -> int:
        """Number of independent directions in which the potential falls; 0 where stable.

        It is counted anew where the volume has moved since the last count, or the pressure:
        towards a limit point of an inflated wall the volume moves ever faster.
        """
        volume, pressure = self._shell.volume(), float(self._shell.pressure.value)
        if not self._near(volume, pressure):
            self.last = StabilityState(self._count(), volume, pressure)
        return self.last.negative_modes

    def _near(self, volume: float, pressure: float) -> bool:
        """Whether the last count was in a state that looks the same from here."""
        if self._shell.force is not None or pressure <= 0:
            return False  # a force, or a pressure from outside, may fold the wall at its volume
        moved = abs(volume - self.last.volume)
        return moved < _SAME * self.last.volume and pressure == self.last.pressure

    def _count(self) -> int:
        dx.assemble_matrix(self._matrix, self._shell.forms.tangent, self._shell.conditions)
        self._solver.setUp()
        negative, _, _ = self._solver.getFactorMatrix().getInertia()
        return int(negative) - self._multipliers
