"""Zones in the tables of a scene: parts of the unloaded wall."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from ..geometry import NEAR, Curve, Interval, Intervals, Poles, polar_extent
from .errors import refusal
from .table import Table
from .units import Angle, Length

_KINDS = (("pole", "half_angle"), ("from", "to"), ("from_fraction", "to_fraction"))
_EXPECTED = "expected either pole and half_angle, from and to, or from_fraction and to_fraction"


class Zone(Table):
    """Part of the unloaded wall.

    It is a polar cap (`pole`, `half_angle`), or lies between two arc lengths from the bottom of
    the meridian (`from`, `to`) or between two fractions of its length (`from_fraction`,
    `to_fraction`).
    """

    start: Length | None = Field(
        default=None,
        ge=0,
        alias="from",
        description="arc length from the bottom to its lower edge (µm)",
    )
    to: Length | None = Field(
        default=None, gt=0, description="arc length from the bottom to its upper edge (µm)"
    )
    pole: Poles | None = Field(default=None, description="pole at its centre")
    half_angle: Angle | None = Field(
        default=None, gt=0, le=180, description="polar angle from the pole to its edge (degrees)"
    )
    from_fraction: float | None = Field(
        default=None, ge=0, le=1, description="fraction of the meridian below its lower edge (1)"
    )
    to_fraction: float | None = Field(
        default=None, ge=0, le=1, description="fraction of the meridian below its upper edge (1)"
    )

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        given = self.model_dump(by_alias=True, exclude_none=True)
        kinds = [kind for kind in _KINDS if any(key in given for key in kind)]
        if not kinds:
            raise refusal(_EXPECTED)
        if len(kinds) > 1:
            raise refusal(_EXPECTED, key=next(key for key in kinds[1] if key in given))
        for key in kinds[0]:
            if key not in given:
                raise refusal(key=key)
        start, end = kinds[0]
        if start != "pole" and given[start] >= given[end]:
            raise refusal(f"must be greater than {start} ({given[start]:g})", key=end)
        return self

    @property
    def parts(self) -> int:
        """Number of connected parts."""
        return 2 if self.pole == "both" else 1

    @property
    def layers(self) -> int:
        """Number of edges inside the wall; those between arc lengths may lie at its ends."""
        return self.parts if self.pole is not None else 2

    def intervals(self, curve: Curve) -> Intervals:
        """Return the parts of a curve that the zone covers; edges near an end are moved to it."""
        length = curve.length
        if self.from_fraction is not None and self.to_fraction is not None:
            found = [(self.from_fraction * length, self.to_fraction * length)]
        elif self.start is not None and self.to is not None:
            found = [(self.start, self.to)]
        else:
            assert self.half_angle is not None
            angle, pole = float(np.deg2rad(self.half_angle)), self.pole
            found = [(0.0, polar_extent(curve, "bottom", angle))] if pole != "top" else []
            found += [(polar_extent(curve, "top", angle), length)] if pole != "bottom" else []
        near = NEAR * length
        return tuple(
            Interval(0.0 if start < near else start, length if abs(end - length) < near else end)
            for start, end in found
        )


def misplaced(zones: Sequence[Zone], curve: Curve) -> tuple[int, str] | None:
    """Return the first zone that leaves the meridian or overlaps another, and what must hold."""
    near = NEAR * curve.length
    placed = [(part, i) for i, zone in enumerate(zones) for part in zone.intervals(curve)]
    for part, i in placed:
        if part.end > curve.length + near:
            return i, beyond(curve.length)
    placed.sort(key=lambda item: item[0].start)
    for (below, i), (above, j) in pairwise(placed):
        if above.start < below.end - near:
            if i == j:
                return i, "its two caps must not overlap; reduce half_angle below 90 degrees"
            both = f"{below.start:.6g} to {below.end:.6g} µm and {above.start:.6g} to"
            return max(i, j), f"zones must not overlap; {both} {above.end:.6g} µm of arc length do"
    return None


def beyond(length: float) -> str:
    """Return what must hold of a place that is not on a meridian of a length in µm."""
    return f"must be at most the meridian's length ({length:.6g} µm)"
