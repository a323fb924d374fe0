"""What the shapes of a cell have in common."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from ..geometry import Array, Curve, End, Pole
from .table import Table
from .units import Length

SHAPE: Any = Field(description="shape of the mid-surface")


class Shape(Table):
    """Keys and properties that all shapes share.

    Each has a `radius`, the size of the cell, and a `least_radius` of curvature or of an edge, both
    in µm.
    """

    shape: str = SHAPE

    @property
    def curve(self) -> Curve:
        """Meridian on which the places of zones and loads are given."""
        raise NotImplementedError

    def reference(self, S: Array) -> tuple[Curve, Array]:
        """Return the meridian of the unloaded cell, and where places of `curve` are on it.

        Parameters
        ----------
        S
            Arc lengths on `curve` in µm.
        """
        return self.curve, S

    @property
    def ends(self) -> tuple[End, End]:
        """What the lower and the upper end of the meridian are."""
        return "pole", "pole"

    @property
    def poles(self) -> tuple[Pole, ...]:
        """The poles that it has."""
        lower, upper = self.ends
        top: tuple[Pole, ...] = ("top",) if upper == "pole" else ()
        return (*top, "bottom") if lower == "pole" else top

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
