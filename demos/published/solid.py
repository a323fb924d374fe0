"""An axisymmetric solid as a two-dimensional continuum, which the shell approximates.

The mesh is a rectangle of arc length S and distance ξ from the mid-surface; the reference wall is
`R + ξ sin Φ`, `Z - ξ cos Φ`, exactly, and the deformation gradient follows by the chain rule.
Kinematics, energy and solver are independent of the shell's.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import numpy as np
import ufl

from fenics_yeast._dolfinx import MPI, PETSc, dolfinx, fem  # Debian's or PyPI's
from fenics_yeast._dolfinx import basix_ufl as elements

logging.getLogger().setLevel(logging.WARNING)  # compilation is reported as INFO

_MOST_ITERATIONS = 25
_REDUCTION, _LEAST = 1e-9, 1e-11  # of the residual's norm

Meridian = Callable[[Any], tuple[Any, Any, Any]]  # R, Z, Φ of S in UFL


def function_space(mesh: Any, incompressible: bool) -> Any:
    """Return quadratic displacements and, if incompressible, linear pressures."""
    if elements is None:
        cell = mesh.ufl_cell()
        motion = ufl.VectorElement("Lagrange", cell, 2, dim=2)
        pressure = ufl.FiniteElement("Lagrange", cell, 1)
        mixed = ufl.MixedElement([motion, pressure])
        return fem.FunctionSpace(mesh, mixed if incompressible else motion)
    cell = mesh.basix_cell()
    motion = elements.element("Lagrange", cell, 2, shape=(2,))
    pressure = elements.element("Lagrange", cell, 1)
    mixed = elements.mixed_element([motion, pressure])
    return fem.functionspace(mesh, mixed if incompressible else motion)


class Solid:
    """A wall of revolution meshed through its thickness.

    Parameters
    ----------
    meridian
        `R, Z, Φ` of the mid-surface as UFL expressions of S.
    stops
        Arc lengths of the elements' ends in µm, shape ``(n + 1,)``.
    h
        Thickness in µm.
    energy
        Energy in MPa of the deformation gradient, 3 by 3, and of S; without that of volume changes
        if `incompressible`.
    incompressible
        Whether a multiplier, the pressure, keeps the volume constant.
    layers
        Number of elements through the thickness.
    """

    def __init__(
        self, meridian: Meridian, stops: np.ndarray, h: float, energy: Callable[[Any, Any], Any],
        incompressible: bool, layers: int = 2,
    ) -> None:  # fmt: skip
        n = len(stops) - 1
        corners = [np.array([0.0, -1.0]), np.array([float(n), 1.0])]
        mesh = dolfinx.mesh.create_rectangle(
            MPI.COMM_SELF, corners, [n, layers], dolfinx.mesh.CellType.quadrilateral
        )
        x = mesh.geometry.x
        x[:, 0], x[:, 1] = stops[np.rint(x[:, 0]).astype(int)], x[:, 1] * h / 2
        mesh.topology.create_connectivity(0, 2)  # not automatic in dolfinx 0.9
        self.mesh, self.h, self.length = mesh, h, float(stops[-1])
        self.space = function_space(mesh, incompressible)
        self.motion = self.space.sub(0) if incompressible else self.space
        self.w = fem.Function(self.space)
        parts = ufl.split(self.w) if incompressible else (self.w, None)
        self.u, multiplier = parts

        S, xi = ufl.SpatialCoordinate(mesh)
        R, Z, Phi = meridian(S)
        r = R + xi * ufl.sin(Phi)
        X = ufl.as_vector([r, Z - xi * ufl.cos(Phi)])
        self.x = X + self.u
        by_reference = ufl.inv(ufl.grad(X))
        F = ufl.grad(self.x) * by_reference
        hoop = self.x[0] / r
        F = ufl.as_matrix([[F[0, 0], F[0, 1], 0], [F[1, 0], F[1, 1], 0], [0, 0, hoop]])
        density = energy(F, S)
        if incompressible:
            density += multiplier * (ufl.det(F) - 1)
        size = r * abs(ufl.det(ufl.grad(X)))
        potential = density * size * ufl.dx(metadata={"quadrature_degree": 6})
        self.pressure = fem.Constant(mesh, np.float64(0))
        lines = [self._line(xi) for xi in (-h / 2, h / 2, 0.0)]
        facets = np.concatenate(lines)
        marks = np.repeat(np.array([1, 2, 3], dtype=np.int32), [len(line) for line in lines])
        order = np.argsort(facets)
        tags = dolfinx.mesh.meshtags(mesh, 1, facets[order], marks[order])
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)
        enclosed = self.x[0] ** 2 * ufl.grad(self.x)[1, 0] / 2  # per 2π, along S
        middle = ufl.Measure("dS", domain=mesh, subdomain_data=tags)(3)
        self._below_middle = fem.form(2 * np.pi * enclosed("+") * middle)
        potential -= self.pressure * enclosed * ds(1)  # turgor on the inner face
        self.residual = ufl.derivative(potential, self.w, ufl.TestFunction(self.space))
        self.form = fem.form(self.residual)

    def _line(self, xi: float) -> np.ndarray:
        """Return the facets at a distance from the mid-surface."""
        near = 1e-6 * self.h
        found = dolfinx.mesh.locate_entities(self.mesh, 1, lambda x: np.abs(x[1] - xi) < near)
        return found.astype(np.int32)

    def hold(
        self, component: int, where: Callable[[np.ndarray], np.ndarray], value: Any = 0.0
    ) -> Any:
        """Return a condition on a component of the displacement at some vertices."""
        vertices = dolfinx.mesh.locate_entities(self.mesh, 0, where)
        if len(vertices) > 1:  # a face, with its mid-side nodes
            facets = dolfinx.mesh.locate_entities_boundary(self.mesh, 1, where)
            dofs = fem.locate_dofs_topological(self.motion.sub(component), 1, facets)
        else:
            dofs = fem.locate_dofs_topological(self.motion.sub(component), 0, vertices)
        value = value if isinstance(value, fem.Constant) else fem.Constant(self.mesh, float(value))
        return fem.dirichletbc(value, dofs, self.motion.sub(component))

    def solver(self, conditions: list[Any]) -> Callable[[], None]:
        """Return Newton's method, which starts from the state of its last call."""
        tangent = fem.form(ufl.derivative(self.residual, self.w))
        w = PETSc.Vec().createWithArray(self.w.x.array, comm=MPI.COMM_SELF)
        change, direct = w.duplicate(), PETSc.KSP().create(MPI.COMM_SELF)
        direct.setType("preonly")
        direct.getPC().setType("lu")
        direct.getPC().setFactorSolverType("mumps")

        def residual() -> Any:
            b = fem.petsc.assemble_vector(self.form)
            fem.petsc.apply_lifting(b, [tangent], [conditions], [w], -1.0)
            fem.petsc.set_bc(b, conditions, w, -1.0)
            return b

        def solve() -> None:
            b = residual()
            target = max(_LEAST, _REDUCTION * b.norm())
            left = _MOST_ITERATIONS
            while b.norm() > target:
                if not left:
                    raise RuntimeError(f"no convergence in {_MOST_ITERATIONS} Newton iterations")
                left -= 1
                matrix = fem.petsc.assemble_matrix(tangent, conditions)
                matrix.assemble()
                direct.setOperators(matrix)
                direct.solve(b, change)
                w.axpy(-1.0, change)
                b = residual()

        return solve

    def middle_volume(self) -> float:
        """Return the volume enclosed by the mid-surface in µm³; the number of layers is even."""
        return float(fem.assemble_scalar(self._below_middle))
