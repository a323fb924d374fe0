"""The table `[turgor]` of a scene: the pressure inside the cell, and how it changes in time."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated

from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator

from .errors import BRANCH, refusal
from .table import Table
from .units import Pressure, Time


class PressureTable(Table):
    """Pressure that changes in time: linear from value to value, held before and after them."""

    time: Annotated[tuple[Time, ...], Field(strict=False)] = Field(
        description="increasing times from 0 on (min)"
    )
    value: Annotated[tuple[Pressure, ...], Field(strict=False)] = Field(
        description="pressure at each of the times (MPa)"
    )

    @field_validator("time")
    @classmethod
    def _increasing(cls, times: tuple[float, ...]) -> tuple[float, ...]:
        if not times or times[0] < 0 or any(a >= b for a, b in pairwise(times)):
            raise refusal("", allowed="increasing times from 0 on are wanted, e.g. [0, 30, 40]")
        return times

    @field_validator("value")
    @classmethod
    def _one_for_each_time(
        cls, values: tuple[float, ...], info: ValidationInfo
    ) -> tuple[float, ...]:
        times = info.data.get("time")
        if times is not None and len(values) != len(times):
            raise refusal("", allowed=f"a pressure for each of the {len(times)} times is wanted")
        return values


def _number_or_table(value: object) -> str:
    return f"{BRANCH}table" if isinstance(value, Mapping | PressureTable) else f"{BRANCH}number"


class Turgor(Table):
    """The pressure inside the cell: it rises linearly from 0 over the ramp and is then held.

    Given as a table it changes in time; its first rise is still that of the ramp. A scene with a
    `path` finds its own pressures.
    """

    pressure: Annotated[
        Annotated[Pressure, Tag(f"{BRANCH}number")]
        | Annotated[PressureTable, Tag(f"{BRANCH}table")],
        Discriminator(_number_or_table),
    ] = Field(description="turgor pressure, negative from outside, or a table of it (MPa)")
    ramp: Time = Field(default=0.01, ge=0, description="duration of the rise from 0 (min)")
