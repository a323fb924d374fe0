"""What to simulate: a typed, validated, unit-aware scene, read from TOML and written back.

Inside a scene every quantity is a plain number: lengths in µm, pressures and stresses in MPa,
times in min, angles in degrees. Strings with a unit (``"100 nm"``, ``"2 atm"``, ``"45 min"``) are
converted on the way in. Whatever is wrong with a scene is a `SceneError` of one line.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from fenics_yeast._quantities import TIME, Angle, Length, Pressure, Time, refusal
from fenics_yeast._scene_errors import SceneError, explain, value_text

__all__ = [
    "PRESETS",
    "Cell",
    "Geometry",
    "Grading",
    "Growth",
    "Integrator",
    "Numerics",
    "Preset",
    "Run",
    "Scene",
    "SceneError",
    "Turgor",
    "Wall",
    "Zone",
    "parse_assignment",
    "parse_value",
]


class _Table(BaseModel):
    """A frozen table of a scene that knows its keys and takes no value of another type."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, hide_input_in_errors=True
    )

    if not TYPE_CHECKING:

        def __init__(self, **values: Any) -> None:
            try:
                super().__init__(**values)
            except ValidationError as error:
                problem = explain(type(self), values, error)
                raise SceneError(f"{type(self).__name__}: {problem}") from None

        # pydantic's mark for an __init__ that adds nothing to validation
        __init__.__pydantic_base_init__ = True


class Cell(_Table):
    """The shape of the unloaded cell."""

    shape: Literal["sphere"] = Field(description="shape of the mid-surface")
    diameter: Length = Field(gt=0, description="diameter of the mid-surface (µm)")

    @property
    def radius(self) -> float:
        """Radius of the mid-surface (µm)."""
        return self.diameter / 2


class Wall(_Table):
    """The cell wall: its thickness and the Ogden energy of its material, equation (9)."""

    thickness: Length = Field(gt=0, description="thickness of the wall (µm)")
    shear_modulus: Pressure = Field(gt=0, description="shear modulus µ (MPa)")
    ogden_exponent: float = Field(
        default=2.0, description="Ogden's exponent α, any number but 0 (1)"
    )

    @field_validator("ogden_exponent")
    @classmethod
    def _not_zero(cls, value: float) -> float:
        if value == 0:
            raise refusal("", allowed="any number but 0 is allowed")
        return value


class Turgor(_Table):
    """The pressure inside the cell: it rises linearly from 0 over the ramp and is then held."""

    pressure: Pressure = Field(description="turgor pressure, negative from outside (MPa)")
    ramp: Time = Field(default=0.01, ge=0, description="duration of the rise from 0 (min)")


class Zone(_Table):
    """The part of the wall that grows: a polar cap of the unloaded cell."""

    pole: Literal["top", "bottom"] = Field(description="pole around which the wall grows")
    half_angle: Angle = Field(
        gt=0, le=180, description="polar angle from the pole to the zone's edge (degrees)"
    )


class Growth(_Table):
    """Growth of the wall where its stress exceeds a threshold, equations (12)-(13)."""

    zone: Zone = Field(description="the part of the wall that grows")
    threshold: Pressure = Field(gt=0, description="stress σ_trs above which it grows (MPa)")
    time: Time = Field(gt=0, description="characteristic time t_grw of growth (min)")


class Run(_Table):
    """The time span of a simulation and the times whose profiles are kept."""

    end: Time = Field(gt=0, description="end of the simulation (min)")
    save: Annotated[tuple[Time, ...], Field(strict=False)] = Field(
        default_factory=lambda given: (given["end"],),
        description="times hit exactly and kept, sorted; left out: the end alone (min)",
    )

    @field_validator("save")
    @classmethod
    def _within_the_run(cls, times: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        if not times:
            raise refusal("", allowed="at least one time is wanted; left out, the end is saved")
        end = info.data.get("end", float("inf"))
        for time in times:
            if not 0 <= time <= end:
                allowed = f"saved times lie from 0 to run.end ({end:g} min)"
                raise refusal(f"{time:g} min is outside the run", allowed=allowed)
        return tuple(sorted(set(times)))


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


class Numerics(_Table):
    """How the scene is solved; what is left out comes from the preset."""

    preset: Literal["default", "paper"] = Field(
        default="default", description="where the rest comes from"
    )
    tolerance: float = _preset(
        "tolerance", "wanted relative error of V/V0 of adaptive steps (1)", gt=0, le=0.1
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


class Scene(_Table):
    """What to simulate: one cell, its wall, turgor and growth, and how to solve it.

    Two scenes are equal when all their values are, whatever they are called.
    """

    title: str = Field(
        default="", description="title of figures, and the name unless read from a file"
    )
    cell: Cell = Field(description="shape of the unloaded cell")
    wall: Wall = Field(description="the cell wall")
    turgor: Turgor = Field(description="pressure inside the cell")
    growth: Growth | None = Field(
        default=None, description="growth of the wall; None: an elastic scene"
    )
    run: Run | None = Field(default=None, description="time span; None: a single equilibrium")
    numerics: Numerics = Field(
        default_factory=lambda: Numerics(), description="how the scene is solved"
    )

    _stem: str = PrivateAttr("")
    _source: str = PrivateAttr("scene")

    @model_validator(mode="after")
    def _tables_agree(self) -> Self:
        if self.wall.thickness >= self.cell.radius:
            allowed = f"a thickness less than the cell's radius ({self.cell.radius:g} µm) is wanted"
            raise refusal("", allowed=allowed, key="wall.thickness")
        if self.growth is not None and self.run is None:
            allowed = 'growth needs a [run] table with an end time, e.g. end = "90 min"'
            raise refusal("", allowed=allowed, key="run")
        return self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.values()))

    @property
    def name(self) -> str:
        """Name for the scene's output: the stem of its file, else its title made a file name."""
        return self._stem or re.sub(r"\W+", "-", self.title[:60].lower()).strip("-") or "scene"

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a scene from a TOML file.

        Raises
        ------
        SceneError
            If the file cannot be read or what it holds is no scene.
        """
        source = str(path)
        try:
            text = Path(path).read_bytes().decode("utf-8-sig")
        except FileNotFoundError:
            raise SceneError(f"{source}: no such file; a scene file is wanted") from None
        except IsADirectoryError:
            raise SceneError(f"{source}: is a folder; a scene file is wanted") from None
        except UnicodeDecodeError as error:
            at = f"byte {error.start + 1}"
            raise SceneError(f"{source}: not a text in UTF-8, see {at}; save it as UTF-8") from None
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise SceneError(f"{source}: cannot be read: {reason}") from None
        scene = cls.from_toml(text, source=source)
        scene._stem = Path(path).stem
        return scene

    @classmethod
    def from_toml(cls, text: str, source: str = "scene") -> Self:
        """Read a scene from TOML text; `source` is the name under which errors speak of it.

        Raises
        ------
        SceneError
            If the text is no TOML or no scene.
        """
        try:
            tables = tomllib.loads(text)
        except ValueError as error:
            raise SceneError(f"{source}: not TOML: {error}") from None
        except RecursionError:
            raise SceneError(f"{source}: not a scene: brackets nested too deep") from None
        return cls._from_tables(tables, source)

    @classmethod
    def _from_tables(cls, tables: dict[str, Any], source: str) -> Self:
        try:
            scene = cls.model_validate(tables)
        except ValidationError as error:
            raise SceneError(f"{source}: {explain(cls, tables, error)}") from None
        scene._source = source
        return scene

    def to_toml(self) -> str:
        """Write the scene as TOML with every default spelled out, in µm, MPa, min and degrees."""
        import tomli_w

        tables = {key: value for key, value in self.model_dump().items() if value is not None}
        if self.numerics.step is None:
            tables["numerics"]["step"] = "adaptive"
        return "# Units: µm, MPa, min, degrees.\n" + tomli_w.dumps(tables)

    def with_values(self, values: Mapping[str, object]) -> Self:
        """Give the scene with some values changed, all of it validated anew.

        Values that were never set follow the change: those of the preset follow
        `numerics.preset`, saved times that were left out follow `run.end`.

        Parameters
        ----------
        values
            Dotted keys and their values, such as ``{"growth.time": 30, "turgor.pressure":
            "1 atm"}``; a whole table may be given, and None for one that may be left out.

        Raises
        ------
        SceneError
            If a key is unknown or the changed scene is not valid.
        """
        tables = self.model_dump(exclude_unset=True)
        for dotted, value in values.items():
            *parents, key = dotted.split(".")
            table = tables
            for parent in parents:
                if table.get(parent) is None:
                    table[parent] = {}
                table = table[parent]
                if not isinstance(table, dict):
                    change = f"{dotted[:80]} = {value_text(value)}"
                    raise SceneError(f"{self._source}: {change}: {parent} is not a table")
            if isinstance(value, _Table):
                value = value.model_dump(exclude_unset=True)
            table[key] = deepcopy(value)  # not the caller's own: a later key may go into it
        scene = self._from_tables(tables, self._source)
        scene._stem = self._stem
        return scene


# Assignments ----------------------------------------------------------------------------------


def parse_assignment(text: str) -> tuple[str, object]:
    """Split ``TABLE.KEY=VALUE`` into a key and a value for `Scene.with_values`.

    Raises
    ------
    SceneError
        If there is no key, no equals sign or no value.
    """
    key, _, value = (part.strip() for part in text.partition("="))
    if not key or not value:
        raise SceneError(f"{value_text(text)}: write TABLE.KEY=VALUE, e.g. growth.time=30")
    return key, parse_value(value)


def parse_value(text: str) -> object:
    """Read `text` as a TOML value, as a number (``1000.``) or as a plain string (``30 min``)."""
    try:
        values = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        try:
            return float(text)
        except ValueError:
            return text
    return values["value"] if len(values) == 1 else text
