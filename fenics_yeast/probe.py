"""What is read off a shell: the numbers of a history row and whole profiles."""

from __future__ import annotations

import numpy as np
import ufl
from numpy.typing import NDArray

from . import _dolfinx as dx
from . import kinematics, wall
from .growth import WallPoint
from .record import Profile
from .shell import Shell

Array = NDArray[np.float64]


class Probe:
    """Reads the trial state of a shell; every method is collective over its communicator."""

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        curve, zone = shell.discretisation.curve, shell.discretisation.zone
        self._S, self._dofs = dx.node_dofs(shell.space)
        self._R, self._Z = curve.radius(self._S), curve.height(self._S)
        self._Phi = curve.angle(self._S)
        near = 1e-9 * curve.length
        self._top = np.abs(self._S - curve.length) < near
        self._edge = self._bud = np.zeros(len(self._S), dtype=bool)
        if zone is not None:
            self._bud = (zone.start - near < self._S) & (self._S < zone.end + near)
            ends = [s for s in (zone.start, zone.end) if near < s < curve.length - near]
            self._edge = np.any([np.abs(self._S - s) < near for s in ends], axis=0) & self._bud
        owned = shell.mesh.topology.index_map(1).size_local
        self._cells = np.arange(owned, dtype=np.int32)
        self._fields = dx.compile_expression(
            self._point_fields(), dx.quadrature_points(shell.degree)
        )

    def _point_fields(self) -> object:
        """Strains, Cauchy stresses and growth strains at each thickness point."""
        values = []
        for j, eps in enumerate(self._shell.eps):
            growth = self._shell.growth
            eps_g = ufl.as_vector([0, 0]) if growth is None else growth.strain(j)
            tau = wall.kirchhoff_stress(self._shell.energy, kinematics.elastic(eps, eps_g))
            sigma = tau / WallPoint(tau, eps, eps_g).J
            values += [vector[i] for vector in (eps, sigma, eps_g) for i in range(2)]
        return ufl.as_vector(values)

    def _radii(self) -> Array:
        return self._R + self._shell.w.x.array[self._dofs[:, 0]]

    def _largest(self, values: Array) -> float:
        """Largest value on all ranks; 0 where there is none."""
        largest = values.max(initial=-np.inf)
        result = float(self._shell.comm.allreduce(largest, op=dx.MPI.MAX))
        return result if np.isfinite(result) else 0.0

    def pole_height(self) -> float:
        """Height of the top pole above the bottom pole, µm."""
        u_z = self._shell.w.x.array[self._dofs[self._top, 1]]
        curve = self._shell.discretisation.curve
        bottom = float(curve.height(np.zeros(1))[0])
        return self._largest(self._Z[self._top] + u_z) - bottom

    def bud_radius(self) -> float:
        """Largest radius of the growing zone, µm; 0 without one."""
        return self._largest(self._radii()[self._bud])

    def neck_radius(self) -> float:
        """Radius at the edge of the growing zone, µm; 0 without an edge."""
        return self._largest(self._radii()[self._edge])

    def max_growth_strain(self) -> float:
        """Largest growth strain at any point of the wall."""
        growth = self._shell.growth
        return 0.0 if growth is None else self._largest(growth.get())

    def profile(self, time: float) -> Profile | None:
        """Profile of the wall; None but on rank 0."""
        shell = self._shell
        motion = shell.w.x.array[self._dofs]
        nodes = np.column_stack(
            [self._S, self._R + motion[:, 0], self._Z + motion[:, 1], self._Phi + motion[:, 2]]
        )
        fields = dx.evaluate(self._fields, shell.mesh, self._cells)
        S = shell.quadrature_S[self._cells]
        parts = shell.comm.gather((nodes, S.ravel(), fields.reshape(S.size, -1, 3, 2)))
        if parts is None:
            return None
        nodes, S, fields = (np.concatenate(pieces) for pieces in zip(*parts, strict=True))
        nodes, order = nodes[np.argsort(nodes[:, 0])], np.argsort(S)
        eps, sigma, eps_g = (np.ascontiguousarray(fields[order, :, i]) for i in range(3))
        S_nodes, r, z, psi = np.ascontiguousarray(nodes.T)
        return Profile(time, S_nodes, r, z, psi, S[order], shell.xi, eps, sigma, eps_g)
