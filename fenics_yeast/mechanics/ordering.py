"""The state of a shell in an order that is the same on any number of ranks.

Unknowns are ordered by component and place, what lives at the quadrature points of the growing
cells by place alone.
"""

from __future__ import annotations

from dataclasses import is_dataclass, replace
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from .shell import Shell

Array = NDArray[np.float64]
T = TypeVar("T")

_UNKNOWNS, _POINTS = "unknowns", "points"

# What an array of a frozen dataclass holds, so that its order can be changed.
Unknowns = Annotated[Array, _UNKNOWNS]
"""Local coefficients of the mixed space, ghosts among them; ordered: of all ranks."""
PointValues = Annotated[Array, _POINTS]
"""Values of the local growing cells, in the layout of `GrowthState.get`; ordered: of all ranks."""


class Ordering:
    """The order of the unknowns and growing points of a shell; its methods are collective."""

    def __init__(self, shell: Shell) -> None:
        self._comm = shell.comm
        components, S = dx.unknown_places(shell.space)
        span = 2 * shell.discretisation.curve.length
        dofmap = shell.space.dofmap
        owned = dofmap.index_map.size_local * dofmap.index_map_bs
        cells = shell.growing_elements
        points = shell.quadrature_S[cells]
        mine = cells < shell.mesh.topology.index_map(1).size_local
        self._shape = points.shape
        self._kinds = {
            _UNKNOWNS: _Order(shell.comm, components * span + S, np.arange(len(S)) < owned),
            _POINTS: _Order(shell.comm, points.ravel(), np.repeat(mine, points.shape[1])),
        }

    def ordered(self, record: T) -> T | None:
        """A frozen dataclass with the arrays of all ranks, ordered; None but on rank 0."""
        gathered = self._mapped(record, self._gather)
        return gathered if self._comm.rank == 0 else None

    def local(self, record: T) -> T:
        """The same dataclass with the part of this rank.

        Raises
        ------
        ValueError
            If it is that of another wall.
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
            cells, points = self._shape
            values = values.reshape(cells * points, values.shape[1] // points)
        return self._kinds[kind].gather(values)

    def _scatter(self, kind: str, values: Array) -> Array:
        values = self._kinds[kind].scatter(values)
        if kind == _POINTS:
            cells, points = self._shape
            values = values.reshape(cells, points * values.shape[1])
        return values


class _Order:
    """The order of some things by their keys, which tell them apart on all ranks.

    Parameters
    ----------
    comm
        MPI communicator.
    keys
        Keys of the things of this rank.
    owned
        Which of them no other rank counts as its own.
    """

    def __init__(self, comm: Any, keys: Array, owned: NDArray[np.bool_]) -> None:
        self._comm, self._owned = comm, owned
        everyone = np.concatenate(comm.allgather(keys[owned]))
        self._order = np.argsort(everyone)
        ranked = everyone[self._order]
        # The same place may differ by round-off from rank to rank.
        self._place = np.searchsorted((ranked[1:] + ranked[:-1]) / 2, keys)

    def gather(self, values: Array) -> Array | None:
        parts = self._comm.gather(values[self._owned])
        return None if parts is None else np.concatenate(parts)[self._order]

    def scatter(self, values: Array) -> Array:
        if len(values) != len(self._order):
            raise ValueError(f"{len(self._order)} values are wanted, not {len(values)}")
        return np.ascontiguousarray(values[self._place])


def _kind(hint: Any) -> str | None:
    """What an array with this annotation holds, or the arrays of a tuple."""
    if get_origin(hint) is Annotated:
        return str(hint.__metadata__[0])
    return next(filter(None, map(_kind, get_args(hint))), None)
