"""Zones of a wall as intervals of its reference meridian."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .curves import Cap, Curve, Sphere
from .supports import Pole

Array = NDArray[np.float64]

_LOOKED_AT = 20_001  # points of a curve at which the polar angle is looked at
NEAR = 1e-9  # of the meridian's length: what lies closer is the same place


@dataclass(frozen=True)
class Interval:
    """A part of the meridian, in µm of arc length."""

    start: float
    end: float

    def holds(self, S: Array) -> NDArray[np.bool_]:
        """Which of some arc lengths lie within it."""
        return (self.start <= S) & (self.end >= S)


Intervals = tuple[Interval, ...]


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


def edges(parts: Iterable[Interval], curve: Curve) -> list[float]:
    """Ends of intervals that lie within a curve, sorted; those at one place as one."""
    near = NEAR * curve.length
    ends = (s for part in parts for s in (part.start, part.end))
    return apart(s for s in ends if near < s < curve.length - near)


def neck(growing: Iterable[Interval], curve: Curve) -> float | None:
    """Edge of what grows, in µm of arc length; None where there is not one alone."""
    found = edges(merged(growing), curve)
    return found[0] if len(found) == 1 else None


def within(parts: Intervals, start: float, end: float) -> Intervals:
    """What of some intervals lies between two arc lengths."""
    cut = (Interval(max(part.start, start), min(part.end, end)) for part in parts)
    return tuple(part for part in cut if part.start < part.end)


def apart(places: Iterable[float]) -> list[float]:
    """Places on the meridian, sorted; those that are one but for round-off as one."""
    found: list[float] = []
    for s in sorted(places):
        if not found or s > found[-1] * (1 + NEAR):
            found.append(s)
    return found
