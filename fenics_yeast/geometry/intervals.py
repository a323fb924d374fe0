"""Zones of a wall as intervals of its reference meridian."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .curves import NEAR, Array, Cap, Curve, Sphere
from .supports import Pole

_SAMPLES = 401  # points of a curve at which the polar angle is evaluated, once more between two


@dataclass(frozen=True)
class Interval:
    """A part of the meridian, in µm of arc length."""

    start: float
    end: float

    def holds(self, S: Array) -> NDArray[np.bool_]:
        """Return which arc lengths lie within the interval."""
        return (self.start <= S) & (self.end >= S)


Intervals = tuple[Interval, ...]


def polar_extent(curve: Curve, pole: Pole, half_angle: float) -> float:
    """Return the arc length in µm at which a polar cap ends.

    The angle in radians is measured at the middle of the axis, between the poles; for a part of a
    sphere, at its centre.
    """
    if isinstance(curve, Sphere | Cap):
        extent = min(half_angle * curve.R0, curve.length)
        return extent if pole == "bottom" else curve.length - extent
    middle = float(curve.height(np.array([0.0, curve.length])).mean())
    begin, end = (0.0, curve.length) if pole == "bottom" else (curve.length, 0.0)
    sign = 1.0 if pole == "bottom" else -1.0
    for _ in range(2):
        S = np.linspace(begin, end, _SAMPLES)
        angle = np.arctan2(curve.radius(S), sign * (middle - curve.height(S)))
        first = int(np.argmax(angle >= half_angle - 1e-12)) or _SAMPLES - 1
        begin, end = float(S[first - 1]), float(S[first])
    part = (half_angle - angle[first - 1]) / (angle[first] - angle[first - 1])
    return begin + min(float(part), 1.0) * (end - begin)


def merged(parts: Iterable[Interval]) -> Intervals:
    """Return the union of intervals, one for each connected part, from bottom to top."""
    union: list[Interval] = []
    for part in sorted(parts, key=lambda part: part.start):
        if union and part.start <= union[-1].end:
            union[-1] = Interval(union[-1].start, max(union[-1].end, part.end))
        else:
            union.append(part)
    return tuple(union)


def edges(parts: Iterable[Interval], curve: Curve) -> list[float]:
    """Return the ends of intervals that lie inside a curve, sorted, coincident ones once."""
    near = NEAR * curve.length
    ends = (s for part in parts for s in (part.start, part.end))
    return apart(s for s in ends if near < s < curve.length - near)


def neck(growing: Iterable[Interval], curve: Curve) -> float | None:
    """Return the arc length in µm of the only edge of the growing zones; None if not unique."""
    found = edges(merged(growing), curve)
    return found[0] if len(found) == 1 else None


def within(parts: Intervals, start: float, end: float) -> Intervals:
    """Clip intervals to those parts that lie between two arc lengths."""
    clipped = (Interval(max(part.start, start), min(part.end, end)) for part in parts)
    return tuple(part for part in clipped if part.start < part.end)


def apart(places: Iterable[float]) -> list[float]:
    """Sort arc lengths; of those that differ only by round-off, keep the first."""
    found: list[float] = []
    for s in sorted(places):
        if not found or s > found[-1] * (1 + NEAR):
            found.append(s)
    return found
