"""The tables `[run]` and `[path]` of a scene: a time span, or a path of equilibria."""

from typing import Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from .errors import refusal
from .table import ListOf, Table
from .units import Force, Length, Pressure, Time


class Run(Table):
    """Time span of a simulation, and the times whose profiles are saved."""

    end: Time = Field(gt=0, description="end of the simulation (min)")
    save: ListOf[Time] = Field(
        default_factory=lambda given: (given.get("end", 0.0),),
        description="times to save, each the end of a step (min); empty or default: the end",
    )

    stop_at_contact: bool = Field(
        default=False, description="whether to end where the wall touches itself"
    )
    stop_at_bifurcation: bool = Field(
        default=False, description="whether to end where the first equilibrium is unstable"
    )

    @field_validator("save")
    @classmethod
    def _within_the_run(cls, times: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        end = info.data.get("end", float("inf"))
        for time in times:
            if not 0 <= time <= end:
                raise refusal(
                    f"saved times must lie between 0 and run.end ({end:g} min); "
                    "if you change run.end, also set run.save",
                    reason=f"{time:g} min is outside the run",
                )
        return tuple(sorted(set(times))) or (end,)


Control = Literal["pressure", "volume", "arc-length", "force", "displacement"]


class Until(Table):
    """End of a path: a volume ratio or a pressure, or a displacement or force of a load."""

    volume_ratio: float | None = Field(
        default=None,
        description="V/V0; of a flat disc, volume over that of a hemisphere on its edge (1)",
    )
    pressure: Pressure | None = Field(default=None, description="pressure (MPa)")
    displacement: Length | None = Field(
        default=None,
        description="displacement of the load since the start, signed as its force (µm)",
    )
    force: Force | None = Field(default=None, description="force of the load (µN)")

    @model_validator(mode="after")
    def _one_end(self) -> Self:
        ends = (self.volume_ratio, self.pressure, self.displacement, self.force)
        if sum(end is not None for end in ends) != 1:
            keys = ", ".join(type(self).model_fields)
            raise refusal(f'expected exactly one of {keys}, e.g. {{ pressure = "1 MPa" }}')
        if self.volume_ratio == 1 or 0 in ends[1:]:
            raise refusal("must differ from the start of the path: V/V0 = 1, everything else 0")
        return self

    @property
    def of_load(self) -> bool:
        """Whether the force of a load varies along the path, not the pressure."""
        return self.displacement is not None or self.force is not None


def _default_control(until: Until | None) -> Control:
    # Some releases of pydantic ask even if `until` is wrong.
    return "displacement" if until is not None and until.of_load else "volume"


class StaticPath(Table):
    """Path of equilibria of an elastic wall under one varying load, through limit points.

    The load by which the path ends is an unknown, pressure or force; the other one is constant.
    """

    until: Until = Field(description="where the path ends")
    control: Control = Field(
        default_factory=lambda given: _default_control(given.get("until")),
        description="what is prescribed at each point; default: volume, or displacement of a load",
    )
    steps: int = Field(
        default=60,
        ge=1,
        le=100_000,
        description="number of steps; more are taken where the path turns sharply",
    )

    stop_at_contact: bool = Field(
        default=False, description="whether to end where the wall touches itself"
    )
    stop_at_bifurcation: bool = Field(
        default=False, description="whether to end where the first equilibrium is unstable"
    )

    @model_validator(mode="after")
    def _of_one_load(self) -> Self:
        controls = ("force", "displacement") if self.until.of_load else ("pressure", "volume")
        if self.control not in (*controls, "arc-length"):
            end = next(iter(self.until.model_dump(exclude_none=True)))
            allowed = ", ".join(f'"{control}"' for control in (*controls, "arc-length"))
            raise refusal(f"must be one of {allowed} for a path to a {end}", key="control")
        return self
