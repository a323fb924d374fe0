"""The table `[growth]` of a scene: where, above which stress and how fast the wall grows."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from fenics_yeast._quantities import Angle, Pressure, Time
from fenics_yeast._table import Table


class Zone(Table):
    """The part of the wall that grows: a polar cap of the unloaded cell."""

    pole: Literal["top", "bottom"] = Field(description="pole around which the wall grows")
    half_angle: Angle = Field(
        gt=0, le=180, description="polar angle from the pole to the zone's edge (degrees)"
    )


class Growth(Table):
    """Growth of the wall where its stress exceeds a threshold, equations (12)-(13)."""

    zone: Zone = Field(description="the part of the wall that grows")
    threshold: Pressure = Field(gt=0, description="stress σ_trs above which it grows (MPa)")
    time: Time = Field(gt=0, description="characteristic time t_grw of growth (min)")
