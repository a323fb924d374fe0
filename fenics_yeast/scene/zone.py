"""Zones in the tables of a scene: parts of the unloaded wall."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, create_model, model_validator

from ..geometry import NEAR, Curve, Interval, Intervals, polar_extent
from .errors import refusal
from .table import Table
from .units import Angle, Length

_KINDS = (("pole", "half_angle"), ("from", "to"), ("from_fraction", "to_fraction"))
_WANTED = "either pole and half_angle, from and to, or from_fraction and to_fraction are wanted"

# `from` is a word of Python's own, which no class body may define.
_Stretch: Any = create_model(
    "_Stretch",
    __base__=Table,
    **{  # type: ignore[call-overload]
        "from": (
            Length | None,
            Field(default=None, ge=0, description="arc length at its lower edge (µm)"),
        ),
        "to": (
            Length | None,
            Field(default=None, gt=0, description="arc length at its upper edge (µm)"),
        ),
    },
)


class Zone(_Stretch):
    """A part of the unloaded wall.

    It is a polar cap (`pole`, `half_angle`), or what lies between two arc lengths from the bottom
    of the meridian (`from`, `to`) or between two fractions of its length (`from_fraction`,
    `to_fraction`).
    """

    pole: Literal["top", "bottom", "both"] | None = Field(
        default=None, description="pole around which it lies"
    )
    half_angle: Angle | None = Field(
        default=None, gt=0, le=180, description="polar angle from the pole to its edge (degrees)"
    )
    from_fraction: float | None = Field(
        default=None, ge=0, le=1, description="part of the meridian below it (1)"
    )
    to_fraction: float | None = Field(
        default=None, ge=0, le=1, description="part of the meridian up to its upper edge (1)"
    )

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        given = [kind for kind in _KINDS if any(getattr(self, key) is not None for key in kind)]
        if not given:
            raise refusal("", allowed=_WANTED)
        if len(given) > 1:
            key = next(key for key in given[1] if getattr(self, key) is not None)
            raise refusal("", allowed=_WANTED, key=key)
        for key in given[0]:
            if getattr(self, key) is None:
                raise refusal("", key=key)
        start, end = given[0]
        if start != "pole" and getattr(self, start) >= getattr(self, end):
            allowed = f"more than {start} ({getattr(self, start):g}) is wanted"
            raise refusal("", allowed=allowed, key=end)
        return self

    @property
    def parts(self) -> int:
        """Number of connected parts."""
        return 2 if self.pole == "both" else 1

    @property
    def layers(self) -> int:
        """Number of edges within the wall; those of a stretch may lie at its ends."""
        return self.parts if self.pole is not None else 2

    def intervals(self, curve: Curve) -> Intervals:
        """Parts of a curve that the zone covers; an edge next to an end of the curve is at it."""
        length = curve.length
        if self.from_fraction is not None and self.to_fraction is not None:
            found = [(self.from_fraction * length, self.to_fraction * length)]
        elif self.half_angle is not None:
            angle, pole = float(np.deg2rad(self.half_angle)), self.pole
            found = [(0.0, polar_extent(curve, "bottom", angle))] if pole != "top" else []
            found += [(polar_extent(curve, "top", angle), length)] if pole != "bottom" else []
        else:
            found = [(getattr(self, "from"), self.to)]
        near = NEAR * length
        return tuple(
            Interval(0.0 if start < near else start, length if abs(end - length) < near else end)
            for start, end in found
        )


def misplaced(zones: Sequence[Zone], curve: Curve) -> tuple[int, str] | None:
    """First zone that leaves the meridian or overlaps another, and what would be allowed."""
    near = NEAR * curve.length
    placed = [(part, i) for i, zone in enumerate(zones) for part in zone.intervals(curve)]
    for part, i in placed:
        if part.end > curve.length + near:
            return i, f"the meridian ends at {curve.length:.6g} µm"
    placed.sort(key=lambda item: item[0].start)
    for (below, i), (above, j) in pairwise(placed):
        if above.start < below.end - near:
            both = f"{below.start:.6g} to {below.end:.6g} µm and {above.start:.6g} to"
            return max(i, j), f"zones must not overlap; {both} {above.end:.6g} µm of arc length do"
    return None
