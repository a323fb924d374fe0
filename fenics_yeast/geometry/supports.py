"""Ends of a meridian: poles, free edges and supported edges, and what each constrains."""

from typing import Literal

Pole = Literal["top", "bottom"]
Poles = Literal[Pole, "both"]
Edge = Literal["clamped", "hinged", "guided", "sliding"]
End = Literal["pole", Edge, "free"]

CONSTRAINED: dict[End, tuple[int, ...]] = {
    "pole": (0, 2),
    "clamped": (0, 1, 2),
    "hinged": (0, 1),
    "guided": (1, 2),
    "sliding": (1,),
    "free": (),
}
"""Components of `(u_r, u_z, β)` that vanish at an end; at a pole by regularity."""
