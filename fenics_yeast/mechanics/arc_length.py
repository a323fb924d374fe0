"""Arc length along the current wall."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx

Array = NDArray[np.float64]


class ArcLength:
    """Arc length of the current meridian at the quadrature points.

    Parameters
    ----------
    mesh
        Interval mesh of the wall.
    degree
        Degree of its quadrature rule.
    stretch
        Stretch of the meridian, a scalar in UFL.
    """

    def __init__(self, mesh: Any, degree: int, stretch: Any) -> None:
        self._mesh = mesh
        ends = mesh.geometry.x[dx.element_vertices(mesh), 0]
        self._start, self._length = ends.min(axis=1), np.ptp(ends, axis=1)
        index_map = mesh.topology.index_map(1)
        self._owned = index_map.size_local
        self._cells = np.arange(self._owned + index_map.num_ghosts, dtype=np.int32)
        places = dx.quadrature_points(degree)
        self._stretch = dx.compile_expression(stretch, places)
        # Of the polynomial through the points: integrals from a cell's start to each of them,
        # and over the whole cell. Cells point upward, as the mesh does.
        powers = np.arange(1, len(places) + 1)
        coefficients = np.linalg.inv(places ** (powers - 1))
        self._up_to = places**powers / powers @ coefficients
        self._whole = 1 / powers @ coefficients

    def at_points(self) -> tuple[Array, float]:
        """Arc length from the bottom at the points of the local cells, and the whole length, µm.

        The shape of the first is ``(cells, points)``; collective.
        """
        stretch = dx.evaluate(self._stretch, self._mesh, self._cells)
        lengths = self._length * (stretch @ self._whole)
        owned = slice(self._owned)
        parts = self._mesh.comm.allgather((self._start[owned], lengths[owned]))
        start, length = (np.concatenate(pieces) for pieces in zip(*parts, strict=True))
        order = np.argsort(start)
        total = np.cumsum(length[order])
        below = total - length[order]
        first = below[np.searchsorted(start[order], self._start)]
        inside = self._length[:, None] * (stretch @ self._up_to.T)
        return first[:, None] + inside, float(total[-1])
