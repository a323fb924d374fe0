"""How an edge of a cell is constrained: keys that several shapes share."""

from typing import Annotated, Literal

from pydantic import BeforeValidator

from ..geometry import Edge
from .errors import refusal

EDGE = (
    "constrained: clamped (displacement and rotation), hinged (displacement), guided (axial "
    "displacement and rotation) or sliding (axial displacement)"
)
_RENAMED = {"roller": "guided", "axial": "sliding"}  # in other programs, a roller is our sliding


def _not_renamed(edge: object) -> object:
    if isinstance(edge, str) and edge in _RENAMED:
        must = f'write "{_RENAMED[edge]}"; "guided" and "sliding" were called "roller" and "axial"'
        raise refusal(must, reason="this name is no longer used")
    return edge


HeldEdge = Annotated[Edge, BeforeValidator(_not_renamed)]
InnerEdge = Annotated[Literal[Edge, "free"], BeforeValidator(_not_renamed)]
