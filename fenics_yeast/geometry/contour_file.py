"""Read the points of a contour, as programs for images and tables write them."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .curves import Array

_LARGEST_FILE = 10_000_000  # bytes
_HEADING = 'expected the heading "r,z" and one point per line'
_NAME = re.compile(r"([rz])[\s_]*[\[(/]?\s*([a-zµμ]*)\s*[\])]?", re.IGNORECASE)
_UNITS = {"µm": 1.0, "μm": 1.0, "um": 1.0, "micron": 1.0, "microns": 1.0, "nm": 1e-3}
_PIXELS = ("px", "pixel", "pixels")
_TIME = re.compile(r"(?:time|t)[\s_]*[\[(/]?\s*(min|h|s|sec)?\s*[\])]?", re.IGNORECASE)
_MINUTES = {"": 1.0, "min": 1.0, "h": 60.0, "s": 1 / 60, "sec": 1 / 60}
_CLOSED = 3.0  # steps between its points: ends that are closer to each other close an outline
_SAME = 1e-6  # of the median distance of points: a point given twice
_ALIKE = 0.1  # of the radius: how far the two halves of an outline may be from each other


class ContourError(ValueError):
    """What is wrong with a contour, as the end of a sentence that begins with it."""


class Contour(NamedTuple):
    """Points `(r, z)` in µm of a contour, and when it was traced, in min, if its table says so."""

    r: tuple[float, ...]
    z: tuple[float, ...]
    time: float | None = None


def read_contour(
    path: Path, scale: float | None = None
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Read the points `(r, z)` in µm of a table with the columns ``r`` and ``z``.

    Columns are separated by commas, semicolons, tabs or spaces; their names may be quoted and have
    a unit, as in ``r [µm]``. A closed outline is folded about its vertical axis: its half is the
    mean of both.

    Parameters
    ----------
    path
        The file: UTF-8, UTF-16 with a byte order mark, or Latin-1.
    scale
        Length in µm of a unit of the columns, such as a pixel; by default they are in µm.

    Raises
    ------
    ContourError
        If the file cannot be read or is no such table; the message is a sentence of its own.
    """
    points, _ = _table(path, scale)
    return _folded(points)[:2]


def read_contours(path: Path, scale: float | None = None) -> list[Contour]:
    """Read the contours of a table that may also have a column ``time``, ``t_min`` or ``t [h]``.

    Lines of one time are one contour, wherever they are; without the column there is one, of
    unknown time. Parameters and errors are those of `read_contour`.
    """
    points, times = _table(path, scale)
    if times is None:
        return [_folded(points)]
    return [_folded(points[times == time], float(time)) for time in np.unique(times)]


def _folded(points: Array, time: float | None = None) -> Contour:
    r, z = _half(points).T.tolist()
    return Contour(tuple(r), tuple(z), time)


def _table(path: Path, scale: float | None) -> tuple[Array, Array | None]:
    """Return the points of a table, and their times in min if it has them."""
    rows = [
        (number, line.strip())
        for number, line in enumerate(_text(path).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise ContourError(f"has no points; {_HEADING}")
    heading = rows[0][1]
    mark = next((mark for mark in (";", "\t", ",") if mark in heading), None)
    columns = _columns(heading, mark, scale)
    timed = len(columns) > 2
    points = []
    for number, line in rows[1:]:
        cells = [cell.strip(" \"'") for cell in line.split(mark)]
        try:
            point = [factor * _number(cells[place], mark) for place, factor in columns]
        except (ValueError, IndexError):
            names = "r, z and time" if timed else "r and z"
            raise ContourError(
                f'line {number}: found "{line[:40]}"; expected a number for {names}'
            ) from None
        if not np.isfinite(point).all():
            raise ContourError(f"line {number}: numbers must be finite")
        points.append(point)
    if not points:
        raise ContourError("has no points below its heading")
    table = np.array(points)
    return table[:, :2], table[:, 2] if timed else None


def _text(path: Path) -> str:
    try:
        with open(path, "rb") as file:
            content = file.read(_LARGEST_FILE + 1)
    except FileNotFoundError:
        raise ContourError(f"no such file beside the scene: {path.absolute()}") from None
    except (OSError, ValueError) as error:
        raise ContourError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > _LARGEST_FILE:
        raise ContourError("is larger than 10 MB; expected a table of points")
    wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    for encoding in ("utf-16",) if wide else ("utf-8-sig", "latin-1"):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise ContourError("is damaged: expected UTF-8, UTF-16 or Latin-1")


def _columns(heading: str, mark: str | None, scale: float | None) -> list[tuple[int, float]]:
    """Return place and unit in µm of the columns r and z, and in min of a column of times."""
    found: dict[str, tuple[int, float]] = {}
    cells = heading.split(mark) if mark else re.findall(r"\w+\s*[\[(][^\])]*[\])]|\S+", heading)
    for place, cell in enumerate(cells):
        cell = cell.strip(" \"'")
        if time := _TIME.fullmatch(cell):
            found.setdefault("time", (place, _MINUTES[(time[1] or "").lower()]))
        name = _NAME.fullmatch(cell)
        if name is None:
            continue
        unit = name[2].lower()
        if unit and unit not in (*_UNITS, *_PIXELS):
            raise ContourError(f'has the unit "{unit}" in its heading; expected µm, nm or px')
        if unit in _PIXELS and scale is None:
            raise ContourError('is in pixels; set cell.scale to the size of one, e.g. "65 nm"')
        if unit in _UNITS and scale is not None:
            raise ContourError(f"is in {unit}, says its heading; remove cell.scale")
        found[name[1].lower()] = (place, _UNITS.get(unit, 1.0) if scale is None else scale)
    if not {"r", "z"} <= found.keys():
        raise ContourError(f'begins with "{heading[:40]}"; {_HEADING}')
    return [found[name] for name in ("r", "z", "time") if name in found]


def _number(text: str, mark: str | None) -> float:
    """Read a number, with a decimal comma where commas separate no columns."""
    return float(text.replace(",", ".") if mark != "," and "." not in text else text)


def _half(points: Array) -> Array:
    """Return the meridian of a closed outline, from bottom to top; other points as they are."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    if len(points) < 8 or np.hypot(*(points[-1] - points[0])) > _CLOSED * np.median(steps):
        return points
    ahead = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    points = points[ahead > _SAME * np.median(steps)]
    following = np.roll(points, -1, axis=0)
    areas = points[:, 0] * following[:, 1] - following[:, 0] * points[:, 1]
    centre = ((points[:, 0] + following[:, 0]) @ areas) / (3 * areas.sum())
    points = points - (centre, 0.0)
    following = following - (centre, 0.0)
    crossing = np.flatnonzero((points[:, 0] < 0) != (following[:, 0] < 0))
    if len(crossing) != 2:
        raise ContourError(
            f"is a closed outline that meets its vertical axis at {len(crossing)} places; "
            "expected 2: rotate it until its axis is vertical"
        )
    halves = [half if half[0, 1] < half[-1, 1] else half[::-1] for half in _cut(points, crossing)]
    halves = [half * (np.sign(half[:, 0].sum()), 1) for half in halves]
    apart = float(np.hypot(*(halves[0] - halves[1]).T).max())
    if apart > _ALIKE * halves[0][:, 0].max():
        raise ContourError(
            f"is a closed outline whose halves are up to {apart:.2g} µm apart; rotate it until its "
            "axis is vertical, or give one half"
        )
    return np.mean(halves, axis=0)


def _cut(points: Array, crossing: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return both halves of a closed outline between its two crossings of r = 0.

    They have as many points, evenly spread on a cubic spline: on chords a cell would be smaller.
    """
    from scipy.interpolate import CubicSpline  # late: 0.2 s, and few scenes have a contour

    closed = np.concatenate([points, points[:1]])
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(closed, axis=0).T)))
    curve = CubicSpline(along, closed, bc_type="periodic")
    roots = CubicSpline(along, closed[:, 0], bc_type="periodic").roots(extrapolate=False)
    first, second = (roots[(along[i] <= roots) & (roots <= along[i + 1])][0] for i in crossing)
    ends = (first, second), (second, first + along[-1])
    one, other = (curve(np.linspace(*part, len(points) // 2 + 1)) for part in ends)
    for half in (one, other):
        half[[0, -1], 0] = 0.0  # but for round-off
    return one, other
