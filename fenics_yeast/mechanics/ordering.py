"""Values along the wall in an order that is the same on any number of ranks.

DOFs are ordered by component and arc length, values at growing points by arc length.
"""

from dataclasses import is_dataclass, replace
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Array
from .quadrature import QuadraturePoints

T = TypeVar("T")

_DOFS, _POINTS = "dofs", "points"

# Annotations of arrays in frozen dataclasses, by which they are ordered.
DofValues = Annotated[Array, _DOFS]
"""Local coefficients of the wall's space, ghosts among them; ordered: of all ranks."""
PointValues = Annotated[Array, _POINTS]
"""Values of the local growing elements, shaped like `GrowthState.get`; ordered: of all ranks."""


class Order:
    """The order of local items, such as nodes or elements, by keys such as arc length.

    Parameters
    ----------
    comm
        MPI communicator; construction and all methods are collective.
    keys
        Keys of the local items, unique over all ranks, shape ``(items,)``.
    owned
        Which of them this rank owns; by default all.

    Attributes
    ----------
    places
        Index of each local item in the order.
    """

    def __init__(self, comm: Any, keys: Array, owned: NDArray[np.bool_] | None = None) -> None:
        self._comm = comm
        self._owned = np.ones(len(keys), dtype=bool) if owned is None else owned
        everyone = np.concatenate(comm.allgather(keys[self._owned]))
        self._order = np.argsort(everyone)
        ranked = everyone[self._order]
        # The same key may differ by round-off from rank to rank.
        self.places = np.searchsorted((ranked[1:] + ranked[:-1]) / 2, keys)

    def gather(self, values: NDArray[Any]) -> NDArray[Any] | None:
        """Return the ordered values of all ranks on rank 0, None on others."""
        if self._comm.size == 1:
            return values[self._order]
        parts = self._comm.gather(values[self._owned])
        return None if parts is None else np.concatenate(parts)[self._order]

    def allgather(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the ordered values of all ranks."""
        return np.concatenate(self._comm.allgather(values[self._owned]))[self._order]

    def scatter(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the local part of ordered values.

        Raises
        ------
        ValueError
            If their number differs from that of all items.
        """
        if len(values) != len(self._order):
            raise ValueError(f"expected {len(self._order)} values, not {len(values)}")
        return np.ascontiguousarray(values[self.places])


class Ordering:
    """The order of a wall's DOFs and growing points; its methods are collective.

    Parameters
    ----------
    space, growing
        Space of the wall's state; quadrature points of the growing elements.
    """

    def __init__(self, space: Any, growing: QuadraturePoints) -> None:
        self._comm = comm = space.mesh.comm
        components, S = dx.dof_places(space)
        span = 2 * comm.allreduce(S.max(initial=0.0), op=dx.MPI.MAX)
        dofmap = space.dofmap
        owned = dofmap.index_map.size_local * dofmap.index_map_bs
        self._shape = growing.S.shape
        self._kinds = {
            _DOFS: Order(comm, components * span + S, np.arange(len(S)) < owned),
            _POINTS: Order(comm, growing.S.ravel(), np.repeat(growing.owned, self._shape[1])),
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
