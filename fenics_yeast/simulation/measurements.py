"""Measure a shell: the numbers of a history row, and profiles."""

from typing import NamedTuple

import numpy as np

from .. import _dolfinx as dx
from ..geometry import NEAR, Array, edges
from ..mechanics import Order, Shell
from .contact import touches_itself
from .profiles import Profile

# Stress over E (h/R)², the order of the stress at which a long ring buckles.
_NOISE = 1e-3


class Sizes(NamedTuple):
    """Pole height, largest radius of growing zones and of their edges in µm, growth strain."""

    pole_height: float
    bud_radius: float
    neck_radius: float
    max_growth_strain: float


class Measurements:
    """Reads the trial state of a shell; every method is collective over its communicator."""

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        curve, growing = shell.discretisation.curve, shell.discretisation.growing
        self._S, self._dofs = dx.node_dofs(shell.space)
        self._nodes = Order(shell.comm, self._S)
        self._R, self._Z = curve.radius(self._S), curve.height(self._S)
        self._Phi = curve.angle(self._S)
        near = NEAR * curve.length
        bottom, top = (np.abs(self._S - S) < near for S in shell.discretisation.ends_at)
        edge = bud = np.zeros(len(self._S), dtype=bool)
        for zone in growing:
            bud = bud | (zone.start - near < self._S) & (self._S < zone.end + near)
        for s in edges(growing, curve):
            edge = edge | (np.abs(self._S - s) < near)
        # Of each quantity: reference values at the nodes that count, their displacements, a sign.
        self._watched = [
            (self._Z[bottom], self._dofs[bottom, 1], -1),
            (self._Z[top], self._dofs[top, 1], 1),
            (self._R[bud], self._dofs[bud, 0], 1),
            (self._R[edge], self._dofs[edge, 0], 1),
        ]
        self._w = shell.w.x.array
        self._S_points = shell.points.at(shell.points.owned).S.ravel()
        self._R_points = curve.radius(self._S_points)
        self._points = Order(shell.comm, self._S_points)
        self._weights = np.polynomial.legendre.leggauss(len(shell.eps))[1]
        self._fields = shell.point_fields

    def sizes(self) -> Sizes:
        """Return the sizes of the wall in the trial state; 0 for those that it lacks."""
        values = [sign * (X + self._w[dofs]) for X, dofs, sign in self._watched]
        if self._shell.growth is not None:
            values.append(self._shell.growth.get())
        largest = np.zeros(5)
        largest[: len(values)] = [np.maximum.reduce(v, axis=None, initial=-np.inf) for v in values]
        if self._shell.comm.size > 1:
            self._shell.comm.Allreduce(dx.MPI.IN_PLACE, largest, op=dx.MPI.MAX)
        below, above, *others = np.where(np.isfinite(largest), largest, 0.0).tolist()
        return Sizes(above + below, *others)

    def size_changes(self, changes: Array) -> Array:
        """Return the changes of pole height, bud and neck radius in µm by those of the state.

        They are those to first order at the nodes where the sizes are largest; 0 for sizes that
        the wall lacks.

        Parameters
        ----------
        changes
            Changes of the DOFs, shape ``(n, DOFs)``.

        Returns
        -------
        Array
            Shape ``(3, n)``.
        """
        largest = np.full(4, -np.inf)
        moved = np.zeros((4, len(changes)))
        for i, (X, dofs, sign) in enumerate(self._watched):
            if len(X):
                values = sign * (X + self._w[dofs])
                node = int(values.argmax())
                largest[i], moved[i] = values[node], sign * changes[:, dofs[node]]
        if self._shell.comm.size > 1:
            everywhere = self._shell.comm.allgather((largest, moved))
            where = np.argmax([each for each, _ in everywhere], axis=0)
            moved = np.array([everywhere[rank][1][i] for i, rank in enumerate(where)])
        return np.stack([moved[0] + moved[1], moved[2], moved[3]])

    def in_contact(self) -> bool:
        """Whether the wall touches itself."""
        shell, motion = self._shell, self._w[self._dofs[:, :2]]
        places = self._nodes.gather(np.column_stack([self._R, self._Z]) + motion)
        found = False
        if places is not None:
            first, last = (end == "pole" for end in shell.discretisation.ends)
            found = touches_itself(places[:, 0], places[:, 1], shell.thickness, (first, last))
        return found if shell.comm.size == 1 else bool(shell.comm.bcast(found))

    def compression(self) -> float:
        """Return the largest `r √N` of a compressive resultant N in µN/µm at radius r in µm.

        It is 0 if the mean Cauchy stress through the wall is nowhere compressive, but for noise.
        """
        shell = self._shell
        fields = self._fields().reshape(len(self._S_points), -1, 3, 2)
        mean = np.einsum("j,ijkl->ikl", self._weights / 2, fields)
        least = mean[:, 1].min(axis=-1)
        slender = (shell.thickness / shell.radius) ** 2
        noise = _NOISE * slender * shell.membrane_stiffness / shell.thickness
        resultant = np.where(least < -noise, -least, 0.0) * shell.thickness
        radius = self._R_points * np.exp(mean[:, 0, 1])
        largest = float((radius * np.sqrt(resultant)).max(initial=0.0))
        return float(shell.comm.allreduce(largest, op=dx.MPI.MAX))

    def strain(self) -> Array:
        """Return total strains, meridional and hoop, at the points of this rank,
        shape ``(points, n, 2)``."""
        return self._fields().reshape(len(self._S_points), -1, 3, 2)[:, :, 0]

    def elastic_strain(self) -> Array:
        """Return elastic strains, meridional and hoop, at the points of this rank,
        shape ``(points, n, 2)``."""
        fields = self._fields().reshape(len(self._S_points), -1, 3, 2)
        return fields[:, :, 0] - fields[:, :, 2]

    def profile(self, time: float) -> Profile | None:
        """Return the profile of the wall at a time in min on rank 0, None on others."""
        shell = self._shell
        motion = shell.w.x.array[self._dofs]
        psi = self._Phi + shell.rotation * motion[:, 2] if shell.bending else self._Phi
        at_nodes = (self._S, self._R + motion[:, 0], self._Z + motion[:, 1], psi)
        nodes = self._nodes.gather(np.column_stack(at_nodes))
        S = self._points.gather(self._S_points)
        fields = self._points.gather(self._fields().reshape(len(self._S_points), -1, 3, 2))
        if nodes is None or S is None or fields is None:
            return None
        eps, sigma, eps_g = (np.ascontiguousarray(fields[:, :, i]) for i in range(3))
        S_nodes, r, z, psi = np.ascontiguousarray(nodes.T)
        if not shell.bending:  # the tangent of the wall, by differences
            psi = np.unwrap(np.arctan2(*(np.gradient(x, S_nodes, edge_order=2) for x in (z, r))))
        return Profile(time, S_nodes, r, z, psi, S, shell.xi, eps, sigma, eps_g)
