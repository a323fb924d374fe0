"""A dead axial force at a node of the meridian."""

from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import NEAR, Array


class NodalForce:
    """An axial force at a node, with the potential `-F u_z / 2π`.

    Parameters
    ----------
    w, comm
        Trial state of the wall and the MPI communicator that shares it.
    S, scale
        Arc length of the node and a small displacement, in µm.

    Attributes
    ----------
    value
        The force `F` in µN, positive towards the top.
    """

    def __init__(self, w: Any, comm: Any, S: float, scale: float) -> None:
        places, dofs = dx.node_dofs(w.function_space)
        here = np.abs(places - S) < NEAR * S
        self._dofs, self._comm = dofs[here, 1], comm  # empty on ranks that do not own the node
        self._w = w.x.array
        self.value = self._origin = 0.0
        self.scale = scale

    def add_to(self, residual: Array) -> None:
        """Add the force to the residual of the owned DOFs."""
        residual[self._dofs] -= self.value / (2 * np.pi)

    def direction(self, out: Array) -> None:
        """Write the derivative of the displacement by the owned DOFs."""
        out[:] = 0
        out[self._dofs] = 1

    def displacement(self) -> float:
        """Return the displacement of the node in µm since `begin`, in the trial state."""
        place = self._comm.allreduce(self._w[self._dofs].sum(), op=dx.MPI.SUM)
        return float(place) - self._origin

    def begin(self) -> None:
        """Measure displacements from the trial state."""
        self._origin = 0.0
        self._origin = self.displacement()
