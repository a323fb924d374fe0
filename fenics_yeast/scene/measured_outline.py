"""Measured outlines of a growing cell: contours by time, and how they were traced."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..geometry import Array, ContourError, read_contours
from .errors import SceneError

_TIMED = re.compile(r"(\d+(?:\.\d+)?)\s*(min|h|s)(?![a-z])", re.IGNORECASE)
_MINUTES = {"min": 1.0, "h": 60.0, "s": 1 / 60}
_NO_TIME = (
    'has no column time, and its name no time such as "30min"; give times, one for each file in '
    "the order of their names"
)


@dataclass(frozen=True)
class Outline:
    """A measured outline of a cell at one time.

    Attributes
    ----------
    time
        When it was traced, in min.
    r, z
        Points in µm, from bottom to top or any part of it.
    source
        Name of its file.
    """

    time: float
    r: tuple[float, ...]
    z: tuple[float, ...]
    source: str = ""

    @property
    def points(self) -> Array:
        """The points `(r, z)` in µm, shape ``(n, 2)``."""
        return np.column_stack([self.r, self.z])


@dataclass(frozen=True)
class MeasuredOutlines:
    """Outlines of one cell, to be compared with a run.

    Attributes
    ----------
    outlines
        In order of time.
    noise
        Standard deviation of the distance of a point in µm.
    offset
        Time in min on the clock of the outlines at which the run begins.
    set
        How this experiment differed: values by dotted keys of the scene.
    """

    outlines: tuple[Outline, ...]
    noise: float = 1.0
    offset: float = 0.0
    set: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.outlines:
            raise SceneError("expected at least one outline")
        if not self.noise > 0:
            raise SceneError(f"noise = {self.noise:g}: expected a length > 0 (µm)")
        if (first := self.outlines[0]).time < self.offset:
            raise SceneError(
                f"{first.source or 'outline'}: {first.time:g} min is before the run begins; set "
                "offset to the time at which growth began"
            )

    @classmethod
    def read(
        cls,
        pattern: str | Path,
        *,
        noise: float,
        times: Sequence[float] | None = None,
        scale: float | None = None,
        offset: float = 0.0,
        set: Mapping[str, object] | None = None,
    ) -> MeasuredOutlines:
        """Read outlines from a file or many.

        Parameters
        ----------
        pattern
            A file with the columns ``r`` and ``z`` as for a cell (see `geometry.read_contour`), and
            perhaps ``time``; or a pattern of many, such as ``"frames/*.csv"``.
        times
            Time in min of each file, in the order of their names with numbers in order of size. By
            default they are in a column, or in the names: ``cell_30min.csv``.
        scale
            Length in µm of a unit of the columns, such as a pixel; by default they are in µm.
        noise, offset, set
            See the attributes.

        Raises
        ------
        SceneError
            If there is no such file, one cannot be read, a time is missing or before the run.
        """
        return cls(_outlines(Path(pattern), times, scale), noise, offset, set or {})

    @property
    def times(self) -> tuple[float, ...]:
        """Times in min of the run at which it must be saved."""
        return tuple(dict.fromkeys(outline.time - self.offset for outline in self.outlines))


def _outlines(
    pattern: Path, times: Sequence[float] | None, scale: float | None
) -> tuple[Outline, ...]:
    """Return the outlines of a file or many, in order of time."""
    files = _files(pattern)
    if times is not None and len(times) != len(files):
        raise SceneError(
            f"{pattern}: {len(files)} files, but {len(times)} times; give one for each"
        )
    found: list[Outline] = []
    for i, file in enumerate(files):
        try:
            contours = read_contours(file, scale)
        except ContourError as error:
            raise SceneError(f"{file}: {error}") from None
        for contour in contours:
            time = contour.time
            if times is not None:
                if len(contours) > 1:
                    raise SceneError(f"{file}: has a column of times already; omit times")
                time = times[i]
            time = _time_in(file.stem) if time is None else time
            if time is None:
                raise SceneError(f"{file}: {_NO_TIME}")
            found.append(Outline(time, contour.r, contour.z, file.name))
    return tuple(sorted(found, key=lambda outline: outline.time))


def _files(pattern: Path) -> list[Path]:
    """Return the files of a pattern, those of no pattern as they are; numbers by their size."""
    if not any(mark in str(pattern) for mark in "*?["):
        return [pattern]
    start = Path(pattern.anchor) if pattern.is_absolute() else Path()
    files = [path for path in start.glob(str(pattern.relative_to(start))) if path.is_file()]
    if not files:
        raise SceneError(f"{pattern}: no file has such a name")
    return sorted(files, key=_in_order)


def _in_order(path: Path) -> list[tuple[bool, float, str]]:
    pieces = re.split(r"(\d+)", str(path))
    return [(not p.isdecimal(), float(p) if p.isdecimal() else 0.0, p) for p in pieces if p]


def _time_in(name: str) -> float | None:
    """Return the only time in a file name, in min; None if there is none, or more."""
    found = _TIMED.findall(name)
    if len(found) != 1:
        return None
    number, unit = found[0]
    return float(number) * _MINUTES[unit.lower()]
