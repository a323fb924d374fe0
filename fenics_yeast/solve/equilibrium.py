"""Equilibrium of a shell by a chord (modified) Newton method, at given growth or in its stage.

The tangent is kept from iteration to iteration, and from solution to solution, while the residual
falls fast enough: forming and factorising it is half of the cost.

References
----------
C. T. Kelley, Solving Nonlinear Equations with Newton's Method, SIAM 2003, chapter 2 (Newton, chord
and Shamanskii methods; `reuse_threshold` is the `rsham` of its solver `nsold`). P. Deuflhard,
Newton Methods for Nonlinear Problems, Springer 2004 (simplified Newton methods).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import DofValues, PointValues, Shell, ShellState
from .initial_guess import inflate_flat_membrane
from .residual import Equations, use_lu

_MOST_ITERATIONS = 40
_WINDOW, _FALL = 8, 0.7  # iterations in which the residual must fall by this factor
_MOST_GROWTH = 1e4  # of the residual over that of the guess
_LONGEST = 1e99  # step in µm; by default PETSc shortens those of more than 1e8
_SIMILAR_STAGES = 0.1  # relative difference of stages that may share a tangent

# PETSc's reasons to stop; the one for stagnation belongs to another kind of solver.
_CONVERGED, _NOT_A_NUMBER, _STAGNATED, _DIVERGED = 2, -4, -7, -9

REASONS = {
    -1: "the residual is not defined at the initial guess",
    -2: "too many evaluations of the residual",
    -3: "the linear solver failed",
    _NOT_A_NUMBER: "the residual is not a number",
    -5: f"no convergence within {_MOST_ITERATIONS} Newton iterations",
    -6: "the line search found no smaller residual",
    _STAGNATED: f"the residual hardly fell in {_WINDOW} Newton iterations",
    -8: "Newton's method ended in a local minimum of the residual that is no equilibrium",
    _DIVERGED: "the residual diverged",
    -10: "the Jacobian is not defined",
}


@dataclass(frozen=True)
class ChordState:
    """Where the tangent in use was formed: formed again there, it is exactly the same.

    Attributes
    ----------
    w, eps_g, base
        Trial state, growth strains and those at the start of the stage; the latter two are None
        for an elastic wall.
    stage, pressure, span
        Length of the stage in min, pressure in MPa, and the interval in min of the growth rate.
    """

    w: DofValues
    eps_g: PointValues | None
    base: PointValues | None
    stage: float
    pressure: float
    span: tuple[float, ...]


class EquilibriumError(RuntimeError):
    """No equilibrium was found, in a number of Newton iterations; the shell is unchanged."""

    def __init__(self, message: str, iterations: int) -> None:
        super().__init__(message)
        self.iterations = iterations


def create_newton(comm: Any, prefix: str, tolerance: float) -> Any:
    """Return a SNES with line search that converges at an absolute norm of the residual."""
    snes = dx.PETSc.SNES().create(comm)
    snes.setOptionsPrefix(prefix)
    snes.setType("newtonls")
    snes.setTolerances(rtol=0.0, atol=tolerance, stol=0.0, max_it=_MOST_ITERATIONS)
    dx.PETSc.Options(prefix)["snes_linesearch_maxstep"] = _LONGEST
    return snes


def check_convergence(snes: Any) -> int:
    """Return the Newton iterations of a solution; raise EquilibriumError if it did not converge."""
    reason, iterations = snes.getConvergedReason(), snes.getIterationNumber()
    if reason > 0:
        return int(iterations)
    raise EquilibriumError(REASONS.get(reason, f"SNES stopped with reason {reason}"), iterations)


def solve_undamped(snes: Any, x: Any) -> int:
    """Solve by full Newton steps, without line search; return the iterations.

    Bending a flat wall by a small step strains it, and the forces of that strain exceed the load:
    a line search takes ever smaller steps, although the next full one removes them.

    Raises
    ------
    EquilibriumError
        With the reason of SNES.
    """
    options, key = dx.PETSc.Options(snes.getOptionsPrefix()), "snes_linesearch_type"
    options[key] = "basic"
    snes.setFromOptions()
    try:
        snes.solve(None, x)
        return check_convergence(snes)
    finally:
        options[key] = "bt"
        snes.setFromOptions()
        options.delValue(key)


class Equilibrium:
    """Chord Newton method with line search for one shell; a context manager.

    Parameters
    ----------
    shell
        The wall; the solver changes its trial state.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    reuse_threshold
        The tangent is reused if the last iteration reduced the residual by this factor or more;
        0 for Newton's method, with a new tangent at each iteration.
    """

    def __init__(self, shell: Shell, tolerance: float, reuse_threshold: float = 0.03) -> None:
        self._shell, self._reuse_threshold = shell, reuse_threshold
        self._chord: ChordState | None = None
        self._norm = 0.0  # of the residual at the last iteration
        self._norms: list[float] = []  # of all iterations of a solution
        self._tolerance, self._hurried = tolerance, False
        self._equations = equations = Equations(shell)
        self._x = equations.matrix.createVecRight()
        self._f = equations.matrix.createVecLeft()
        self.snes = create_newton(shell.comm, "equilibrium_", tolerance)
        self.snes.setConvergenceTest(self._reason)
        self.snes.setFunction(self._residual, self._f)
        self.snes.setJacobian(self._jacobian, equations.matrix)
        self._solver = self.snes.getKSP()
        use_lu(self._solver, shell.membrane_stiffness)
        self.snes.setFromOptions()

    def __enter__(self) -> Equilibrium:
        return self

    def __exit__(self, *_: object) -> None:
        # The solver too: PETSc keeps what outlives its SNES until a collective clean-up.
        for item in (self._solver, self.snes, self._equations, self._x, self._f):
            item.destroy()

    def solve(self) -> int:
        """Move the trial state to equilibrium at the shell's loads, growth and stage.

        Returns the number of Newton iterations.

        Raises
        ------
        EquilibriumError
            With the reason of SNES; displacement and growth are then unchanged.
        """
        shell, before = self._shell, self._shell.state()
        inflate_flat_membrane(shell, lambda volume, pressure: pressure, float(shell.pressure.value))
        guess = shell.w.x.array[: self._equations.owned].copy()
        # A shorter step is cheaper than many iterations, but only growth has steps to shorten.
        self._hurried = shell.growth is not None and bool(shell.growth.stage.value > 0)
        self._x.array[:] = guess
        self.snes.solve(None, self._x)
        try:
            try:
                iterations = check_convergence(self.snes)
            except EquilibriumError as damped:
                if self._hurried:
                    raise
                shell.restore(before)
                self._chord = None
                self._x.array[:] = guess
                iterations = damped.iterations + solve_undamped(self.snes, self._x)
        except EquilibriumError:
            shell.restore(before)
            self._chord = None
            raise
        self._equations.set_trial_if_changed(self._x.array_r)
        return iterations

    def state(self) -> ChordState | None:
        """Return where the tangent in use was formed; None if the next solution forms a new one."""
        return self._chord

    def restore(self, state: ChordState | None) -> None:
        """Form the tangent in use again; this moves the shell to where it was formed."""
        self._chord = state
        if state is None:
            return
        shell, growth = self._shell, self._shell.growth
        shell.restore(ShellState(state.w, state.eps_g))
        shell.pressure.value = state.pressure
        if growth is not None and state.base is not None:
            growth.stage.value = state.stage
            growth.set_base(state.base)
            growth.set_interval(*state.span)
            growth.update_weights()
        self._equations.tangent()

    def compliance(self) -> float:
        """Return the change of volume by pressure, `dV/dp`, at given growth, in µm³/MPa.

        It grows without bound towards a limit point and is negative beyond it.
        """
        self._equations.tangent()
        self._chord = None
        self._solver.setOperators(self._equations.matrix)
        self._equations.assemble(self._shell.forms.volume_gradient, self._f.array)
        return 2 * np.pi * self._volume_response()

    def volume_change(self, eps_g: Array) -> float:
        """Return the change of volume in µm³ due to a change of the growth strains.

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
        """Return the volume per 2π that the force in `_f` displaces."""
        self._solver.solve(self._f, self._x)
        self._equations.assemble(self._shell.forms.volume_gradient, self._f.array)
        return float(self._f.dot(self._x))

    def _reason(self, snes: Any, iteration: int, norms: tuple[float, float, float]) -> int:
        """Return why to stop, or 0: PETSc's own test, and whether the residual stagnates."""
        norm, before = norms[2], self._norms
        if iteration == 0:
            before.clear()
        before.append(norm)
        if norm < self._tolerance:
            return _CONVERGED
        if not isfinite(norm):
            return _NOT_A_NUMBER
        if norm > _MOST_GROWTH * before[0]:
            return _DIVERGED
        stagnates = len(before) > _WINDOW and norm > _FALL * before[-1 - _WINDOW]
        return _STAGNATED if stagnates and self._hurried else 0

    def _residual(self, snes: Any, x: Any, f: Any) -> None:
        self._equations.residual(x.array_r, f.array)

    def _jacobian(self, snes: Any, x: Any, J: Any, P: Any) -> None:
        """Form the tangent, unless the one in use reduces the residual fast enough."""
        norm, first = snes.getFunctionNorm(), snes.getIterationNumber() == 0
        fast, self._norm = first or norm < self._reuse_threshold * self._norm, norm
        shell, growth, chord = self._shell, self._shell.growth, self._chord
        stage = 0.0 if growth is None else float(growth.stage.value)
        similar = chord is not None and abs(stage - chord.stage) <= _SIMILAR_STAGES * stage
        if fast and similar and self._reuse_threshold > 0:
            return
        self._equations.tangent()
        trial, pressure = shell.state(), float(shell.pressure.value)
        base, span = (None, ()) if growth is None else (growth.get_base(), growth.span)
        self._chord = ChordState(trial.w, trial.eps_g, base, stage, pressure, span)
