"""A meridian cut into cells, with some places fixed and a wanted density elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .curves import Curve
from .intervals import Intervals, merged
from .supports import End

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Discretisation:
    """A meridian cut into cells.

    Attributes
    ----------
    curve
        The reference meridian.
    nodes
        Arc length of the cells' ends in µm, increasing, shape ``(n + 1,)``.
    zones
        Parts of the meridian that each growing zone of the scene covers, their ends among the
        nodes; empty where nothing grows.
    ends
        What the lower and the upper end are: a pole, a free edge, or how an edge is held.
    wall_zones
        Parts that each zone of the wall covers, as `zones`.
    loaded
        Node at which a force acts, in µm of arc length; None where none does.
    """

    curve: Curve
    nodes: Array
    zones: tuple[Intervals, ...] = ()
    ends: tuple[End, End] = ("pole", "pole")
    wall_zones: tuple[Intervals, ...] = ()
    loaded: float | None = None

    @property
    def ends_at(self) -> tuple[float, float]:
        """Arc length of the lower and the upper end in µm."""
        return float(self.nodes[0]), float(self.nodes[-1])

    @property
    def growing(self) -> Intervals:
        """What grows, one interval for each connected piece."""
        return merged(part for parts in self.zones for part in parts)


def place_nodes(
    length: float, fixed: Sequence[float], elements: int, density: Callable[[Array], Array]
) -> Array:
    """Nodes of a given number of cells, with some places fixed and a wanted density elsewhere.

    Parameters
    ----------
    length
        Length of the meridian in µm.
    fixed
        Arc lengths within it that must be nodes.
    elements
        Number of cells; at least one lies between two fixed places.
    density
        Relative number of cells per length, positive.

    Returns
    -------
    Array
        Increasing arc lengths, shape ``(elements + 1,)``.
    """
    ends = np.array([0.0, *sorted(fixed), length])
    parts = []
    for start, end in pairwise(ends):
        S = np.linspace(start, end, 2001)
        rho = density((S[1:] + S[:-1]) / 2) * np.diff(S)
        parts.append((S, np.concatenate([[0.0], np.cumsum(rho)])))
    counts = _apportion(np.array([total[-1] for _, total in parts]), max(elements, len(parts)))
    nodes = [np.interp(np.linspace(0, total[-1], n + 1)[:-1], total, S)
             for n, (S, total) in zip(counts, parts, strict=True)]  # fmt: skip
    return np.concatenate([*nodes, [length]])


def _apportion(shares: Array, total: int) -> NDArray[np.int64]:
    """Whole numbers of a given sum, at least one each, nearest in proportion to the shares."""
    counts = np.ones(len(shares), dtype=np.int64)
    while counts.sum() < total:
        counts[np.argmax(shares / (counts + 0.5))] += 1
    return counts
