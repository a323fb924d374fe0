"""The table `[septum]` of a scene: a wall across the cell, and the piece that is left of it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from .table import Table
from .units import Length


class Septum(Table):
    """A rigid disc across the cell, at which it separates into two pieces.

    A scene without `piece` is the whole cell, with a node where the septum will be. One with a
    piece is what lies on one side of it, closed by the septum.
    """

    at: Length | None = Field(
        default=None, gt=0, description="arc length of its edge, left out: the bud's neck (µm)"
    )
    piece: Literal["bottom", "top"] | None = Field(
        default=None, description="side that the scene is; left out: the whole cell"
    )
