"""Equilibrium where what loads the wall, pressure, force or time, is an unknown beside the state.

Past a limit point there is no equilibrium at a higher pressure, or at a later time of growth; but
the volume still goes on, and leads the solution over the top. What is prescribed instead of the
load is the volume (or the displacement of a force), or a weighted sum of volume and load, as in
steps along an arc of the path.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..mechanics import Shell
from .equilibrium import EquilibriumError, check_convergence, newton
from .initial_guess import inflate_flat_membrane
from .residual import Equations, use_lu

_PRECISION = 1e-9  # of the volume, relative


class BorderedNewton:
    """Newton's method for the state and one parameter of the load; a context manager.

    The tangent is bordered by a row and a column. They are eliminated by blocks, with two
    solutions of the plain tangent, so that no dense row is stored.

    Parameters
    ----------
    shell
        The wall; the solver moves its trial state.
    parameter
        The unknown beside the state: `shell.pressure`, `shell.force`, or the stage of
        `shell.growth`.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    """

    def __init__(self, shell: Shell, parameter: Any, tolerance: float) -> None:
        self._shell, self._parameter = shell, parameter
        self._force = shell.force if parameter is shell.force else None
        by_growth = self._force is None and parameter is not shell.pressure
        self._growth = shell.growth if by_growth else None
        self._equations = equations = Equations(shell)
        size = shell.reference_volume if self._force is None else self._force.scale
        self._weight = tolerance / (_PRECISION * size)
        self._target = self._by_parameter = 0.0
        self._by_amount = 1.0
        self._rise = (0.0, 0.0)
        self._root = shell.comm.rank == 0
        vector = equations.matrix.createVecRight
        self._a, self._b, self._column, self._row = (vector() for _ in range(4))
        size = equations.owned + self._root  # rank 0 owns the parameter
        self._x = dx.PETSc.Vec().createMPI((size, None), comm=shell.comm)
        self._f = self._x.duplicate()
        sizes = (self._x.getSizes(), self._x.getSizes())
        self._bordered = dx.PETSc.Mat().createPython(sizes, context=self, comm=shell.comm)
        self._bordered.setUp()
        self._solver = dx.PETSc.KSP().create(shell.comm)
        self._solver.setOperators(equations.matrix)
        use_lu(self._solver)
        self.snes = newton(shell.comm, "volume_control_", tolerance)
        self.snes.setFunction(self._residual, self._f)
        self.snes.setJacobian(self._jacobian, self._bordered)
        outer = self.snes.getKSP()
        outer.setType("preonly")
        outer.getPC().setType("python")
        outer.getPC().setPythonContext(self)
        self.snes.setFromOptions()

    def __enter__(self) -> BorderedNewton:
        return self

    def __exit__(self, *_: object) -> None:
        for item in (self.snes, self._solver, self._bordered, self._equations, self._x, self._f,
                     self._a, self._b, self._column, self._row):  # fmt: skip
            item.destroy()

    def amount(self) -> float:
        """What the load works on: volume in µm³, or displacement in µm of a force."""
        return self._shell.volume() if self._force is None else self._force.displacement()

    def solve(
        self,
        target: float,
        by_amount: float = 1.0,
        by_parameter: float = 0.0,
        rise: tuple[float, float] | None = None,
    ) -> int:
        """Move trial state and parameter into the equilibrium of a given volume or displacement.

        Parameters
        ----------
        target
            What the weighted sum of amount and parameter shall be; with the weights left out, the
            amount: volume in µm³ or, of a force, displacement in µm.
        by_amount, by_parameter
            The weights.
        rise
            Pressure in MPa at the beginning of the stage, and its rate in MPa/min, where the
            stage's length is the unknown; left out, the pressure stays.

        Returns
        -------
        int
            Newton iterations.

        Raises
        ------
        EquilibriumError
            With SNES' reason in words; state, growth and parameter are then as before.
        """
        before = self._shell.state()
        value = accepted = float(self._parameter.value)
        self._target, self._by_amount, self._by_parameter = target, by_amount, by_parameter
        self._rise = rise or (float(self._shell.pressure.value), 0.0)
        if self._parameter is self._shell.pressure:
            value = inflate_flat_membrane(
                self._shell, lambda V, p: by_amount * V + by_parameter * p, target
            )
        x = self._x.array
        x[: self._equations.owned] = self._shell.w.x.array[: self._equations.owned]
        x[self._equations.owned :] = value
        self.snes.solve(None, self._x)
        try:
            iterations = check_convergence(self.snes)
        except EquilibriumError:
            self._parameter.value = accepted
            if self._growth is not None:
                self._shell.pressure.value = self._rise[0]
            self._shell.restore(before)
            raise
        state, self._parameter.value = self._parts(self._x)
        if self._growth is not None:
            self._shell.pressure.value = self._rise[0] + self._rise[1] * self._parameter.value
        self._equations.load(state)
        return iterations

    def _parts(self, x: Any) -> tuple[Any, float]:
        """State and parameter of an extended vector."""
        values = x.array_r
        parameter = self._shell.comm.bcast(values[-1] if self._root else None)
        return values[: self._equations.owned], float(parameter)

    def _residual(self, snes: Any, x: Any, f: Any) -> None:
        state, parameter = self._parts(x)
        self._parameter.value = parameter
        if self._growth is not None:
            self._shell.pressure.value = self._rise[0] + self._rise[1] * parameter
        out = f.array
        self._equations.residual(state, out[: self._equations.owned])
        reached = self._by_amount * self.amount() + self._by_parameter * parameter
        out[self._equations.owned :] = self._weight * (reached - self._target)

    def _jacobian(self, snes: Any, x: Any, J: Any, P: Any) -> None:
        shell, equations = self._shell, self._equations
        equations.tangent()
        self._solver.setOperators(equations.matrix)
        if self._force is None:
            equations.assemble(shell.forms.volume_gradient, self._row.array)
            self._row.scale(2 * np.pi)
        else:
            self._force.direction(self._row.array)
        if self._force is None and shell.forms.pressure_force is not None:
            equations.assemble(shell.forms.pressure_force, self._column.array)
        else:
            self._column.array[:] = -self._row.array_r / (2 * np.pi)
        if self._growth is not None:
            equations.assemble(shell.forms.stage_force, self._b.array)
            self._column.aypx(self._rise[1], self._b)
        self._row.scale(self._weight * self._by_amount)
        self._solver.solve(self._column, self._b)

    def mult(self, matrix: Any, x: Any, y: Any) -> None:
        """Product of the bordered tangent, which the line search asks for."""
        state, parameter = self._parts(x)
        self._a.array[:] = state
        last = self._row.dot(self._a) + self._weight * self._by_parameter * parameter
        out, product = y.array, self._equations.matrix * self._a
        out[: self._equations.owned] = product.array_r + parameter * self._column.array_r
        out[self._equations.owned :] = last
        product.destroy()

    def apply(self, pc: Any, x: Any, y: Any) -> None:
        """Solution with the bordered tangent, by blocks."""
        force, last = self._parts(x)
        product = self._a.duplicate()
        product.array[:] = force
        self._solver.solve(product, self._a)
        corner = self._weight * self._by_parameter
        change = (self._row.dot(self._a) - last) / (self._row.dot(self._b) - corner)
        out = y.array
        out[: self._equations.owned] = self._a.array_r - change * self._b.array_r
        out[self._equations.owned :] = change
        product.destroy()
