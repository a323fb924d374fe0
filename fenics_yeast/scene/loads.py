"""The tables `[turgor]`, `[load]` and `[septum]`: what acts on the wall, and where it separates."""

from collections.abc import Mapping
from itertools import pairwise
from math import inf
from typing import Annotated, Self

from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator, model_validator

from ..geometry import Pole
from .errors import BRANCH, refusal
from .table import ListOf, Table
from .units import Force, Length, Pressure, Time

_JUMP = 1e-6  # duration of a jump of the pressure, as a part of its time, in which nothing grows


class PressureTable(Table):
    """Pressure as a function of time: piecewise linear, constant outside the given times.

    Two equal times are a jump, from the first to the second of their values.
    """

    time: ListOf[Time] = Field(description="times in order; two equal ones are a jump (min)")
    value: ListOf[Pressure] = Field(description="pressure at each of the times (MPa)")

    @field_validator("time")
    @classmethod
    def _increasing(cls, times: tuple[float, ...]) -> tuple[float, ...]:
        if not times or times[0] < 0 or any(a > b for a, b in pairwise(times)):
            raise refusal("expected times >= 0 in order, e.g. [0, 30, 40]")
        if any(a == c for a, c in zip(times, times[2:], strict=False)):
            raise refusal("expected at most two equal times, which are a jump")
        return times

    @field_validator("value")
    @classmethod
    def _one_per_time(cls, values: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        times = info.data.get("time")
        if times is not None and len(values) != len(times):
            raise refusal(f"expected {len(times)} pressures, one per time")
        return values

    @property
    def ramps(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times in min and pressures in MPa, with a very short ramp in place of each jump."""
        times = list(self.time)
        for i, (before, after) in enumerate(pairwise(self.time)):
            if before == after:
                following = min((t for t in self.time if t > after), default=inf)
                times[i + 1] += min(_JUMP * max(1.0, after), (following - after) / 2)
        return tuple(times), self.value


def _number_or_table(value: object) -> str:
    return f"{BRANCH}table" if isinstance(value, Mapping | PressureTable) else f"{BRANCH}number"


class Turgor(Table):
    """Turgor pressure: a linear rise from 0 during the ramp, then constant or as in a table.

    A scene with a `path` to a volume or pressure determines its own pressures.
    """

    pressure: Annotated[
        Annotated[Pressure, Tag(f"{BRANCH}number")]
        | Annotated[PressureTable, Tag(f"{BRANCH}table")],
        Discriminator(_number_or_table),
    ] = Field(description="turgor: internal minus external pressure, or a table of it (MPa)")
    ramp: Time = Field(default=0.01, ge=0, description="duration of the rise from 0 (min)")

    @property
    def initial(self) -> float:
        """Pressure at the start, after its rise (MPa)."""
        pressure = self.pressure
        return pressure.value[0] if isinstance(pressure, PressureTable) else pressure


class Load(Table):
    """Dead force along the axis, at a pole or around a ring.

    A closed cell rests on the opposite pole, or for a ring on the lower one; every other shape
    rests on its edge.
    """

    point_force: Force | None = Field(
        default=None, description="force at a pole, positive outward, negative to indent (µN)"
    )
    pole: Pole = Field(default="top", description="pole at which the point force acts")
    ring_force: Force | None = Field(
        default=None, description="total force on a ring, positive towards the top (µN)"
    )
    at: Length | None = Field(
        default=None,
        gt=0,
        description="arc length from the bottom to the ring (µm); default: a free upper edge",
    )

    @model_validator(mode="after")
    def _one_force(self) -> Self:
        if (self.point_force is None) == (self.ring_force is None):
            raise refusal("expected either point_force or ring_force")
        if self.ring_force is None and self.at is not None:
            raise refusal("a point force acts at a pole; remove at, or set ring_force", key="at")
        return self

    @property
    def force(self) -> float:
        """The force (µN)."""
        return (self.ring_force if self.point_force is None else self.point_force) or 0.0


class Septum(Table):
    """Rigid disc across the cell, at which it separates into a mother and a daughter cell.

    A scene without `piece` is the whole cell, with a node at the future septum. With `piece` it is
    the part on one side, closed by the septum.
    """

    at: Length | None = Field(
        default=None,
        gt=0,
        description="arc length from the bottom to its edge (µm); default: the bud neck",
    )
    piece: Pole | None = Field(
        default=None, description="side of the septum to simulate; default: the whole cell"
    )
