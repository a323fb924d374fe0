"""What the shapes of a cell have in common."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from ..geometry import Curve, End, Pole
from .table import Table
from .units import Length

SHAPE: Any = Field(description="shape of the mid-surface")


class Shape(Table):
    """Keys and properties that all shapes share.

    Each has a `radius`, the size of the cell, and a `least_radius` of curvature or of an edge, both
    in µm.
    """

    poles: ClassVar[tuple[Pole, ...]] = ("top", "bottom")
    shape: str = SHAPE

    @property
    def curve(self) -> Curve:
        """Meridian of the unloaded cell."""
        raise NotImplementedError

    @property
    def ends(self) -> tuple[End, End]:
        """What the lower and the upper end of the meridian are."""
        return "pole", "pole"

    @property
    def layers(self) -> int:
        """Number of places with a boundary layer: edges, and jumps of the curvature."""
        return sum(end != "pole" for end in self.ends) + len(self.curve.joints)

    @property
    def closed(self) -> bool:
        """Whether the mid-surface has no edge."""
        return self.ends == ("pole", "pole")


class Round(Shape):
    """A shape whose size is a diameter."""

    diameter: Length = Field(gt=0, description="largest diameter of the mid-surface (µm)")

    @property
    def radius(self) -> float:
        """Radius of the mid-surface (µm)."""
        return self.diameter / 2

    @property
    def least_radius(self) -> float:
        return self.radius
