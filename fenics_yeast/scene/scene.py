"""What to simulate: a typed, validated, unit-aware scene, read from TOML and written back.

In a scene every quantity is a plain number: lengths in µm, pressures and stresses in MPa, times in
min, angles in degrees. Strings with a unit (``"100 nm"``, ``"2 atm"``, ``"45 min"``) are converted
when read. Every error is a `SceneError` of one line.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from ..geometry import Intervals
from . import checks
from .cell import AnyCell
from .errors import SceneError, refusal, value_text
from .explain import explain
from .growth import Growth, OneOrMore
from .keys import set_value
from .loads import Load, Septum, Turgor
from .numerics import Numerics
from .precision import Meridian, choose_numerics
from .run import Run, StaticPath
from .table import Table
from .text_file import parse_toml, read_text
from .wall import AnyWall


class Scene(Table):
    """What to simulate: one cell, its wall, turgor and growth, and the numerical method.

    Two scenes are equal if all their values are equal, whatever their names.
    """

    title: str = Field(
        default="", description="title of figures; also the name of a scene without a file"
    )
    cell: AnyCell = Field(description="shape of the unloaded cell")
    wall: AnyWall = Field(description="the cell wall")
    turgor: Turgor = Field(
        default_factory=lambda: Turgor(pressure=0.0),
        description="pressure inside the cell; default: 0, if there is a path or a load",
    )
    axial_load: Load | None = Field(  # `load` reads a file
        default=None, alias="load", description="force along the axis; default: only turgor"
    )
    growth: OneOrMore | None = Field(
        default=None, description="growth of one zone or more; default: an elastic wall"
    )
    septum: Septum | None = Field(
        default=None, description="where the cell separates into two; default: it does not"
    )
    run: Run | None = Field(default=None, description="time span; default: a single equilibrium")
    path: StaticPath | None = Field(
        default=None, description="path of equilibria, instead of a time span"
    )
    numerics: Numerics = Field(default_factory=lambda: Numerics(), description="numerical method")

    _stem: str = PrivateAttr("")
    _source: str = PrivateAttr("scene")

    @model_validator(mode="after")
    def _tables_agree(self) -> Self:
        cell, wall, load = self.cell, self.wall, self.axial_load
        if "turgor" not in self.model_fields_set and self.path is None and load is None:
            raise refusal(key="turgor")
        checks.check_wall(wall, cell)
        checks.check_outline(cell, self.turgor)
        checks.check_load(load, self.path, cell, wall)
        checks.check_span(self.run, self.path, self.turgor, grows=self.growth is not None)
        checks.check_zones(wall.zone, cell, "wall.zone.{}")
        key = "growth.{}" if isinstance(self.growth, tuple) else "growth"
        checks.check_zones([growth.zone for growth in self.growing], cell, f"{key}.zone")
        for i, growth in enumerate(self.growing):
            if growth.polarity is not None:
                checks.check_polarity(growth.polarity, cell, f"{key}.polarity".format(i))
        if self.septum is not None:
            checks.check_septum(self.septum, load, cell, self.growing_parts)
        return self

    @model_validator(mode="after")
    def _choose_numerics(self) -> Self:
        """Set what the tolerance asks of this scene, unless it is given."""
        self.__dict__["numerics"] = choose_numerics(self.numerics, self.meridian)  # frozen
        return self

    @property
    def meridian(self) -> Meridian:
        """What the meridian asks of its mesh."""
        return Meridian.of(self.cell, self.wall, self.growing, self.axial_load)

    @property
    def growing(self) -> tuple[Growth, ...]:
        """Growth of each zone; empty for an elastic scene."""
        if self.growth is None:
            return ()
        return self.growth if isinstance(self.growth, tuple) else (self.growth,)

    @property
    def growing_parts(self) -> Intervals:
        """Parts of the meridian that grow, zone by zone."""
        curve = self.cell.curve
        return tuple(part for growth in self.growing for part in growth.zone.intervals(curve))

    @property
    def growth_time(self) -> float | None:
        """Least characteristic growth time (min); None for an elastic scene."""
        return min((growth.time for growth in self.growing), default=None)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.values()))

    @property
    def name(self) -> str:
        """Name for the scene's output: the stem of its file, else its title as a file name."""
        return self._stem or re.sub(r"\W+", "-", self.title[:60].lower()).strip("-") or "scene"

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a scene from a TOML file.

        Raises
        ------
        SceneError
            If the file cannot be read or does not contain a valid scene.
        """
        missing = f"no such file; to create a scene, run: fenics-yeast new {path}"
        scene = cls.from_toml(read_text(path, "a scene file", missing), source=str(path))
        scene._stem = Path(path).stem
        return scene

    @classmethod
    def from_toml(cls, text: str, source: str = "scene") -> Self:
        """Read a scene from a TOML string.

        Parameters
        ----------
        text
            The scene.
        source
            Its name in error messages; contours are read from the directory of this path.

        Raises
        ------
        SceneError
            If the string is not TOML or not a valid scene.
        """
        return cls._from_tables(parse_toml(text, source), source)

    @classmethod
    def _from_tables(cls, tables: dict[str, Any], source: str) -> Self:
        try:
            scene = cls.model_validate(tables, context={"directory": Path(source).parent})
        except ValidationError as error:
            raise SceneError(f"{source}: {explain(cls, tables, error)}") from None
        scene._source = source
        return scene

    def to_toml(self) -> str:
        """Write the scene as TOML with all defaults, in µm, MPa, min and degrees."""
        import tomli_w

        tables = self.model_dump(exclude_none=True, by_alias=True)
        if self.numerics.step is None:
            tables["numerics"]["step"] = "adaptive"
        return "# Units: µm, MPa, min, degrees.\n" + tomli_w.dumps(tables)

    def with_values(self, values: Mapping[str, object]) -> Self:
        """Return a revalidated copy with some values changed.

        Defaults follow the change: those of the preset follow `numerics.preset`, the default
        saved time follows `run.end`.

        Parameters
        ----------
        values
            Values by dotted key, such as ``{"growth.time": 30, "turgor.pressure": "1 atm"}``. A
            value may be a whole table, or None to remove an optional one.

        Raises
        ------
        SceneError
            If a key is unknown or the changed scene is not valid.
        """
        tables = self.model_dump(exclude_unset=True, by_alias=True)
        for dotted, value in values.items():
            if isinstance(value, Table):
                value = value.model_dump(exclude_unset=True, by_alias=True)
            try:
                set_value(tables, dotted, value)
            except ValueError as error:
                change = f"{dotted[:80]} = {value_text(value)}"
                raise SceneError(f"{self._source}: {change}: {error}") from None
        scene = self._from_tables(tables, self._source)
        scene._stem = self._stem
        return scene
