"""The table `[numerics]` of a scene and its presets."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from .errors import refusal
from .table import Table
from .units import TIME, Time

Grading = Literal["uniform", "graded"]
Geometry = Literal["conical", "curved"]
Rule = Literal["gauss", "clustered"]
Integrator = Literal["forward-euler", "backward-euler", "sdirk2", "sdirk3"]


@dataclass(frozen=True)
class Preset:
    """Values of the keys of `Numerics` that a scene omits; by default those of "default".

    Of these, elements, integration points and shear penalty are those of a bud, for the default
    tolerance; `precision.choose_numerics` chooses them for another scene.
    """

    elements: int = 10
    order: int = 4
    grading: Grading = "graded"
    geometry: Geometry = "curved"
    thickness_points: int = 6
    thickness_rule: Rule = "gauss"
    shear_penalty: float = 1000.0
    integrator: Integrator = "sdirk3"
    step: float | None = None
    tolerance: float = 1e-3


_PAPER = Preset(
    elements=480,
    order=1,
    grading="uniform",
    geometry="conical",
    thickness_points=3,
    integrator="backward-euler",
    step=0.2,
)
PRESETS: Mapping[str, Preset] = MappingProxyType({"default": Preset(), "paper": _PAPER})

_FEWEST_CLUSTERED = 3
_STEP = replace(TIME, example='"0.2 min" or "adaptive"')


def _none_if_adaptive(value: object) -> object:
    return None if value == "adaptive" else value


def _preset(key: str, description: str, **bounds: Any) -> Any:
    """Return the field of `Numerics` whose default is that of the preset."""
    return Field(
        # Some releases of pydantic ask even if the preset is wrong.
        default_factory=lambda given: getattr(PRESETS[given.get("preset", "default")], key),
        description=description,
        **bounds,
    )


class Numerics(Table):
    """Numerical method; keys that are omitted have the values of the preset."""

    preset: Literal["default", "paper"] = Field(
        default="default", description="source of the values of the other keys"
    )
    tolerance: float = _preset(
        "tolerance", "relative error of V/V0, all sources together (1)", ge=1e-8, le=0.1
    )
    elements: int = _preset("elements", "number of elements along the meridian", ge=2, le=100_000)
    order: int = _preset("order", "degree of the Lagrange elements", ge=1, le=4)
    grading: Grading = _preset("grading", "element sizes: uniform, or graded to zones and edges")
    geometry: Geometry = _preset("geometry", "meridian within an element: conical or curved")
    thickness_points: int = _preset(
        "thickness_points", "number of through-thickness integration points", ge=1, le=24
    )
    thickness_rule: Rule = _preset(
        "thickness_rule", "rule of these points: gauss, or clustered at the faces (from 3 points)"
    )
    shear_penalty: float = _preset(
        "shear_penalty", "shear penalty κ; inf: no shear (1)", gt=0, allow_inf_nan=True
    )
    integrator: Integrator = _preset("integrator", "time integration of growth")
    step: Annotated[Time | None, BeforeValidator(_none_if_adaptive), _STEP] = _preset(
        "step",
        'fixed time step (min), or "adaptive" to follow the tolerance; in Python, None',
        gt=0,
    )

    @model_validator(mode="after")
    def _enough_to_cluster(self) -> Self:
        if self.thickness_rule == "clustered" and self.thickness_points < _FEWEST_CLUSTERED:
            raise refusal(
                f"expected {_FEWEST_CLUSTERED} or more with thickness_rule = "
                f'"clustered"; with fewer, use "gauss"',
                key="thickness_points",
            )
        return self
