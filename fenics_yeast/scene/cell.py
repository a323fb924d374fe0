"""The table `[cell]` of a scene: the shape of the unloaded cell, and the supports of its edges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
)

from ..geometry import (
    Cap,
    Capsule,
    Curve,
    End,
    Sphere,
    Straight,
    spheroid,
)
from .edge import EDGE, HeldEdge, InnerEdge
from .errors import BRANCH, SceneError, refusal
from .profile_cell import ProfileCell
from .shape import SHAPE, Round, Shape
from .table import Table
from .units import Angle, Length

_SLENDEREST = 1000.0  # length of a capsule over its diameter


class SphereCell(Round):
    """A sphere."""

    shape: Literal["sphere"] = SHAPE

    @property
    def curve(self) -> Curve:
        return Sphere(self.radius)


class SpheroidCell(Round):
    """A spheroid: an ellipse rotated about the axis."""

    shape: Literal["spheroid"] = SHAPE
    height: Length = Field(gt=0, description="distance between the poles (µm)")

    @property
    def least_radius(self) -> float:
        """At the poles if prolate, at the equator if oblate."""
        a, c = self.radius, self.height / 2
        return min(a**2 / c, c**2 / a)

    @property
    def curve(self) -> Curve:
        return spheroid(self.radius, self.height / 2)


class CapsuleCell(Round):
    """A cylinder with a hemisphere at each end, as a cell of fission yeast."""

    shape: Literal["capsule"] = SHAPE
    length: Length = Field(gt=0, description="distance between the poles (µm)")

    @field_validator("length")
    @classmethod
    def _longer_than_wide(cls, length: float, info: ValidationInfo) -> float:
        diameter = info.data.get("diameter", 0.0)
        if length <= diameter:
            raise refusal(f"expected a length > the diameter ({diameter:g} µm)")
        if length > _SLENDEREST * diameter > 0:
            raise refusal(f"expected a length <= {_SLENDEREST:g} diameters ({diameter:g} µm)")
        return length

    @property
    def curve(self) -> Curve:
        return Capsule(self.radius, self.length - self.diameter)


class CapCell(Shape):
    """The part of a sphere around its top pole."""

    shape: Literal["cap"] = SHAPE
    radius: Length = Field(gt=0, description="radius of the sphere (µm)")
    half_angle: Angle = Field(gt=0, lt=180, description="polar angle of the edge (degrees)")
    edge: HeldEdge = Field(default="clamped", description=f"how the edge is {EDGE}")

    @property
    def least_radius(self) -> float:
        return self.radius

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, "pole"

    @property
    def curve(self) -> Curve:
        return Cap(self.radius, float(np.deg2rad(self.half_angle)))


class DiscCell(Round):
    """A flat disc; its outward side is the upper one."""

    shape: Literal["disc"] = SHAPE
    edge: HeldEdge = Field(default="clamped", description=f"how the edge is {EDGE}")

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, "pole"

    @property
    def curve(self) -> Curve:
        return Straight(self.radius, 0.0, 0.0)


class ConeCell(Shape):
    """A truncated cone, its outer edge below; a flat ring if its height is 0."""

    shape: Literal["cone"] = SHAPE
    outer_diameter: Length = Field(gt=0, description="diameter of the lower edge (µm)")
    inner_diameter: Length = Field(gt=0, description="diameter of the upper edge (µm)")
    height: Length = Field(ge=0, description="height of the upper above the lower edge (µm)")
    edge: HeldEdge = Field(default="clamped", description=f"how the outer edge is {EDGE}")
    inner_edge: InnerEdge = Field(
        default="free", description="how the inner edge is constrained: free, or as for edge"
    )

    @field_validator("inner_diameter")
    @classmethod
    def _within(cls, inner: float, info: ValidationInfo) -> float:
        outer = info.data.get("outer_diameter", float("inf"))
        if inner >= outer:
            raise refusal(f"expected a length < the outer diameter ({outer:g} µm)")
        return inner

    @property
    def radius(self) -> float:
        return self.outer_diameter / 2

    @property
    def least_radius(self) -> float:
        return self.inner_diameter / 2

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, self.inner_edge

    @property
    def curve(self) -> Curve:
        return Straight(self.radius, self.least_radius, self.height)


class CylinderCell(Round):
    """A cylinder with the same support at both edges."""

    shape: Literal["cylinder"] = SHAPE
    length: Length = Field(gt=0, description="distance between the edges (µm)")
    edge: HeldEdge = Field(default="clamped", description=f"how both edges are {EDGE}")

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, self.edge

    @property
    def curve(self) -> Curve:
        return Straight(self.radius, self.radius, self.length)


def _shape(value: object) -> str | None:
    if isinstance(value, Mapping):
        return f"{BRANCH}{value.get('shape')}"
    return f"{BRANCH}{value.shape}" if isinstance(value, Shape) else None


AnyCell = Annotated[
    Annotated[SphereCell, Tag(f"{BRANCH}sphere")]
    | Annotated[SpheroidCell, Tag(f"{BRANCH}spheroid")]
    | Annotated[CapsuleCell, Tag(f"{BRANCH}capsule")]
    | Annotated[ProfileCell, Tag(f"{BRANCH}profile")]
    | Annotated[CapCell, Tag(f"{BRANCH}cap")]
    | Annotated[DiscCell, Tag(f"{BRANCH}disc")]
    | Annotated[ConeCell, Tag(f"{BRANCH}cone")]
    | Annotated[CylinderCell, Tag(f"{BRANCH}cylinder")],
    Discriminator(_shape),
]


class _Holder(Table):
    cell: AnyCell


def Cell(**values: Any) -> AnyCell:
    """Return the shape of an unloaded cell, from the keys of the table `[cell]`.

    Raises
    ------
    SceneError
        If there is no such shape, or a key is wrong.
    """
    table: Any = values
    try:
        return _Holder(cell=table).cell
    except SceneError as error:
        raise SceneError(f"Cell: {str(error).removeprefix('_Holder: cell.')}") from None
