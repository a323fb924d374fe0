"""A fit: a scene, the numbers of it that vary, and the measured curves, read from ``fit.toml``."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, field_validator
from pydantic_core import PydanticCustomError

from .errors import SceneError, refusal, value_text
from .explain import explain
from .keys import flatten, unit_symbol, value_of
from .measured_curve import MeasuredCurve
from .scene import Scene
from .table import ListOf, Table
from .text_file import parse_toml, read_text
from .units import TIME

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
_WIDE = 30.0  # default limits, as a factor of the start


class CurveTable(Table):
    """A table ``[[curve]]`` of a fit: a file of measured values."""

    file: str = Field(description="CSV file, beside the fit")
    noise: float | None = Field(
        default=None, gt=0, lt=1, description="standard deviation relative to the values"
    )
    offset: Any = Field(default=0.0, description='time at which the run begins, or "free" (min)')
    set: dict[str, Any] = Field(
        default_factory=dict, description="values of the scene that differed, by dotted key"
    )

    @field_validator("offset")
    @classmethod
    def _time_or_free(cls, value: object) -> object:
        if value == "free":
            return value
        must = 'expected a time, e.g. "12 min" (plain numbers are in min), or "free"'
        try:
            time = TIME.read(value)
        except PydanticCustomError:
            raise refusal(must) from None
        if not isinstance(time, float):
            raise refusal(must)
        return time


class VaryTable(Table):
    """A table ``[vary."growth.time"]`` of a fit: limits and start of a number of the scene."""

    low: Any = Field(default=None, alias="from", description="lower limit")
    high: Any = Field(default=None, alias="to", description="upper limit")
    start: Any = Field(default=None, description="first value; default: that of the scene")


class FitTable(Table):
    """The content of ``fit.toml``."""

    scene: str = Field(description="scene file, beside the fit")
    vary: dict[str, Any] = Field(min_length=1, description="keys of numbers to fit, or tables")
    curve: Annotated[ListOf[CurveTable], Field(min_length=1, description="measured curves")]
    loss: Loss = Field(default="linear", description="robust losses give outliers less weight")
    starts: int = Field(default=1, ge=1, le=1000, description="number of first guesses")


@dataclass(frozen=True)
class Varied:
    """A number of the scene to fit: its key, first value and limits in µm, MPa, min, degrees."""

    key: str
    start: float
    low: float
    high: float
    unit: str = ""


@dataclass(frozen=True)
class FitProblem:
    """What to fit.

    Attributes
    ----------
    scene
        The scene with the first values.
    varied
        Its numbers to fit.
    curves
        What they are fitted to.
    loss
        Loss of scipy's `least_squares`; one other than "linear" gives outliers less weight.
    starts
        Number of first guesses, spread over the limits from the second one on.
    name
        Name for the output.
    """

    scene: Scene
    varied: tuple[Varied, ...]
    curves: tuple[MeasuredCurve, ...]
    loss: Loss = "linear"
    starts: int = 1
    name: str = "fit"

    @classmethod
    def of(
        cls,
        scene: Scene,
        curves: Iterable[MeasuredCurve],
        vary: Sequence[str] | Mapping[str, Mapping[str, object]],
        **options: Any,
    ) -> FitProblem:
        """Check and complete a fit.

        Parameters
        ----------
        scene, curves
            A scene in time, and the measured curves.
        vary
            Keys of positive numbers, or a mapping from keys to limits and first value, such as
            ``{"growth.time": {"from": "20 min", "to": 90, "start": 45}}``.
        options
            `loss`, `starts` and `name`.

        Raises
        ------
        SceneError
            If they do not make a fit.
        """
        curves = tuple(curves)
        tables = vary if isinstance(vary, Mapping) else {key: {} for key in vary}
        if not isinstance(vary, Mapping) and len(tables) < len(vary):
            raise SceneError("vary: a key is given twice")
        if scene.run is None:
            raise SceneError("a fit needs a run in time; add the table [run] to the scene")
        if not curves or not tables:
            raise SceneError("a fit needs at least one curve and one key to vary")
        varied = tuple(_varied(scene, key, table) for key, table in tables.items())
        for curve in curves:
            for key in curve.set:
                if key in tables:
                    raise SceneError(f"{curve.name}: set.{key} is varied; remove it from one")
                _known(scene, key, f"{curve.name}: set.{key}")
            scene.with_values(curve.set)
        count = sum(len(curve.values) for curve in curves)
        unknowns = len(varied) + sum(curve.offset == "free" for curve in curves)
        if count < unknowns:
            raise SceneError(f"{count} values cannot fix {unknowns} unknowns; measure more")
        start = scene.with_values({each.key: each.start for each in varied})
        return cls(start, varied, curves, **options)

    @classmethod
    def load(cls, path: str | Path) -> FitProblem:
        """Read a fit from a TOML file.

        Raises
        ------
        SceneError
            If the file, its scene or a curve cannot be read or is not valid.
        """
        path = Path(path)
        tables = parse_toml(read_text(path, "a fit file"), str(path))
        vary = tables.get("vary")
        if isinstance(vary, list) and all(isinstance(key, str) for key in vary):
            if len(set(vary)) < len(vary):
                raise SceneError(f"{path}: vary: a key is given twice")
            tables["vary"] = {key: {} for key in vary}
        elif vary is not None and not isinstance(vary, Mapping):
            raise SceneError(
                f"{path}: vary = {value_text(vary)}: expected a list of keys, "
                'e.g. ["growth.time"], or tables [vary."growth.time"]'
            )
        try:
            table = FitTable.model_validate(tables)
        except ValidationError as error:
            raise SceneError(f"{path}: {explain(FitTable, tables, error)}") from None
        scene = Scene.load(path.parent / table.scene)
        curves = [
            MeasuredCurve.read(
                path.parent / one.file, noise=one.noise, offset=one.offset, set=one.set
            )
            for one in table.curve
        ]
        try:
            return cls.of(
                scene, curves, table.vary, loss=table.loss, starts=table.starts, name=path.stem
            )
        except SceneError as error:
            raise SceneError(f"{path}: {error}") from None


def _known(scene: Scene, key: str, where: str) -> object:
    """Return the value of a key of the scene; suggest another if there is none."""
    try:
        return value_of(scene, key)
    except KeyError:
        near = difflib.get_close_matches(key, list(flatten(scene)), n=1)
        advice = f"did you mean {near[0]}?" if near else "the scene has no such key"
        raise SceneError(f"{where}: unknown key; {advice}") from None


def _varied(scene: Scene, key: str, table: object) -> Varied:
    """Return a varied number; its limits are read as the scene reads its values."""
    where = f"vary.{key}"
    value = _known(scene, key, where)
    if isinstance(value, bool) or not isinstance(value, float):
        raise SceneError(f"{where}: expected the key of a number that can vary continuously")
    if not isinstance(table, Mapping):
        raise SceneError(f'{where} = {value_text(table)}: expected a table [vary."{key}"]')
    try:
        limits = VaryTable.model_validate(dict(table))
    except ValidationError as error:
        raise SceneError(f"{where}.{explain(VaryTable, table, error)}") from None

    def read(given: object, otherwise: float) -> float:
        return otherwise if given is None else value_of(scene.with_values({key: given}), key)

    start = read(limits.start, value)
    low, high = read(limits.low, start / _WIDE), read(limits.high, start * _WIDE)
    if not 0 < low:
        raise SceneError(f"{where}: expected values > 0, as fits vary logarithms")
    if limits.start is None and not low <= start <= high:
        start = (low * high) ** 0.5
    if not low <= start <= high or low == high:
        raise SceneError(f"{where}: expected from < to with start between, in {low:g} to {high:g}")
    return Varied(key, start, low, high, unit_symbol(scene, key))
