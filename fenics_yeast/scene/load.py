"""The table `[load]` of a scene: a force along the axis, beside the turgor."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from .errors import refusal
from .table import Table
from .units import Force, Length


class Load(Table):
    """A dead force along the axis, at a pole or around a ring.

    A closed cell rests on its other pole, or on the lower one; every other shape on its edge.
    """

    point_force: Force | None = Field(
        default=None, description="force at a pole, positive outward, negative to indent (µN)"
    )
    pole: Literal["top", "bottom"] = Field(
        default="top", description="pole at which the point force acts"
    )
    ring_force: Force | None = Field(
        default=None, description="force of a whole ring, positive towards the top (µN)"
    )
    at: Length | None = Field(
        default=None,
        gt=0,
        description="arc length of the ring from the lower end (µm); left out: the upper edge",
    )

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if (self.point_force is None) == (self.ring_force is None):
            raise refusal("", allowed="either point_force or ring_force is wanted")
        if self.ring_force is None and self.at is not None:
            raise refusal("", allowed="a point force acts at a pole", key="at")
        return self

    @property
    def force(self) -> float:
        """The force (µN)."""
        return (self.ring_force if self.point_force is None else self.point_force) or 0.0
