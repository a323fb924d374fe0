"""One order of values along the wall, the same on any number of ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Order:
    """The order of local things, such as nodes or elements, by keys such as arc length.

    Parameters
    ----------
    comm
        MPI communicator; construction and all methods are collective.
    keys
        Keys of the local things, unique over all ranks.
    owned
        Which of them this rank owns; by default all.

    Attributes
    ----------
    places
        Index of each local thing in the order.
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
            If their number is not that of all things.
        """
        if len(values) != len(self._order):
            raise ValueError(f"expected {len(self._order)} values, not {len(values)}")
        return np.ascontiguousarray(values[self.places])
