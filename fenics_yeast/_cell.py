"""The table `[cell]` of a scene: the shape of the unloaded cell."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from fenics_yeast._quantities import Length
from fenics_yeast._table import Table


class Cell(Table):
    """The shape of the unloaded cell."""

    shape: Literal["sphere"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the mid-surface (µm)")

    @property
    def radius(self) -> float:
        """Radius of the mid-surface (µm)."""
        return self.diameter / 2
