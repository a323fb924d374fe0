"""The table `[numerics]` of a scene and its presets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from .table import Table
from .units import TIME, Time

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


def _chosen(given: Mapping[str, Any]) -> Preset:
    """The preset; any where it is wrong, for some releases of pydantic ask all the same."""
    return PRESETS[given.get("preset", "default")]


def _preset(key: str, description: str, **bounds: Any) -> Any:
    """Give the field of `Numerics` that is taken from the preset when left out."""
    return Field(
        default_factory=lambda given: getattr(_chosen(given), key),
        description=description,
        **bounds,
    )


def elements_for(tolerance: float, zones: int = 1, layers: int = 1) -> int:
    """Number of graded cells of degree 4 whose error of V/V0 stays within a tolerance.

    Measured on growing buds, thick and thin: 12 leave an error below 1e-5, 24 below 1e-6. The
    parts of other scenes take the shares of cells that they have in a bud.

    Parameters
    ----------
    tolerance
        Wanted relative error of V/V0.
    zones, layers
        Parts of the meridian that grow, and places with a boundary layer; a bud has one of each.
    """
    share = (1 + 1.6 * zones + 5.6 * layers) / 8.2
    return max(10, round(14 * share * (1e-4 / tolerance) ** (1 / 6)))


def _elements(given: Mapping[str, Any]) -> int:
    """Number of elements of the preset, or what a bud needs; `Scene` knows better."""
    preset = _chosen(given)
    return preset.elements or elements_for(given.get("tolerance", preset.tolerance))


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
