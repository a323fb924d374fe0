"""The unloaded wall on its mesh: meridian, quadrature points, coefficients and supports."""

from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import CONSTRAINED, Discretisation
from .laws import Parameter
from .quadrature import QuadraturePoints

ELASTIC, GROWING = 0, 1
AXIAL, ROTATION = 1, 2  # components of (u_r, u_z, β)


class Reference:
    """The unloaded wall of a discretisation, for displacements of a Lagrange degree.

    Attributes
    ----------
    mesh
        Interval mesh of the meridian, shared by a communicator.
    points, growing_points
        Quadrature points of the local elements, and of those that grow.
    """

    def __init__(self, discretisation: Discretisation, comm: Any, order: int) -> None:
        self.discretisation = discretisation
        self.mesh = mesh = dx.interval_mesh(comm, discretisation.nodes)
        elements = np.arange(len(dx.element_vertices(mesh)), dtype=np.int32)
        # As many Gauss points as the order, which avoids locking.
        self.points = QuadraturePoints(mesh, elements, degree=2 * order - 1)
        self._grows = self.points.inside(discretisation.growing)
        self.growing_points = self.points.at(self._grows)

    def meridian(self) -> tuple[Any, Any, Any]:
        """Return radius, angle and curvature `R, Φ, Φ'` at the quadrature points, in UFL."""
        curve, S = self.discretisation.curve, self.points.S
        function, dofs = self.points.function(3)
        values = np.stack([curve.radius(S), curve.angle(S), curve.curvature(S)], axis=-1)
        function.x.array[dofs] = values.reshape(len(S), -1)
        return function[0], function[1], function[2]

    def measure(self) -> Any:
        """Return the UFL measure `dS`, with subdomains `ELASTIC` and `GROWING`."""
        tags = np.where(self._grows, GROWING, ELASTIC).astype(np.int32)
        metadata = {"quadrature_degree": self.points.degree, "quadrature_rule": "default"}
        return ufl.Measure(
            "dx",
            domain=self.mesh,
            subdomain_data=dx.element_tags(self.mesh, tags),
            metadata=metadata,
        )

    def constant(self, value: float) -> Any:
        """Return a constant of the forms."""
        return dx.fem.Constant(self.mesh, np.float64(value))

    def coefficient(self, value: Parameter) -> Any:
        """Return a number as a constant, a function of arc length as a quadrature function."""
        if isinstance(value, tuple):
            raise TypeError("only parameters of a growth law can be weights")
        if not callable(value):
            return self.constant(value)
        function, dofs = self.points.function(1)
        function.x.array[dofs] = value(self.points.S)
        return function[0]

    def constrain_ends(self, space: Any, bending: bool) -> tuple[list[Any], NDArray[np.int32]]:
        """Return the conditions at poles and supports, all homogeneous, and their local DOFs."""
        ends = zip(self.discretisation.ends, self.discretisation.ends_at, strict=True)
        fixed = [(i, S) for end, S in ends for i in CONSTRAINED[end] if bending or i < ROTATION]
        if all(i != AXIAL for i, _ in fixed):
            fixed.append((AXIAL, 0.0))  # otherwise a closed cell could move along its axis
        dofs = [(dx.end_dofs(space, i, S), dx.motion_part(space, i)) for i, S in fixed]
        zero = self.constant(0.0)
        conditions = [dx.fem.dirichletbc(zero, d, part) for d, part in dofs]
        return conditions, np.concatenate([d for d, _ in dofs])
