"""The unloaded wall on its mesh: meridian, quadrature points and growing elements."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import CONSTRAINED, Discretisation
from .growth_weights import Weights
from .laws import Parameter

Array = NDArray[np.float64]

ELASTIC, GROWING = 0, 1
AXIAL, ROTATION = 1, 2  # components of (u_r, u_z, β)


class Reference:
    """The unloaded wall of a discretisation.

    Parameters
    ----------
    discretisation
        Reference meridian, elements and zones.
    comm
        MPI communicator that shares the mesh.
    order
        Lagrange degree of displacement and rotation.

    Attributes
    ----------
    mesh, degree
        Interval mesh, and degree of its quadrature rule.
    quadrature_S
        Arc length in µm of the quadrature points, shape ``(elements, points)``.
    growing_elements
        Indices of the local elements that grow, ghosts among them.
    """

    def __init__(self, discretisation: Discretisation, comm: Any, order: int) -> None:
        self.discretisation = discretisation
        self.mesh = mesh = dx.interval_mesh(comm, discretisation.nodes)
        self.degree = 2 * order - 1  # as many Gauss points as the order, which avoids locking
        places = dx.quadrature_points(self.degree).ravel()
        vertices = mesh.geometry.x[dx.element_vertices(mesh), 0]
        S = vertices[:, :1] + (vertices[:, 1:] - vertices[:, :1]) * places
        grows = np.zeros(len(S), dtype=bool)
        for part in discretisation.growing:
            grows |= part.holds(S.mean(axis=1))
        self.quadrature_S: Array = S
        self.growing_elements = np.flatnonzero(grows).astype(np.int32)
        self._grows = grows

    def meridian(self) -> tuple[Any, Any, Any]:
        """Return radius, angle and curvature `R, Φ, Φ'` at the quadrature points, in UFL."""
        curve, S = self.discretisation.curve, self.quadrature_S
        space = dx.quadrature_space(self.mesh, 3, self.degree)
        function = dx.fem.Function(space)
        values = np.stack([curve.radius(S), curve.angle(S), curve.curvature(S)], axis=-1)
        function.x.array[dx.dof_array(space)] = values.reshape(len(S), -1)
        return function[0], function[1], function[2]

    def measure(self) -> Any:
        """Return the UFL measure `dS`, with subdomains `ELASTIC` and `GROWING`."""
        tags = np.where(self._grows, GROWING, ELASTIC).astype(np.int32)
        metadata = {"quadrature_degree": self.degree, "quadrature_rule": "default"}
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
        """Return a number as a constant, a function of arc length as a quadrature field."""
        if isinstance(value, Weights):
            raise TypeError("only parameters of a growth law can be weights")
        if not callable(value):
            return self.constant(value)
        space = dx.quadrature_space(self.mesh, 1, self.degree)
        function = dx.fem.Function(space)
        function.x.array[dx.dof_array(space)] = value(self.quadrature_S)
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
