"""The table `[numerics]` of a scene and its presets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from fenics_yeast._quantities import TIME, Time
from fenics_yeast._table import Table

Grading = Literal["uniform", "graded"]
Geometry = Literal["conical", "curved"]
Integrator = Literal["forward-euler", "backward-euler", "sdirk2", "sdirk3"]


@dataclass(frozen=True)
class Preset:
    """Values for every key of `Numerics` that a scene leaves out.

    Without a number of `elements`, it follows from the tolerance.
    """

    elements: int | None
    order: int
    grading: Grading
    geometry: Geometry
    thickness_points: int
    shear_penalty: float
    integrator: Integrator
    step: float | None
    tolerance: float


PRESETS: Mapping[str, Preset] = MappingProxyType(
    {
        "default": Preset(
            elements=None,
            order=4,
            grading="graded",
            geometry="curved",
            thickness_points=5,
            shear_penalty=1000.0,
            integrator="sdirk3",
            step=None,
            tolerance=1e-4,
        ),
        "paper": Preset(
            elements=480,
            order=1,
            grading="uniform",
            geometry="conical",
            thickness_points=3,
            shear_penalty=1000.0,
            integrator="backward-euler",
            step=0.2,
            tolerance=1e-4,
        ),
    }
)


_STEP = replace(TIME, example='"0.2 min" or "adaptive"')


def _none_if_adaptive(value: object) -> object:
    return None if value == "adaptive" else value


def _preset(key: str, description: str, **bounds: Any) -> Any:
    """Give the field of `Numerics` that is taken from the preset when left out."""
    return Field(
        default_factory=lambda given: getattr(PRESETS[given["preset"]], key),
        description=description,
        **bounds,
    )


def _elements(given: Mapping[str, Any]) -> int:
    """Number of elements of the preset, or the one whose error stays within the tolerance.

    Measured for graded cells of degree 4 on three buds: 16 leave an error of V/V0 below 1e-5,
    33 below 1e-6.
    """
    elements = PRESETS[given["preset"]].elements
    return elements or max(12, round(16 * (1e-4 / given["tolerance"]) ** (1 / 6)))


class Numerics(Table):
    """How the scene is solved; what is left out comes from the preset."""

    preset: Literal["default", "paper"] = Field(
        default="default", description="where the rest comes from"
    )
    tolerance: float = _preset(
        "tolerance", "wanted relative error of V/V0 of adaptive steps (1)", ge=1e-8, le=0.1
    )
    elements: int = Field(
        default_factory=_elements,
        description="number of elements along the meridian",
        ge=2,
        le=100_000,
    )
    order: int = _preset("order", "degree of the Lagrange elements", ge=1, le=4)
    grading: Grading = _preset("grading", "element sizes: equal, or following the zone's edge")
    geometry: Geometry = _preset("geometry", "meridian within an element: straight or curved")
    thickness_points: int = _preset(
        "thickness_points", "Gauss points through the wall", ge=1, le=16
    )
    shear_penalty: float = _preset(
        "shear_penalty", "shear penalty κ, inf for no shear (1)", gt=0, allow_inf_nan=True
    )
    integrator: Integrator = _preset("integrator", "time integration of growth")
    step: Annotated[Time | None, BeforeValidator(_none_if_adaptive), _STEP] = _preset(
        "step", 'fixed time step; "adaptive", None in Python, where the tolerance rules (min)', gt=0
    )
