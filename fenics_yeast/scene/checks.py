"""What several tables of a scene must agree on."""

from collections.abc import Sequence

from ..geometry import Intervals, neck
from .cell import AnyCell, ConeCell
from .errors import refusal
from .growth import Polarity
from .loads import Load, PressureTable, Septum, Turgor
from .profile_cell import ProfileCell
from .run import Run, StaticPath
from .wall import AnyWall
from .zone import Zone, beyond, misplaced


def check_wall(wall: AnyWall, cell: AnyCell) -> None:
    """Refuse a wall too thick for its cell, and a membrane that this shape leaves without support.

    Like all checks, it raises the error of a validator, with a key below the scene.
    """
    radius = cell.least_radius
    for i, thickness in enumerate(wall.thicknesses):
        if thickness >= radius:
            least = "radius" if radius == cell.radius else "least radius"
            zone = f"zone.{i}." if i < len(wall.zone) else ""
            raise refusal(
                f"must be less than the cell's {least} ({radius:.6g} µm)",
                key=f"wall.{zone}thickness",
            )
    if wall.bending:
        return
    if isinstance(cell, ConeCell) and cell.height == 0:
        must = "a flat membrane ring carries no load; set cell.height, or wall.bending = true"
        raise refusal(must, key="wall.bending")
    if cell.ends in (("guided", "free"), ("sliding", "free")):
        must = 'must be "hinged" or "clamped" for a membrane with a free inner edge'
        raise refusal(must, key="cell.edge")


def check_outline(cell: AnyCell, turgor: Turgor) -> None:
    """Refuse the outline of a turgid cell without turgor."""
    if not isinstance(cell, ProfileCell) or cell.outline_is == "unloaded":
        return
    if turgor.initial == 0:
        must = 'expected "unloaded", or a turgor.pressure other than 0, under which it was seen'
        raise refusal(must, key="cell.outline_is")


def check_load(load: Load | None, path: StaticPath | None, cell: AnyCell, wall: AnyWall) -> None:
    """Refuse a load that the cell cannot carry, and a path that it cannot follow."""
    if path is not None:
        if path.until.of_load and load is None:
            raise refusal('this path needs a [load], e.g. point_force = "-1 uN"', key="load")
        ratio = path.until.volume_ratio
        if ratio is not None and ratio <= 0 and cell.closed:
            must = "must be > 0, as a closed cell encloses a volume"
            raise refusal(must, key="path.until.volume_ratio")
    if load is None:
        return
    if load.point_force is not None and load.pole not in cell.poles:
        raise refusal(f"{_no_pole(cell, load.pole)}; set load.ring_force", key="load.pole")
    if load.point_force is not None and not wall.bending:
        must = "a membrane cannot carry a point force; set load.ring_force, or wall.bending = true"
        raise refusal(must, key="load.point_force")
    if load.ring_force is None:
        return
    if load.at is None and cell.ends[1] != "free":
        must = "expected the arc length of the ring (µm), because the upper end is not a free edge"
        raise refusal(must, key="load.at")
    length = cell.curve.length
    if load.at is not None and load.at >= length:
        raise refusal(_short_of(length), key="load.at")


def check_span(run: Run | None, path: StaticPath | None, turgor: Turgor, grows: bool) -> None:
    """Refuse what changes in time without a time span, or on a path of equilibria."""
    if path is not None:
        for table, given in (("run", run is not None), ("growth", grows)):
            if given:
                raise refusal(f"a [path] is static; remove [path] or [{table}]", key=table)
    if run is None and isinstance(turgor.pressure, PressureTable):
        must = 'a time-dependent pressure needs [run], e.g. end = "90 min"'
        raise refusal(must, key="turgor.pressure")
    if run is None and grows:
        raise refusal('growth needs [run], e.g. end = "90 min"', key="run")


def check_zones(zones: Sequence[Zone], cell: AnyCell, key: str) -> None:
    """Refuse zones that are not on the cell or overlap; `key` has a place for their number."""
    for i, zone in enumerate(zones):
        _check_pole(zone.pole, cell, key.format(i))
    if len(zones) == 0 or (len(zones) == 1 and zones[0].pole in ("top", "bottom")):
        return  # without the cost of the curve
    if (found := misplaced(zones, cell.curve)) is not None:
        raise refusal(found[1], key=key.format(found[0]))


def check_polarity(polarity: Polarity, cell: AnyCell, key: str) -> None:
    """Refuse a polarity around a point that is not on the cell."""
    if polarity.centre is None:
        _check_pole(polarity.pole, cell, key)
    elif polarity.centre > (length := cell.curve.length):
        raise refusal(beyond(length), key=f"{key}.centre")


def check_septum(septum: Septum, load: Load | None, cell: AnyCell, growing: Intervals) -> None:
    """Refuse a septum that is not across a closed cell, or has no definite place."""
    if not cell.closed:
        raise refusal(f"requires a closed cell; a {cell.shape} is open", key="septum")
    if septum.piece is not None and load is not None:
        raise refusal("a separated piece carries no load; remove [load]", key="septum.piece")
    curve = cell.curve
    if septum.at is None and neck(growing, curve) is None:
        must = "expected an arc length (µm), because the cell has no bud neck, or more than one"
        raise refusal(must, key="septum.at")
    if septum.at is not None and septum.at >= curve.length:
        raise refusal(_short_of(curve.length), key="septum.at")


def _check_pole(pole: str | None, cell: AnyCell, key: str) -> None:
    for each in ("top", "bottom") if pole == "both" else (pole,):
        if each is not None and each not in cell.poles:
            raise refusal(_no_pole(cell, each), key=f"{key}.pole")


def _no_pole(cell: AnyCell, pole: str) -> str:
    has = f"its poles: {', '.join(cell.poles)}" if cell.poles else "it has none"
    return f"a {cell.shape} has no {pole} pole ({has})"


def _short_of(length: float) -> str:
    return f"must be less than the meridian's length ({length:.6g} µm)"
