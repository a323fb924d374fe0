"""Ends of a meridian: poles, free edges, and edges that are held in one way or another."""

from __future__ import annotations

from typing import Literal

Edge = Literal["clamped", "hinged", "roller", "axial"]
End = Literal["pole", "clamped", "hinged", "roller", "axial", "free"]
Pole = Literal["top", "bottom"]
