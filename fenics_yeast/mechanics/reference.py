"""The unloaded wall on its mesh: meridian, quadrature points, coefficients and supports."""

from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import CONSTRAINED, Discretisation
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
    edge_radius
        Radius of the upper end in µm, a constant of the forms.
    """

    def __init__(self, discretisation: Discretisation, comm: Any, order: int) -> None:
        self.discretisation = discretisation
        self.mesh = mesh = dx.interval_mesh(comm, discretisation.nodes)
        self._number = np.searchsorted(discretisation.nodes, mesh.geometry.x[:, 0])
        self._elements = np.arange(len(dx.element_vertices(mesh)), dtype=np.int32)
        # As many Gauss points as the order, which avoids locking.
        self._degree = 2 * order - 1
        self.points = QuadraturePoints(mesh, self._elements, self._degree)
        self._grows = self.points.inside(discretisation.growing)
        self.growing_points = self.points.at(self._grows)
        self._meridian, self._dofs = self.points.function(3)
        self.edge_radius = self.constant(0.0)
        self._set_meridian()

    def move(self, discretisation: Discretisation) -> None:
        """Move the nodes to those of another meridian, with as many elements that grow alike."""
        self.discretisation = discretisation
        self.mesh.geometry.x[:, 0] = discretisation.nodes[self._number]
        self.points = QuadraturePoints(self.mesh, self._elements, self._degree)
        self.growing_points = self.points.at(self._grows)
        self._set_meridian()

    def meridian(self) -> tuple[Any, Any, Any]:
        """Return radius, angle and curvature `R, Φ, Φ'` at the quadrature points, in UFL."""
        return self._meridian[0], self._meridian[1], self._meridian[2]

    def _set_meridian(self) -> None:
        curve, S = self.discretisation.curve, self.points.S
        values = np.stack([curve.radius(S), curve.angle(S), curve.curvature(S)], axis=-1)
        self._meridian.x.array[self._dofs] = values.reshape(len(S), -1)
        self.edge_radius.value = np.float64(curve.radius(np.array([curve.length]))[0])

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
