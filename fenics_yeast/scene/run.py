"""The tables `[run]` and `[path]` of a scene: a span of time, or a path of equilibria."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from .errors import refusal
from .table import Table
from .units import Force, Length, Pressure, Time


class Run(Table):
    """The time span of a simulation and the times whose profiles are kept."""

    end: Time = Field(gt=0, description="end of the simulation (min)")
    save: Annotated[tuple[Time, ...], Field(strict=False)] = Field(
        default_factory=lambda given: (given.get("end", 0.0),),
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


Control = Literal["pressure", "volume", "arc-length", "force", "displacement"]


class Until(Table):
    """Where a path ends: at a volume ratio or pressure, or at a displacement or force of a load."""

    volume_ratio: float | None = Field(
        default=None, description="V/V0; of a flat disc, in half spheres on its edge (1)"
    )
    pressure: Pressure | None = Field(default=None, description="pressure (MPa)")
    displacement: Length | None = Field(
        default=None,
        description="displacement of the load from where it begins, signed as its force (µm)",
    )
    force: Force | None = Field(default=None, description="force of the load (µN)")

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        ends = (self.volume_ratio, self.pressure, self.displacement, self.force)
        if sum(end is not None for end in ends) != 1:
            allowed = (
                "one of volume_ratio, pressure, displacement, force is wanted, e.g. "
                '{ pressure = "1 MPa" }'
            )
            raise refusal("", allowed=allowed)
        if self.volume_ratio == 1 or 0 in ends[1:]:
            raise refusal("", allowed="a path ends elsewhere than it begins, V/V0 = 1 without load")
        return self

    @property
    def of_load(self) -> bool:
        """Whether the path is one of the force of a load, not of the pressure."""
        return self.displacement is not None or self.force is not None


def _natural(until: Until | None) -> Control:
    """Control that suits a goal; without one, for which some releases of pydantic ask too, any."""
    return "displacement" if until is not None and until.of_load else "volume"


class StaticPath(Table):
    """The equilibria of an elastic wall under one growing load, over limit points too.

    The load that the path ends by is an unknown, pressure or force; the other one is held.
    """

    until: Until = Field(description="where the path ends")
    control: Control = Field(
        default_factory=lambda given: _natural(given.get("until")),
        description="what is prescribed at each point; left out: volume, or displacement",
    )
    steps: int = Field(
        default=60, ge=1, le=100_000, description="number of steps; cut where they fail"
    )

    @model_validator(mode="after")
    def _of_one_load(self) -> Self:
        fitting = ("force", "displacement") if self.until.of_load else ("pressure", "volume")
        if self.control not in (*fitting, "arc-length"):
            end = next(iter(self.until.model_dump(exclude_none=True)))
            allowed = f"a path until a {end} is controlled by {', '.join(fitting)} or arc-length"
            raise refusal("", allowed=allowed, key="control")
        return self
