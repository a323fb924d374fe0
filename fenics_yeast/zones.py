"""Zones of a wall as intervals of its reference meridian."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .curves import Cap, Curve, Sphere

if TYPE_CHECKING:
    from ._cell import Pole
    from ._growth import Growth
    from ._zone import Zone

Array = NDArray[np.float64]

_LOOKED_AT = 20_001  # points of a curve at which the polar angle is looked at
_TINY = 1e-9  # of the meridian's length: what lies closer is the same place


@dataclass(frozen=True)
class Interval:
    """A part of the meridian, in µm of arc length."""

    start: float
    end: float

    def holds(self, S: Array) -> NDArray[np.bool_]:
        """Which of some arc lengths lie within it."""
        return (self.start <= S) & (self.end >= S)


Intervals = tuple[Interval, ...]


def intervals(zone: Zone, curve: Curve) -> Intervals:
    """Parts of a curve that a zone covers; edges next to an end of the curve are at its end."""
    length = curve.length
    if zone.from_fraction is not None and zone.to_fraction is not None:
        found = [(zone.from_fraction * length, zone.to_fraction * length)]
    elif zone.half_angle is not None:
        angle, pole = float(np.deg2rad(zone.half_angle)), zone.pole
        found = [(0.0, polar_extent(curve, "bottom", angle))] if pole != "top" else []
        found += [(polar_extent(curve, "top", angle), length)] if pole != "bottom" else []
    else:
        found = [(getattr(zone, "from"), zone.to)]
    near = _TINY * length
    return tuple(
        Interval(0.0 if start < near else start, length if abs(end - length) < near else end)
        for start, end in found
    )


def polar_extent(curve: Curve, pole: Pole, half_angle: float) -> float:
    """Arc length in µm at which a polar cap ends.

    The angle in radians is seen from the middle of the axis, between the poles; for a part of a
    sphere, from its centre.
    """
    if isinstance(curve, Sphere | Cap):
        extent = min(half_angle * curve.R0, curve.length)
        return extent if pole == "bottom" else curve.length - extent
    S = np.linspace(0, curve.length, _LOOKED_AT)
    Z = curve.height(S)
    angle = np.arctan2(curve.radius(S), (Z[-1] + Z[0]) / 2 - Z)  # from below
    if pole == "top":
        angle, S = np.pi - angle[::-1], S[::-1]
    first = int(np.argmax(angle >= half_angle - 1e-12)) or len(S) - 1
    part = (half_angle - angle[first - 1]) / (angle[first] - angle[first - 1])
    return float(S[first - 1] + min(part, 1.0) * (S[first] - S[first - 1]))


def merged(parts: Iterable[Interval]) -> Intervals:
    """The same places as one interval for each connected piece, bottom to top."""
    pieces: list[Interval] = []
    for part in sorted(parts, key=lambda part: part.start):
        if pieces and part.start <= pieces[-1].end:
            pieces[-1] = Interval(pieces[-1].start, max(pieces[-1].end, part.end))
        else:
            pieces.append(part)
    return tuple(pieces)


def misplaced(zones: Sequence[Zone], curve: Curve) -> tuple[int, str] | None:
    """First zone that leaves the meridian or overlaps another, and what would be allowed."""
    near = _TINY * curve.length
    placed = [(part, i) for i, zone in enumerate(zones) for part in intervals(zone, curve)]
    for part, i in placed:
        if part.end > curve.length + near:
            return i, f"the meridian ends at {curve.length:.6g} µm"
    placed.sort(key=lambda item: item[0].start)
    for (below, i), (above, j) in pairwise(placed):
        if above.start < below.end - near:
            both = f"{below.start:.6g} to {below.end:.6g} µm and {above.start:.6g} to"
            return max(i, j), f"zones must not overlap; {both} {above.end:.6g} µm of arc length do"
    return None


def edges(parts: Iterable[Interval], curve: Curve) -> list[float]:
    """Ends of intervals that lie within a curve, sorted; those at one place as one."""
    near = _TINY * curve.length
    ends = (s for part in parts for s in (part.start, part.end))
    return apart(s for s in ends if near < s < curve.length - near)


def neck(growing: Iterable[Growth], curve: Curve) -> float | None:
    """Edge of what grows, in µm of arc length; None where there is not one alone."""
    parts = merged(part for growth in growing for part in intervals(growth.zone, curve))
    found = edges(parts, curve)
    return found[0] if len(found) == 1 else None


def within(parts: Intervals, start: float, end: float) -> Intervals:
    """What of some intervals lies between two arc lengths."""
    cut = (Interval(max(part.start, start), min(part.end, end)) for part in parts)
    return tuple(part for part in cut if part.start < part.end)


def apart(places: Iterable[float]) -> list[float]:
    """Places on the meridian, sorted; those that are one but for round-off as one."""
    found: list[float] = []
    for s in sorted(places):
        if not found or s > found[-1] * (1 + _TINY):
            found.append(s)
    return found
