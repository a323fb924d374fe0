"""A cell whose shape is a traced contour."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from ..geometry import (
    Array,
    ContourError,
    Curve,
    End,
    Parametric,
    Smoothing,
    describe_smoothing,
    read_contour,
    smooth_contour,
)
from .edge import EDGE, HeldEdge
from .errors import refusal
from .shape import SHAPE, Shape
from .table import ListOf
from .units import LENGTH, Length
from .unloaded import Unloaded


class ProfileCell(Shape):
    """A smoothed contour, read from a file once and kept as points."""

    shape: Literal["profile"] = SHAPE
    file: str | None = Field(
        default=None,
        description="CSV file with the columns r and z (µm), beside the scene; read once",
    )
    tolerance: Length | None = Field(
        default=None,
        ge=0,
        description="root mean square distance between points and smoothed curve (µm); "
        "default: from the noise of the points",
    )
    scale: Length | None = Field(
        default=None, gt=0, description="size of a pixel, if the file is in pixels (µm)"
    )
    r: ListOf[Length] = Field(
        default=(), description="distances of the points from the axis, instead of a file (µm)"
    )
    z: ListOf[Length] = Field(
        default=(), description="heights of the points, from bottom to top (µm)"
    )
    edge: HeldEdge | None = Field(
        default=None,
        description=f"how the lower edge of an open contour is {EDGE}; default: a closed contour",
    )
    outline_is: Literal["unloaded", "turgid"] = Field(
        default="unloaded",
        description="whether the contour is that of the unloaded cell, or of the cell under its "
        "turgor: its unloaded shape is then found when a run starts",
    )
    unloaded: Unloaded | None = Field(
        default=None, description="written by a run: the unloaded shape that it has found"
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        """Replace the name of a file by its points, so that the scene needs no other file."""
        if not isinstance(data, Mapping) or not isinstance(data.get("file"), str):
            return data
        directory = (info.context or {}).get("directory", ".")
        try:
            tolerance, scale = (
                None if data.get(key) is None else float(LENGTH.read(data[key]))  # type: ignore[arg-type]
                for key in ("tolerance", "scale")
            )
        except (TypeError, ValueError, PydanticCustomError):
            return data  # the validation of these keys reports what is wrong
        if scale is not None and not scale > 0:
            return data  # its validation refuses it
        try:
            r, z = read_contour(Path(directory, data["file"]), scale)
        except ContourError as error:
            raise refusal(str(error), key="file") from None
        try:
            smooth_contour(r, z, tolerance, data.get("edge") is not None)
        except ContourError as error:
            raise refusal(f"the contour {error}", key="file") from None
        return {**data, "file": None, "scale": None, "r": r, "z": z}

    @model_validator(mode="after")
    def _a_contour(self) -> ProfileCell:
        if self.scale is not None:
            raise refusal("needs the file of a contour; r and z are in µm", key="scale")
        if not self.r and not self.z:
            raise refusal('expected a contour, e.g. "contour.csv"', key="file")
        if len(self.r) != len(self.z):
            raise refusal(f"expected {len(self.r)} heights, one per radius", key="z")
        try:
            smooth_contour(*self._contour)
        except ContourError as error:
            raise refusal(f"the contour {error}", key="r") from None
        return self

    def __eq__(self, other: object) -> bool:
        """Whether what is given is equal; what was found for it follows from that."""
        return isinstance(other, ProfileCell) and self._given == other._given

    def __hash__(self) -> int:
        return hash(tuple(self._given.values()))

    @property
    def _given(self) -> dict[str, object]:
        return {key: value for key, value in self.__dict__.items() if key != "unloaded"}

    @property
    def _contour(self) -> tuple[tuple[float, ...], tuple[float, ...], float | None, bool]:
        return self.r, self.z, self.tolerance, self.edge is not None

    @property
    def radius(self) -> float:
        return max(self.r)

    @property
    def smoothing(self) -> Smoothing:
        """What smoothing does to the contour."""
        return describe_smoothing(*self._contour)

    @property
    def least_radius(self) -> float:
        return self.curve.least_radius

    @property
    def ends(self) -> tuple[End, End]:
        return self.edge or "pole", "pole"

    @property
    def curve(self) -> Parametric:
        return smooth_contour(*self._contour)

    def reference(self, S: Array) -> tuple[Curve, Array]:
        outline = self.curve
        if self.outline_is == "unloaded":
            return outline, S
        if self.unloaded is None:
            raise ValueError(
                "the unloaded shape of a turgid outline is found by a run; see find_unloaded"
            )
        curve = self.unloaded.curve(outline, self.closed)
        return curve, curve.arc_length(outline.parameter(S))
