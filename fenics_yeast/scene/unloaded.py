"""The unloaded shape that was found for the outline of a turgid cell."""

from __future__ import annotations

import numpy as np
from pydantic import Field, model_validator

from ..geometry import Array, Parametric, displaced
from .errors import refusal
from .table import ListOf, Table
from .units import Length

_FEWEST = 6


class Unloaded(Table):
    """Unloaded places of points of an outline, and from what they were found."""

    S: ListOf[Length] = Field(description="arc lengths of points on the outline, increasing (µm)")
    r: ListOf[Length] = Field(description="distances of their unloaded places from the axis (µm)")
    z: ListOf[Length] = Field(description="heights of their unloaded places (µm)")
    residual_distance: Length = Field(
        ge=0, description="largest distance of the inflated shape from the outline (µm)"
    )
    inputs: str = Field(description="digest of what it depends on: if that changes, it is replaced")

    @model_validator(mode="after")
    def _of_one_length(self) -> Unloaded:
        if len(self.S) < _FEWEST or not len(self.S) == len(self.r) == len(self.z):
            raise refusal("expected as many arc lengths, radii and heights", key="S")
        if not (np.diff(self.S) > 0).all():
            raise refusal("expected increasing arc lengths", key="S")
        return self

    def curve(self, outline: Parametric, closed: bool) -> Parametric:
        """Return the unloaded meridian, with the parameter of its outline."""
        t = outline.parameter(np.array(self.S))
        moved: Array = np.column_stack([self.r, self.z]) - np.column_stack(outline.point(t, 0))
        return displaced(outline, t, moved, (closed, True))
