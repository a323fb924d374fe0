"""A mesh of the meridian: its nodes, what they delimit, and where they are placed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .curves import Array, Curve
from .intervals import Intervals, merged
from .supports import End


@dataclass(frozen=True)
class Discretisation:
    """A meridian divided into elements.

    Attributes
    ----------
    curve
        Reference meridian.
    nodes
        Arc length of the nodes in µm, increasing, shape ``(n + 1,)``.
    zones, wall_zones
        Intervals of each growing zone and of each zone of the wall; their ends are nodes.
    ends
        What the lower and the upper end are: a pole, a free edge, or the support of an edge.
    loaded
        Arc length in µm of the node at which a force acts; None without a force.
    counts
        Numbers of elements between places that must be nodes, from the lower end; with a septum,
        of both pieces.
    """

    curve: Curve
    nodes: Array
    zones: tuple[Intervals, ...] = ()
    ends: tuple[End, End] = ("pole", "pole")
    wall_zones: tuple[Intervals, ...] = ()
    loaded: float | None = None
    counts: tuple[int, ...] = ()

    @property
    def ends_at(self) -> tuple[float, float]:
        """Arc length of the lower and the upper end in µm."""
        return float(self.nodes[0]), float(self.nodes[-1])

    @property
    def growing(self) -> Intervals:
        """Union of the growing zones, one interval for each connected part."""
        return merged(part for parts in self.zones for part in parts)


def place_nodes(
    length: float,
    fixed: Sequence[float],
    elements: int,
    density: Callable[[Array], Array],
    counts: Sequence[int] = (),
) -> tuple[Array, tuple[int, ...]]:
    """Place the nodes of a given number of elements by a density, some of them at fixed places.

    Parameters
    ----------
    length
        Length of the meridian in µm.
    fixed
        Arc lengths in µm inside it that must be nodes.
    elements
        Number of elements; at least one lies between two fixed places.
    density
        Relative number of elements per length at arc lengths, positive.
    counts
        Numbers of elements between the fixed places; by default those nearest to the density.

    Returns
    -------
    Array
        Increasing arc lengths in µm, shape ``(elements + 1,)``.
    tuple of int
        The numbers of elements between the fixed places.

    Raises
    ------
    ValueError
        If there are not as many counts as parts between the fixed places.
    """
    ends = np.array([0.0, *sorted(fixed), length])
    parts = []
    for start, end in pairwise(ends):
        S = np.linspace(start, end, 2001)
        rho = density((S[1:] + S[:-1]) / 2) * np.diff(S)
        parts.append((S, np.concatenate([[0.0], np.cumsum(rho)])))
    if not counts:
        shares = np.array([total[-1] for _, total in parts])
        counts = _apportion(shares, max(elements, len(parts))).tolist()
    if len(counts) != len(parts):
        raise ValueError(f"{len(counts)} numbers of elements for {len(parts)} parts")
    nodes = [np.interp(np.linspace(0, total[-1], n + 1)[:-1], total, S)
             for n, (S, total) in zip(counts, parts, strict=True)]  # fmt: skip
    return np.concatenate([*nodes, [length]]), tuple(counts)


def _apportion(shares: Array, total: int) -> NDArray[np.int64]:
    """Return integers of a given sum, at least 1 each, nearest in proportion to the shares."""
    counts = np.ones(len(shares), dtype=np.int64)
    while counts.sum() < total:
        counts[np.argmax(shares / (counts + 0.5))] += 1
    return counts
