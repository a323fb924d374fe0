"""The state of a shell in an order that is the same on any number of ranks.

DOFs are ordered by component and arc length, values at growing points by arc length.
"""

from __future__ import annotations

from dataclasses import is_dataclass, replace
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from .gather import Order
from .shell import Shell

Array = NDArray[np.float64]
T = TypeVar("T")

_DOFS, _POINTS = "dofs", "points"

# Annotations of arrays in frozen dataclasses, by which they are ordered.
DofValues = Annotated[Array, _DOFS]
"""Local coefficients of the mixed space, ghosts among them; ordered: of all ranks."""
PointValues = Annotated[Array, _POINTS]
"""Values of the local growing elements, shaped like `GrowthState.get`; ordered: of all ranks."""


class Ordering:
    """The order of the DOFs and growing points of a shell; its methods are collective."""

    def __init__(self, shell: Shell) -> None:
        self._comm = shell.comm
        components, S = dx.dof_places(shell.space)
        span = 2 * shell.discretisation.curve.length
        dofmap = shell.space.dofmap
        owned = dofmap.index_map.size_local * dofmap.index_map_bs
        elements = shell.growing_elements
        points = shell.quadrature_S[elements]
        mine = elements < shell.mesh.topology.index_map(1).size_local
        self._shape = points.shape
        self._kinds = {
            _DOFS: Order(shell.comm, components * span + S, np.arange(len(S)) < owned),
            _POINTS: Order(shell.comm, points.ravel(), np.repeat(mine, points.shape[1])),
        }

    def ordered(self, record: T) -> T | None:
        """Return a dataclass with the ordered arrays of all ranks on rank 0, None on others."""
        gathered = self._mapped(record, self._gather)
        return gathered if self._comm.rank == 0 else None

    def local(self, record: T) -> T:
        """Return an ordered dataclass with the arrays of this rank.

        Raises
        ------
        ValueError
            If it belongs to another wall.
        """
        return self._mapped(record, self._scatter)

    def _mapped(self, record: T, change: Any) -> T:
        """Apply a change to every array that is annotated as one of a kind, at any depth."""
        changes: dict[str, Any] = {}
        for name, hint in get_type_hints(type(record), include_extras=True).items():
            value, kind = getattr(record, name), _kind(hint)
            if is_dataclass(value):
                changes[name] = self._mapped(value, change)
            elif kind is None or value is None:
                continue
            elif isinstance(value, tuple):
                changes[name] = tuple(change(kind, array) for array in value)
            else:
                changes[name] = change(kind, value)
        return replace(record, **changes)  # type: ignore[type-var]

    def _gather(self, kind: str, values: Array) -> Array | None:
        if kind == _POINTS:
            elements, points = self._shape
            values = values.reshape(elements * points, values.shape[1] // points)
        return self._kinds[kind].gather(values)

    def _scatter(self, kind: str, values: Array) -> Array:
        values = self._kinds[kind].scatter(values)
        if kind == _POINTS:
            elements, points = self._shape
            values = values.reshape(elements, points * values.shape[1])
        return values


def _kind(hint: Any) -> str | None:
    """Return the kind of an annotated array, or of the arrays of a tuple."""
    if get_origin(hint) is Annotated:
        return str(hint.__metadata__[0])
    return next(filter(None, map(_kind, get_args(hint))), None)
