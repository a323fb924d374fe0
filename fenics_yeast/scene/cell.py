"""The table `[cell]` of a scene: the shape of the unloaded cell, and how its edges are held."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import (
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ..geometry import (
    Cap,
    Capsule,
    ContourError,
    Curve,
    Edge,
    End,
    Pole,
    Sphere,
    Straight,
    read_contour,
    smooth_contour,
    spheroid,
)
from .errors import BRANCH, SceneError, refusal
from .explain import explain
from .table import Table
from .units import LENGTH, Angle, Length

_EDGE = (
    "what is held: clamped (all), hinged (both displacements), roller (axial displacement and "
    "rotation) or axial (axial displacement)"
)


class _Shape(Table):
    """What all shapes have in common.

    Each has a `radius`, the size of the cell, and a `least_radius` of curvature, both in µm.
    """

    poles: ClassVar[tuple[Pole, ...]] = ("top", "bottom")

    @property
    def curve(self) -> Curve:
        """Meridian of the unloaded cell."""
        raise NotImplementedError

    @property
    def ends(self) -> tuple[End, End]:
        """What the lower and the upper end of the meridian are."""
        return "pole", "pole"

    @property
    def stiff_without_bending(self) -> bool:
        """Whether a membrane of this shape can bear pressure."""
        return True

    @property
    def layers(self) -> int:
        """Number of places with a boundary layer: edges, and jumps of the curvature."""
        return sum(end != "pole" for end in self.ends)

    @property
    def closed(self) -> bool:
        """Whether the mid-surface has no edge."""
        return self.ends == ("pole", "pole")


class SphereCell(_Shape):
    """A sphere."""

    shape: Literal["sphere"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the mid-surface (µm)")

    @property
    def radius(self) -> float:
        """Radius of the mid-surface (µm)."""
        return self.diameter / 2

    @property
    def least_radius(self) -> float:
        return self.radius

    @property
    def curve(self) -> Curve:
        return Sphere(self.diameter / 2)


class SpheroidCell(_Shape):
    """An ellipse turned about the axis."""

    shape: Literal["spheroid"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the equator (µm)")
    height: Length = Field(gt=0, description="distance of the poles (µm)")

    @property
    def radius(self) -> float:
        return self.diameter / 2

    @property
    def least_radius(self) -> float:
        """At the poles of a long one, at the equator of a flat one."""
        a, c = self.diameter / 2, self.height / 2
        return min(a**2 / c, c**2 / a)

    @property
    def curve(self) -> Curve:
        return spheroid(self.diameter / 2, self.height / 2)


class CapsuleCell(_Shape):
    """A cylinder with half a sphere at each end, as a cell of fission yeast."""

    shape: Literal["capsule"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the mid-surface (µm)")
    length: Length = Field(gt=0, description="distance of the poles (µm)")

    @field_validator("length")
    @classmethod
    def _longer_than_wide(cls, length: float, info: ValidationInfo) -> float:
        diameter = info.data.get("diameter", 0.0)
        if length <= diameter:
            raise refusal("", allowed=f"a length greater than the diameter ({diameter:g} µm)")
        return length

    @property
    def radius(self) -> float:
        return self.diameter / 2

    @property
    def least_radius(self) -> float:
        return self.radius

    @property
    def layers(self) -> int:
        return 2

    @property
    def curve(self) -> Curve:
        return Capsule(self.diameter / 2, self.length - self.diameter)


class ProfileCell(_Shape):
    """A traced contour, smoothed; read from a file once, and held as points from then on."""

    shape: Literal["profile"] = Field(description="shape of the mid-surface")
    file: str | None = Field(
        default=None, description="table with the columns r, z (µm), beside the scene; read once"
    )
    tolerance: Length = Field(
        default=0.02, ge=0, description="root mean square distance of points and curve (µm)"
    )
    r: Annotated[tuple[Length, ...], Field(strict=False)] = Field(
        default=(), description="distances of the points from the axis (µm), in place of a file"
    )
    z: Annotated[tuple[Length, ...], Field(strict=False)] = Field(
        default=(), description="heights of the points (µm), from bottom to top"
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        """Put the points of a file in the place of its name: the scene then stands alone."""
        if not isinstance(data, Mapping) or not isinstance(data.get("file"), str):
            return data
        folder = (info.context or {}).get("folder", ".")
        tolerance = data.get("tolerance", cls.model_fields["tolerance"].default)
        try:
            r, z = read_contour(Path(folder, data["file"]))
            try:
                smooth_contour(r, z, float(LENGTH.read(tolerance)))  # type: ignore[arg-type]
            except ContourError as error:
                raise ContourError(f"the contour {error}") from None
        except (TypeError, PydanticCustomError):  # no tolerance, which is told elsewhere
            return {**data, "file": None, "r": r, "z": z}
        except ContourError as error:
            raise refusal("", allowed=str(error), key="file") from None
        return {**data, "file": None, "r": r, "z": z}

    @model_validator(mode="after")
    def _a_contour(self) -> ProfileCell:
        if not self.r and not self.z:
            raise refusal("", allowed='a contour is wanted, e.g. "contour.csv"', key="file")
        if len(self.r) != len(self.z):
            raise refusal("", allowed=f"a height for each of the {len(self.r)} radii", key="z")
        try:
            smooth_contour(self.r, self.z, self.tolerance)
        except ContourError as error:
            raise refusal("", allowed=f"the contour {error}", key="r") from None
        return self

    @property
    def radius(self) -> float:
        return max(self.r)

    @property
    def least_radius(self) -> float:
        return smooth_contour(self.r, self.z, self.tolerance).least_radius

    @property
    def curve(self) -> Curve:
        return smooth_contour(self.r, self.z, self.tolerance)


class CapCell(_Shape):
    """The part of a sphere about its top pole."""

    poles: ClassVar[tuple[Pole, ...]] = ("top",)
    shape: Literal["cap"] = Field(description="shape of the mid-surface")
    radius: Length = Field(gt=0, description="radius of the sphere (µm)")
    half_angle: Angle = Field(gt=0, lt=180, description="polar angle of the edge (degrees)")
    edge: Edge = Field(default="clamped", description=_EDGE)

    @property
    def least_radius(self) -> float:
        return self.radius

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, "pole"

    @property
    def curve(self) -> Curve:
        return Cap(self.radius, float(np.deg2rad(self.half_angle)))


class DiscCell(_Shape):
    """A flat disc; its outward side is the upper one."""

    poles: ClassVar[tuple[Pole, ...]] = ("top",)
    shape: Literal["disc"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the mid-surface (µm)")
    edge: Edge = Field(default="clamped", description=_EDGE)

    @property
    def radius(self) -> float:
        return self.diameter / 2

    @property
    def least_radius(self) -> float:
        return self.radius

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, "pole"

    @property
    def curve(self) -> Curve:
        return Straight(self.diameter / 2, 0.0, 0.0)


class ConeCell(_Shape):
    """A truncated cone, its outer edge below; a ring where it has no height."""

    poles: ClassVar[tuple[Pole, ...]] = ()
    shape: Literal["cone"] = Field(description="shape of the mid-surface")
    outer_diameter: Length = Field(gt=0, description="diameter of the lower edge (µm)")
    inner_diameter: Length = Field(gt=0, description="diameter of the upper edge (µm)")
    height: Length = Field(ge=0, description="height of the inner above the outer edge (µm)")
    edge: Edge = Field(default="clamped", description=f"at the outer edge, {_EDGE}")
    inner_edge: Edge | Literal["free"] = Field(
        default="free", description="what is held at the inner edge: free (nothing), or as at edge"
    )

    @field_validator("inner_diameter")
    @classmethod
    def _within(cls, inner: float, info: ValidationInfo) -> float:
        outer = info.data.get("outer_diameter", float("inf"))
        if inner >= outer:
            raise refusal("", allowed=f"a length less than the outer diameter ({outer:g} µm)")
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
    def stiff_without_bending(self) -> bool:
        return self.height > 0

    @property
    def curve(self) -> Curve:
        return Straight(self.outer_diameter / 2, self.inner_diameter / 2, self.height)


class CylinderCell(_Shape):
    """A cylinder, both of its edges held alike."""

    poles: ClassVar[tuple[Pole, ...]] = ()
    shape: Literal["cylinder"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the mid-surface (µm)")
    length: Length = Field(gt=0, description="distance of the edges (µm)")
    edge: Edge = Field(default="clamped", description=f"at both edges, {_EDGE}")

    @property
    def radius(self) -> float:
        return self.diameter / 2

    @property
    def least_radius(self) -> float:
        return self.radius

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge, self.edge

    @property
    def curve(self) -> Curve:
        return Straight(self.diameter / 2, self.diameter / 2, self.length)


def _shape(value: object) -> str | None:
    if isinstance(value, Mapping):
        return f"{BRANCH}{value.get('shape')}"
    return f"{BRANCH}{value.shape}" if isinstance(value, _Shape) else None  # type: ignore[attr-defined]


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
    """Shape of the unloaded cell, with the keys of the table `[cell]`.

    Raises
    ------
    SceneError
        If there is no such shape, or its keys are not right.
    """
    try:
        return TypeAdapter(_Holder).validate_python({"cell": values}).cell
    except ValidationError as error:
        problem = explain(_Holder, {"cell": values}, error).removeprefix("cell.")
        raise SceneError(f"Cell: {problem}") from None
