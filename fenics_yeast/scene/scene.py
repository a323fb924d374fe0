"""What to simulate: a typed, validated, unit-aware scene, read from TOML and written back.

Inside a scene every quantity is a plain number: lengths in µm, pressures and stresses in MPa,
times in min, angles in degrees. Strings with a unit (``"100 nm"``, ``"2 atm"``, ``"45 min"``) are
converted on the way in. Whatever is wrong with a scene is a `SceneError` of one line.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from ..geometry import Intervals, neck
from .cell import AnyCell
from .errors import SceneError, refusal, value_text
from .explain import explain
from .growth import Growth, OneOrMore, Polarity
from .keys import set_value
from .load import Load
from .numerics import PRESETS, Numerics, elements_for
from .run import Run, StaticPath
from .septum import Septum
from .table import Table
from .turgor import PressureTable, Turgor
from .wall import AnyWall
from .zone import Zone, misplaced


class Scene(Table):
    """What to simulate: one cell, its wall, turgor and growth, and how to solve it.

    Two scenes are equal when all their values are, whatever they are called.
    """

    title: str = Field(
        default="", description="title of figures, and the name unless read from a file"
    )
    cell: AnyCell = Field(description="shape of the unloaded cell")
    wall: AnyWall = Field(description="the cell wall")
    turgor: Turgor = Field(description="pressure inside the cell")
    axial_load: Load | None = Field(  # `load` reads a file
        default=None, alias="load", description="a force along the axis; None: turgor alone"
    )
    growth: OneOrMore | None = Field(
        default=None, description="growth of the wall, of one zone or more; None: an elastic scene"
    )
    septum: Septum | None = Field(
        default=None, description="where the cell separates into two; None: it does not"
    )
    run: Run | None = Field(default=None, description="time span; None: a single equilibrium")
    path: StaticPath | None = Field(
        default=None, description="path of equilibria, in place of a time span"
    )
    numerics: Numerics = Field(
        default_factory=lambda: Numerics(), description="how the scene is solved"
    )

    _stem: str = PrivateAttr("")
    _source: str = PrivateAttr("scene")

    @model_validator(mode="after")
    def _tables_agree(self) -> Self:
        radius = self.cell.least_radius
        for i, thickness in enumerate(self.wall.thicknesses):
            if thickness >= radius:
                least = "radius" if radius == self.cell.radius else "least radius"
                allowed = f"a thickness less than the cell's {least} ({radius:.6g} µm) is wanted"
                zone = f"zone.{i}." if i < len(self.wall.zone) else ""
                raise refusal("", allowed=allowed, key=f"wall.{zone}thickness")
        if not self.wall.bending and not self.cell.stiff_without_bending:
            allowed = "a flat ring without bending bears nothing; give it a height, or bending"
            raise refusal("", allowed=allowed, key="wall.bending")
        if not self.wall.bending and self.cell.ends in (("roller", "free"), ("axial", "free")):
            allowed = "hinged or clamped: a membrane with a free edge pulls the other one inwards"
            raise refusal("", allowed=allowed, key="cell.edge")
        self._bears_its_load()
        if self.path is not None:
            for table in ("run", "growth"):
                if getattr(self, table) is not None:
                    allowed = f"a [path] is static: leave out [path] or [{table}]"
                    raise refusal("", allowed=allowed, key=table)
        if self.run is None and isinstance(self.turgor.pressure, PressureTable):
            allowed = 'a pressure that changes needs a [run] table, e.g. end = "90 min"'
            raise refusal("", allowed=allowed, key="turgor.pressure")
        if self.growth is not None and self.run is None:
            allowed = 'growth needs a [run] table with an end time, e.g. end = "90 min"'
            raise refusal("", allowed=allowed, key="run")
        self._have_places(self.wall.zone, "wall.zone.{}")
        key = "growth.{}.zone" if isinstance(self.growth, tuple) else "growth.zone"
        self._have_places([growth.zone for growth in self.growing], key)
        for i, growth in enumerate(self.growing):
            if growth.polarity is not None:
                self._has_centre(growth.polarity, key.format(i).replace("zone", "polarity"))
        if self.septum is not None:
            self._can_separate(self.septum)
        return self

    def _bears_its_load(self) -> None:
        """Refuse a load that the cell has no place for, and paths that it cannot follow."""
        load, path, shape = self.axial_load, self.path, self.cell.shape
        if path is not None:
            if path.until.of_load and load is None:
                allowed = 'a table [load] is wanted, e.g. point_force = "-1 uN"'
                raise refusal("", allowed=allowed, key="load")
            ratio = path.until.volume_ratio
            if ratio is not None and ratio <= 0 and self.cell.closed:
                allowed = "a number greater than 0 is wanted: a closed cell keeps a volume"
                raise refusal("", allowed=allowed, key="path.until.volume_ratio")
        if load is None:
            return
        if load.point_force is not None and load.pole not in self.cell.poles:
            allowed = f"a {shape} has no {load.pole} pole; give it a ring_force"
            raise refusal("", allowed=allowed, key="load.pole")
        if load.point_force is not None and not self.wall.bending:
            allowed = "a membrane gives way to a point force; give it a ring_force, or bending"
            raise refusal("", allowed=allowed, key="load.point_force")
        if load.ring_force is None:
            return
        if load.at is None and self.cell.ends[1] != "free":
            allowed = "the arc length of the ring is wanted: the upper end is no free edge"
            raise refusal("", allowed=allowed, key="load.at")
        length = self.cell.curve.length
        if load.at is not None and load.at >= length:
            allowed = f"an arc length less than that of the meridian ({length:.6g} µm) is wanted"
            raise refusal("", allowed=allowed, key="load.at")

    @model_validator(mode="after")
    def _fit_elements(self) -> Self:
        """Give the number of elements that this scene needs, unless one was asked for."""
        numerics = self.numerics
        given = numerics.model_fields_set
        if "elements" in given or PRESETS[numerics.preset].elements is not None:
            return self
        zones = [growth.zone for growth in self.growing]
        layers = self.cell.layers + sum(zone.layers for zone in (*zones, *self.wall.zone))
        tips = [growth for growth in self.growing if growth.polarity is not None]
        layers += 2 * sum(growth.zone.parts for growth in tips)
        if self.axial_load is not None:
            layers += 2 if self.cell.closed else 1  # the load, and the pole that bears it
        elements = elements_for(numerics.tolerance, sum(zone.parts for zone in zones), layers)
        values = dict(numerics) | {"elements": elements}
        self.__dict__["numerics"] = Numerics.model_construct(given, **values)  # frozen
        return self

    def _have_places(self, zones: Sequence[Zone], key: str) -> None:
        """Refuse zones that are not on the cell or overlap; their key has a place for a number."""
        for i, zone in enumerate(zones):
            for pole in ("top", "bottom") if zone.pole == "both" else (zone.pole,):
                self._has_pole(pole, key.format(i))
        if len(zones) == 0 or (len(zones) == 1 and zones[0].pole in ("top", "bottom")):
            return  # which asks for no reference curve
        if (found := misplaced(zones, self.cell.curve)) is not None:
            raise refusal("", allowed=found[1], key=key.format(found[0]))

    def _has_centre(self, polarity: Polarity, key: str) -> None:
        """Refuse a polarity around a point that is not on the cell."""
        if polarity.centre is None:
            for pole in ("top", "bottom") if polarity.pole == "both" else (polarity.pole,):
                self._has_pole(pole, key)
            return
        length = self.cell.curve.length
        if polarity.centre > length:
            allowed = f"the meridian ends at {length:.6g} µm"
            raise refusal("", allowed=allowed, key=f"{key}.centre")

    def _can_separate(self, septum: Septum) -> None:
        """Refuse a septum that is not across a closed cell, or has no place of its own."""
        if not self.cell.closed:
            allowed = f"a closed cell is wanted, and a {self.cell.shape} is none"
            raise refusal("", allowed=allowed, key="septum")
        if septum.piece is not None and self.axial_load is not None:
            raise refusal("", allowed="a piece bears no load: leave out [load]", key="septum.piece")
        curve = self.cell.curve
        if septum.at is None and neck(self.growing_parts, curve) is None:
            allowed = "an arc length is wanted where there is no neck, or more than one"
            raise refusal("", allowed=allowed, key="septum.at")
        if septum.at is not None and septum.at >= curve.length:
            allowed = f"the meridian ends at {curve.length:.6g} µm"
            raise refusal("", allowed=allowed, key="septum.at")

    def _has_pole(self, pole: str | None, key: str) -> None:
        if pole is not None and pole not in self.cell.poles:
            allowed = f"a {self.cell.shape} has no {pole} pole"
            raise refusal("", allowed=allowed, key=f"{key}.pole")

    @property
    def growing(self) -> tuple[Growth, ...]:
        """Growth of each zone; empty for an elastic scene."""
        if self.growth is None:
            return ()
        return self.growth if isinstance(self.growth, tuple) else (self.growth,)

    @property
    def growing_parts(self) -> Intervals:
        """Parts of the meridian that grow, those of each zone after the other."""
        curve = self.cell.curve
        return tuple(part for growth in self.growing for part in growth.zone.intervals(curve))

    @property
    def growth_time(self) -> float | None:
        """Least characteristic time of growth (min); None for an elastic scene."""
        return min((growth.time for growth in self.growing), default=None)

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
            scene = cls.model_validate(tables, context={"folder": Path(source).parent})
        except ValidationError as error:
            raise SceneError(f"{source}: {explain(cls, tables, error)}") from None
        scene._source = source
        return scene

    def to_toml(self) -> str:
        """Write the scene as TOML with every default spelled out, in µm, MPa, min and degrees."""
        import tomli_w

        tables = self.model_dump(exclude_none=True, by_alias=True)
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
        tables = self.model_dump(exclude_unset=True, by_alias=True)
        for dotted, value in values.items():
            if isinstance(value, Table):
                value = value.model_dump(exclude_unset=True)
            try:
                set_value(tables, dotted, value)
            except ValueError as error:
                change = f"{dotted[:80]} = {value_text(value)}"
                raise SceneError(f"{self._source}: {change}: {error}") from None
        scene = self._from_tables(tables, self._source)
        scene._stem = self._stem
        return scene
