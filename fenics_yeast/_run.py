"""The tables `[run]` and `[path]` of a scene: a span of time, or a path of equilibria."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from fenics_yeast._quantities import Pressure, Time, refusal
from fenics_yeast._table import Table


class Run(Table):
    """The time span of a simulation and the times whose profiles are kept."""

    end: Time = Field(gt=0, description="end of the simulation (min)")
    save: Annotated[tuple[Time, ...], Field(strict=False)] = Field(
        default_factory=lambda given: (given["end"],),
        description="times hit exactly and kept, sorted; left out: the end alone (min)",
    )

    @field_validator("save")
    @classmethod
    def _within_the_run(cls, times: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        if not times:
            raise refusal("", allowed="at least one time is wanted; left out, the end is saved")
        end = info.data.get("end", float("inf"))
        for time in times:
            if not 0 <= time <= end:
                allowed = f"saved times lie from 0 to run.end ({end:g} min)"
                raise refusal(f"{time:g} min is outside the run", allowed=allowed)
        return tuple(sorted(set(times)))


Control = Literal["pressure", "volume", "arc-length"]


class Until(Table):
    """Where a path ends: at a volume ratio or at a pressure."""

    volume_ratio: float | None = Field(default=None, gt=0, description="V/V0 (1)")
    pressure: Pressure | None = Field(default=None, description="pressure (MPa)")

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if (self.volume_ratio is None) == (self.pressure is None):
            allowed = 'either volume_ratio or pressure is wanted, e.g. { pressure = "1 MPa" }'
            raise refusal("", allowed=allowed)
        if self.volume_ratio == 1 or self.pressure == 0:
            raise refusal("", allowed="a path ends elsewhere than it begins, V/V0 = 1 without load")
        return self


class StaticPath(Table):
    """The equilibria of an elastic wall from the unloaded one on, over limit points too."""

    control: Control = Field(default="volume", description="what is prescribed at each point")
    until: Until = Field(description="where the path ends")
    steps: int = Field(
        default=60, ge=1, le=100_000, description="number of steps; cut where they fail"
    )
