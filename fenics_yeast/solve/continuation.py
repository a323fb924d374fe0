"""Bordered Newton: equilibria with one parameter, a load or time, as an unknown beside the state.

Past a limit point there is no equilibrium at a higher pressure, or at a later time of growth. But
the volume still increases along the path; so it is prescribed in place of the load, or the
displacement of a force, or a weighted sum of both and the load, as in steps of arc length.

References
----------
H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in P. H.
Rabinowitz (ed.), Applications of Bifurcation Theory, Academic Press 1977, 359-384. E. Riks, An
incremental approach to the solution of snapping and buckling problems, Int. J. Solids Struct. 15
(1979) 529-551. P. Wriggers, J. C. Simo, A general procedure for the direct computation of turning
and bifurcation points, Int. J. Numer. Methods Eng. 30 (1990) 155-176.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import Shell
from .equilibrium import EquilibriumError, check_convergence, create_newton, solve_undamped
from .initial_guess import inflate_flat_membrane
from .residual import Equations, use_lu

_PRECISION = 1e-9  # of the volume, relative
_STIFFNESS = 12.0  # E h in µN/µm of a wall whose parameters have the units 1 MPa, µN, min


class BorderedNewton:
    """Newton's method for the state and one parameter; a context manager.

    The tangent is bordered by a row and a column, which are eliminated by blocks: two solutions
    with the plain tangent, and no dense row is stored.

    Parameters
    ----------
    shell
        The wall; the solver changes its trial state.
    parameter
        The unknown beside the state: `shell.pressure`, `shell.force`, or the stage of
        `shell.growth`, whose length is time.
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
        self._scale = tolerance / (_PRECISION * size)  # of the last equation, to a force
        self._size = size
        self._unit = self._unit_of_parameter()
        self._target, self._weights, self._ramp = 0.0, (1.0, 0.0), (0.0, 0.0)
        self._plane: tuple[Array, Array] | None = None
        self._root = shell.comm.rank == 0
        vector = equations.matrix.createVecRight
        self._a, self._b, self._column, self._row = (vector() for _ in range(4))
        local = equations.owned + self._root  # rank 0 owns the parameter
        self._x = dx.PETSc.Vec().createMPI((local, None), comm=shell.comm)
        self._f = self._x.duplicate()
        sizes = (self._x.getSizes(), self._x.getSizes())
        self._bordered = dx.PETSc.Mat().createPython(sizes, context=self, comm=shell.comm)
        self._bordered.setUp()
        self._solver = dx.PETSc.KSP().create(shell.comm)
        self._solver.setOperators(equations.matrix)
        use_lu(self._solver, shell.membrane_stiffness)
        self._snes = create_newton(shell.comm, "bordered_newton_", tolerance)
        self._snes.setFunction(self._residual, self._f)
        self._snes.setJacobian(self._jacobian, self._bordered)
        outer = self._snes.getKSP()
        outer.setType("preonly")
        outer.getPC().setType("python")
        outer.getPC().setPythonContext(self)
        self._snes.setFromOptions()

    def __enter__(self) -> BorderedNewton:
        return self

    def __exit__(self, *_: object) -> None:
        for item in (self._snes, self._solver, self._bordered, self._equations, self._x, self._f,
                     self._a, self._b, self._column, self._row):  # fmt: skip
            item.destroy()

    def _unit_of_parameter(self) -> float:
        """Return the unit of the parameter among DOFs in µm, so that norms depend on no unit."""
        shell = self._shell
        stiffness = shell.membrane_stiffness / _STIFFNESS  # µN/µm
        if self._parameter is shell.pressure:
            return stiffness * shell.rotation**2
        return stiffness if self._force is not None else shell.rotation

    def conjugate(self) -> float:
        """Return what the load works on: volume in µm³ or, for a force, displacement in µm."""
        return self._shell.volume() if self._force is None else self._force.displacement()

    def solve(
        self,
        target: float,
        weights: tuple[float, float] = (1.0, 0.0),
        ramp: tuple[float, float] | None = None,
    ) -> int:
        """Move trial state and parameter to the equilibrium of a given volume or displacement.

        Returns the number of Newton iterations.

        Parameters
        ----------
        target
            Value of the weighted sum of conjugate and parameter; by default, the volume in µm³ or
            the displacement in µm.
        weights
            Of conjugate and parameter in the sum.
        ramp
            Pressure in MPa at the beginning of the stage and its rate in MPa/min, if the stage's
            length is the unknown; by default, the pressure is constant.

        Raises
        ------
        EquilibriumError
            With the reason of SNES; state, growth and loads are then unchanged.
        """
        shell, before = self._shell, self._shell.state()
        value = parameter = float(self._parameter.value)
        pressure = float(shell.pressure.value)
        self._target, self._weights, self._ramp = target, weights, ramp or (pressure, 0.0)
        if self._parameter is shell.pressure:
            value = inflate_flat_membrane(
                shell, lambda V, p: weights[0] * V + weights[1] * p, target
            )
        x = self._x.array
        x[: self._equations.owned] = shell.w.x.array[: self._equations.owned]
        x[self._equations.owned :] = value / self._unit
        guess = x.copy()
        self._snes.solve(None, self._x)
        try:
            try:
                iterations = check_convergence(self._snes)
            except EquilibriumError as damped:
                if self._growth is not None:
                    raise  # a shorter step is cheaper
                self._x.array[:] = guess
                iterations = damped.iterations + solve_undamped(self._snes, self._x)
        except EquilibriumError:
            self._parameter.value = parameter
            if self._growth is not None:
                shell.pressure.value = pressure
            shell.restore(before)
            raise
        self._equations.set_trial(self._set_parameter(self._x))
        return iterations

    def solve_in_plane(self, normal: Array, point: Array, size: float) -> int:
        """Move trial state and load to an equilibrium in a hyperplane of the state.

        Returns and raises what `solve` does.

        Parameters
        ----------
        normal, point
            Its unit normal, zero in the DOFs of other ranks, and one of its points, like `w`.
        size
            Distance that matters.
        """
        scale, self._scale = self._scale, self._scale * self._size / size
        self._plane = (normal, point)
        try:
            return self.solve(0.0)
        finally:
            self._plane, self._scale = None, scale

    def tangent(self) -> tuple[Array, float]:
        """Return what a change of the load by 1 changes along the path.

        These are the DOFs, like `w`, followed by 1, and the conjugate.
        """
        self._weights = (1.0, 0.0)
        self._jacobian(None, None, None, None)
        conjugate = -self._row.dot(self._b) / (self._scale * self._unit)
        motion = -self._equations.with_ghosts(self._b.array_r) / self._unit
        return np.append(motion, 1.0), float(conjugate)

    def _split(self, x: Any) -> tuple[Any, float]:
        """Return the owned DOFs and, on all ranks, the last entry of a bordered vector."""
        values = x.array_r
        last = self._shell.comm.bcast(values[-1] if self._root else None)
        return values[: self._equations.owned], float(last)

    def _set_parameter(self, x: Any) -> Any:
        """Set the parameter, and the pressure at that time, from a bordered vector; return DOFs."""
        values, parameter = self._split(x)
        parameter *= self._unit
        self._parameter.value = parameter
        if self._growth is not None:
            self._shell.pressure.value = self._ramp[0] + self._ramp[1] * parameter
        return values

    def _residual(self, snes: Any, x: Any, f: Any) -> None:
        out, owned = f.array, self._equations.owned
        self._equations.residual(self._set_parameter(x), out[:owned])
        out[owned:] = self._scale * (self._reached() - self._target)

    def _reached(self) -> float:
        """Return the weighted sum of conjugate and parameter, or the distance from the plane."""
        if self._plane is None:
            parameter = float(self._parameter.value)
            return self._weights[0] * self.conjugate() + self._weights[1] * parameter
        normal, point = self._plane
        distance = float(normal @ (self._shell.w.x.array - point))
        return float(self._shell.comm.allreduce(distance))

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
            shell.forms.update_stage_force()
            equations.assemble(shell.forms.stage_force, self._b.array)
            self._column.aypx(self._ramp[1], self._b)
        if self._plane is not None:
            self._row.array[:] = self._plane[0][: equations.owned]
        self._row.scale(self._scale * self._weights[0])
        self._column.scale(self._unit)
        self._solver.solve(self._column, self._b)

    @property
    def _corner(self) -> float:
        """The derivative of the last equation by the parameter in its unit."""
        return self._scale * self._weights[1] * self._unit

    def mult(self, matrix: Any, x: Any, y: Any) -> None:
        """Multiply with the bordered tangent; called by the line search of SNES."""
        values, parameter = self._split(x)
        self._a.array[:] = values
        last = self._row.dot(self._a) + self._corner * parameter
        out, product = y.array, self._equations.matrix * self._a
        out[: self._equations.owned] = product.array_r + parameter * self._column.array_r
        out[self._equations.owned :] = last
        product.destroy()

    def apply(self, pc: Any, x: Any, y: Any) -> None:
        """Solve with the bordered tangent by block elimination; called by the solver of SNES."""
        values, last = self._split(x)
        force = self._a.duplicate()
        force.array[:] = values
        self._solver.solve(force, self._a)
        pivot = self._row.dot(self._b) - self._corner
        change = (self._row.dot(self._a) - last) / pivot if pivot else np.nan  # SNES then fails
        out = y.array
        out[: self._equations.owned] = self._a.array_r - change * self._b.array_r
        out[self._equations.owned :] = change
        force.destroy()
