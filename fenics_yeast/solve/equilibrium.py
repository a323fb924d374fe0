"""Equilibrium of a shell by PETSc's SNES, at given growth or with growth implicit in its stage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..mechanics import DofValues, PointValues, Shell, ShellState
from .initial_guess import inflate_flat_membrane
from .residual import Equations, use_lu

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
_ALIKE = 0.1  # relative difference of stages that may share a tangent


@dataclass(frozen=True)
class ChordState:
    """Where a tangent was formed: formed there again, it is the same.

    Attributes
    ----------
    w, eps_g, base
        Trial state, growth strains and those from which their stage started; the latter two are
        None for an elastic wall.
    stage, pressure
        Length of the stage in min, and the pressure in MPa.
    span
        Times in min between which growth was as then.
    """

    w: DofValues
    eps_g: PointValues | None
    base: PointValues | None
    stage: float
    pressure: float
    span: tuple[float, ...]


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


def newton(comm: Any, prefix: str, tolerance: float) -> Any:
    """SNES with Newton's method and line search; done when the residual's norm is small."""
    snes = dx.PETSc.SNES().create(comm)
    snes.setOptionsPrefix(prefix)
    snes.setType("newtonls")
    snes.setTolerances(rtol=0.0, atol=tolerance, stol=0.0, max_it=_MOST_ITERATIONS)
    return snes


def check_convergence(snes: Any) -> int:
    """Newton iterations of a solution that converged.

    Raises
    ------
    EquilibriumError
        With SNES' reason in words where it did not.
    """
    reason, iterations = snes.getConvergedReason(), snes.getIterationNumber()
    if reason > 0:
        return int(iterations)
    words = REASONS.get(reason, f"SNES stopped for its reason {reason}")
    raise EquilibriumError(words, iterations)


class Equilibrium:
    """Newton's method with line search for one shell; a context manager.

    Parameters
    ----------
    shell
        The wall; the solver moves its trial state.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    reuse_threshold
        Reduction of the residual by an iteration that keeps the tangent of an earlier one, also
        of an earlier solution, in use; 0 for a new tangent at each iteration.
    """

    def __init__(self, shell: Shell, tolerance: float, reuse_threshold: float = 0.03) -> None:
        self._shell = shell
        self._good_reduction = reuse_threshold
        self._formed: ChordState | None = None  # the tangent in use
        self._norm = 0.0
        self._equations = equations = Equations(shell)
        self._x = equations.matrix.createVecRight()
        self._f = equations.matrix.createVecLeft()
        self.snes = newton(shell.comm, "equilibrium_", tolerance)
        self.snes.setFunction(self._residual, self._f)
        self.snes.setJacobian(self._jacobian, equations.matrix)
        self._solver = self.snes.getKSP()
        use_lu(self._solver)
        self.snes.setFromOptions()

    def __enter__(self) -> Equilibrium:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        # The solver too: PETSc keeps what outlives its SNES until a collective clean-up.
        for item in (self._solver, self.snes, self._equations, self._x, self._f):
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
        before, shell = self._shell.state(), self._shell
        inflate_flat_membrane(shell, lambda volume, pressure: pressure, float(shell.pressure.value))
        self._x.array[:] = shell.w.x.array[: self._equations.owned]
        self.snes.solve(None, self._x)
        try:
            iterations = check_convergence(self.snes)
        except EquilibriumError:
            self._shell.restore(before)
            self._formed = None
            raise
        self._equations.set_trial_if_changed(self._x.array_r)
        return iterations

    def state(self) -> ChordState | None:
        return self._formed

    @property
    def tangent(self) -> ChordState | None:
        """Where the tangent in use was formed; None if the next solution forms a new one."""
        return self._formed

    def restore(self, tangent: ChordState | None) -> None:
        """Form the tangent of an earlier run again; this moves the trial state there."""
        self._formed = tangent
        if tangent is None:
            return
        shell, growth = self._shell, self._shell.growth
        shell.restore(ShellState(tangent.w, tangent.eps_g))
        shell.pressure.value = tangent.pressure
        if growth is not None and tangent.base is not None:
            growth.stage.value = tangent.stage
            growth.set_base(tangent.base)
            growth.set_interval(*tangent.span)
            growth.update_weights()
        self._equations.tangent()

    def compliance(self) -> float:
        """Change of volume by pressure `dV/dp` of the trial state at given growth, µm³/MPa.

        It grows without bound towards a limit point and is negative beyond it.
        """
        self._equations.tangent()
        self._formed = None
        self._solver.setOperators(self._equations.matrix)
        self._equations.assemble(self._shell.forms.volume_gradient, self._f.array)
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
        self._equations.assemble(self._shell.forms.residual, self._f.array)
        growth.set(accepted)
        return -2 * np.pi * self._volume_response()

    def _volume_response(self) -> float:
        """Volume per 2π that the solution for the force in `_f` displaces."""
        self._solver.solve(self._f, self._x)
        self._equations.assemble(self._shell.forms.volume_gradient, self._f.array)
        return float(self._f.dot(self._x))

    def _residual(self, snes: Any, x: Any, f: Any) -> None:
        self._equations.residual(x.array_r, f.array)

    def _jacobian(self, snes: Any, x: Any, J: Any, P: Any) -> None:
        """Form the tangent, unless the one in use does well: forming it is half of the cost."""
        norm, first = snes.getFunctionNorm(), snes.getIterationNumber() == 0
        growth = self._shell.growth
        stage = 0.0 if growth is None else float(growth.stage.value)
        good = first or norm < self._good_reduction * self._norm
        self._norm = norm
        formed = self._formed
        alike = formed is not None and abs(stage - formed.stage) <= _ALIKE * stage
        if good and alike and self._good_reduction > 0:
            return
        self._equations.tangent()
        trial, pressure = self._shell.state(), float(self._shell.pressure.value)
        base, span = (None, ()) if growth is None else (growth.get_base(), growth.span)
        self._formed = ChordState(trial.w, trial.eps_g, base, stage, pressure, span)
