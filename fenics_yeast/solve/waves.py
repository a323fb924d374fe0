"""Stability against perturbations with waves around the axis."""

from __future__ import annotations

from collections.abc import Callable

from .. import _dolfinx as dx
from ..mechanics import Shell
from .equilibrium import Equilibrium, EquilibriumError

_LOCATED = 1e-5  # of a critical pressure
_MOST_HALVINGS = 12  # of a step of pressure without an equilibrium


class WaveModes:
    """Counts the negative modes of a shell for each number of waves; a context manager.

    By Sylvester's law of inertia, as in `Stability`: each DOF of a shear force is a multiplier that
    gives the second variation one negative eigenvalue; the further ones are negative modes.
    """

    def __init__(self, shell: Shell) -> None:
        self._shell, self._variation = shell, shell.second_variation()
        self._matrix = dx.create_matrix(self._variation.form)
        self._matrix.setOption(dx.PETSc.Mat.Option.SYMMETRIC, True)
        self._multipliers = dx.size_of_second(self._variation.space)
        self._solver = dx.PETSc.PC().create(shell.comm)
        self._solver.setOperators(self._matrix)
        self._solver.setType("cholesky")
        self._solver.setFactorSolverType("mumps")
        self._solver.setFactorSetUpSolverType()
        factors = self._solver.getFactorMatrix()
        factors.setMumpsIcntl(13, 1)  # without ScaLAPACK, which counts no inertia
        factors.setMumpsIcntl(24, 1)  # detect null pivots

    def __enter__(self) -> WaveModes:
        return self

    def __exit__(self, *_: object) -> None:
        self._solver.destroy()
        self._matrix.destroy()

    def negative_modes(self, waves: int) -> int:
        """Return the number of negative modes with `waves >= 1` waves in the trial state."""
        variation = self._variation
        variation.waves.value = waves
        dx.assemble_matrix(self._matrix, variation.form, variation.conditions(waves))
        self._solver.setUp()
        negative, _, _ = self._solver.getFactorMatrix().getInertia()
        return int(negative) - self._multipliers


def critical_pressure(
    shell: Shell,
    equilibrium: Equilibrium,
    unstable: Callable[[], bool],
    step: float,
    end: float,
) -> float | None:
    """Return the first pressure in MPa at which an elastic wall is unstable; None if there is none.

    The pressure changes from that of the trial state, in equilibrium, in steps up to an end; the
    critical one is located by bisection. The shell stays at the last stable equilibrium.

    Parameters
    ----------
    shell, equilibrium
        The wall, in equilibrium, and its solver.
    unstable
        Whether the trial state is unstable.
    step, end
        Steps in MPa, signed, and the pressure that is not passed.

    Raises
    ------
    EquilibriumError
        If there is no equilibrium at some pressure before.
    """
    pressure, least = float(shell.pressure.value), abs(step) * 2.0**-_MOST_HALVINGS
    beyond: float | None = None  # a pressure at which the wall is unstable
    stable = shell.state()
    while beyond is None or abs(beyond - pressure) > _LOCATED * abs(beyond):
        trial = pressure + step if beyond is None else (pressure + beyond) / 2
        if beyond is None and (trial - end) * step > 0:
            return None
        shell.pressure.value = trial
        try:
            equilibrium.solve()
        except EquilibriumError:
            step /= 2
            shell.restore(stable)
            if abs(step) < least:
                raise
            continue
        if unstable():
            beyond = trial
            shell.restore(stable)
        else:
            pressure, stable = trial, shell.state()
    shell.pressure.value = pressure
    return (pressure + beyond) / 2
