"""Outlines of a growing cell as data: measured contours, and their distances from computed ones."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..geometry import (
    Array,
    ContourError,
    Distances,
    Parametric,
    aligned_distances,
    curve_through,
    read_contours,
    signed_distances,
)
from ..scene import SceneError
from ..simulation import Profile, Profiles

_ON_AXIS = 1e-9  # of the largest radius: an end that is a pole
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
        When it was traced, in min of the run.
    points
        `(r, z)` in µm, from bottom to top or any part of it, shape ``(n, 2)``.
    source
        Name of its file.
    """

    time: float
    points: Array
    source: str = ""

    def distances(self, profile: Profile, *, shift: float | None = None) -> Distances:
        """Return the distances of the points from a computed profile.

        Parameters
        ----------
        profile
            The wall at the time of the outline.
        shift
            What to add to the heights of the points, in µm; by default, what makes the root mean
            square distance least, since the image does not know where a run has its lower end.
        """
        curve = meridian_of(profile)
        if shift is None:
            return aligned_distances(curve, self.points)
        moved = self.points + np.array([0.0, shift])
        return signed_distances(curve, moved)._replace(shift=shift)


@dataclass(frozen=True)
class OutlineData:
    """Outlines of one cell, to be fitted by a run.

    Attributes
    ----------
    outlines
        In order of time.
    noise
        Standard deviation of the distance of a point in µm.
    """

    outlines: tuple[Outline, ...]
    noise: float = 1.0

    @property
    def times(self) -> tuple[float, ...]:
        """Times in min that a run must save."""
        return tuple(dict.fromkeys(outline.time for outline in self.outlines))

    def residuals(self, profiles: Profiles, offset: float = 0.0) -> Array:
        """Return the distances of all points over the noise, outline by outline, shape ``(n,)``.

        Each outline is shifted along the axis to where it fits best.

        Parameters
        ----------
        profiles
            Those of a run.
        offset
            Time in min of the run at which the clock of the outlines shows 0.

        Raises
        ------
        KeyError
            If the run has not saved one of the times.
        """
        found = [
            outline.distances(profiles.at(outline.time + offset)).distance
            for outline in self.outlines
        ]
        return np.concatenate(found) / self.noise


def meridian_of(profile: Profile) -> Parametric:
    """Return the smooth curve through the nodes of a profile, by reference arc length."""
    r, S = profile.r, profile.S - profile.S[0]
    axis = _ON_AXIS * r.max()
    poles = bool(r[0] <= axis), bool(r[-1] <= axis)
    return curve_through(S, np.column_stack([r, profile.z]), poles)


def read_outlines(
    pattern: str | Path,
    *,
    times: Sequence[float] | None = None,
    scale: float | None = None,
) -> tuple[Outline, ...]:
    """Read measured outlines, in order of time.

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

    Raises
    ------
    SceneError
        If there is no such file, one cannot be read, or a time is missing.
    """
    files = _files(Path(pattern))
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
            found.append(Outline(time, np.column_stack([contour.r, contour.z]), file.name))
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
