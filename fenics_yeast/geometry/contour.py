"""Contours traced in a microscope: read, checked, and smoothed into a reference meridian."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .curves import Parametric

Array = NDArray[np.float64]

_FEWEST, _MOST = 8, 5000  # points
_DEGREE = 5  # of the spline: its curvature has two continuous derivatives
_SHARP = 2.0  # least radius of curvature, in tolerances or distances of points
_NOISE = 4.0  # tolerances that a point may lie beyond the axis
_DRAWN = 1500  # points of the smooth curve that are looked at


class ContourError(ValueError):
    """What is wrong with a contour, as the end of a sentence that begins with it."""


def read_contour(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Points `(r, z)` of a table of two columns in µm, under the heading ``r,z``.

    Raises
    ------
    ContourError
        If the file cannot be read or is no such table; the message is a sentence of its own.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except FileNotFoundError:
        raise ContourError(f"no such file beside the scene: {path.absolute()}") from None
    except (OSError, ValueError) as error:
        raise ContourError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    rows = [(i, line) for i, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    names = [name.strip().lower() for name in rows[0][1].split(",")] if rows else []
    if not {"r", "z"} <= set(names):
        raise ContourError('a table of µm with the heading "r,z" is wanted, a point in each line')
    columns = names.index("r"), names.index("z")
    points = []
    for number, line in rows[1:]:
        cells = line.split(",")
        try:
            point = tuple(float(cells[i]) for i in columns)
        except (ValueError, IndexError):
            raise ContourError(f"line {number} has no two numbers") from None
        if not np.isfinite(point).all():
            raise ContourError(f"line {number} is not finite")
        points.append(point)
    if not points:
        raise ContourError("has no points")
    r, z = zip(*points, strict=True)
    return r, z


@lru_cache(maxsize=8)
def smooth_contour(r: tuple[float, ...], z: tuple[float, ...], tolerance: float) -> Parametric:
    """Meridian through a contour, by a periodic spline through it and its mirror image.

    The curve is symmetric about the axis, so that a wall is smooth at its poles. Its knots are as
    few as the tolerance allows.

    Parameters
    ----------
    r, z
        Points in µm from the bottom pole to the top pole.
    tolerance
        Root mean square distance of the points from the curve in µm; 0 goes through all of them.

    Raises
    ------
    ContourError
        If the contour is open, crossing, unordered or kinked.
    """
    points = np.array([r, z], dtype=float).T
    points = points[np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))]
    _check(points, tolerance)
    points[[0, -1], 0] = 0
    curve = _fit(points, tolerance)
    t = np.linspace(0, curve.end, _DRAWN + 1)
    drawn = np.column_stack(curve.point(t, 0))
    if (crossing := _crossing(drawn)) is not None:
        raise ContourError(
            f"crosses itself {_near(drawn[crossing])}, or its points are out of order; they run "
            "along the wall from the bottom to the top"
        )
    i = int(np.argmin(drawn[1:-1, 0])) + 1
    if drawn[i, 0] <= 0:
        raise ContourError(f"meets the axis {_near(drawn[i])}; between its ends r > 0 is wanted")
    bends = np.abs(curve.curvature_at(t))
    finest = _SHARP * max(tolerance, float(np.median(_steps(points))))
    if bends.max() * finest > 1:
        i = int(np.argmax(bends))
        raise ContourError(
            f"is kinked {_near(drawn[i])}: it bends with a radius of {1 / bends[i]:.2g} µm; give a "
            "larger tolerance or more points"
        )
    return curve


def _check(points: Array, tolerance: float) -> None:
    if not _FEWEST <= len(points) <= _MOST:
        raise ContourError(f"has {len(points)} points; from {_FEWEST} to {_MOST} are wanted")
    near = max(tolerance, 1e-6 * float(np.ptp(points)))
    for i, name in ((0, "first"), (-1, "last")):
        if abs(points[i, 0]) > near:
            raise ContourError(
                f"is open: its {name} point lies {abs(points[i, 0]):.3g} µm from the axis; both "
                "ends lie on the axis, r = 0"
            )
    if points[:, 0].min() < -_NOISE * near:
        i = int(np.argmin(points[:, 0]))
        raise ContourError(f"meets the axis {_near(points[i])}; between its ends r > 0 is wanted")
    if points[0, 1] >= points[-1, 1]:
        raise ContourError("is unordered: it runs from top to bottom; turn the rows round")


def _crossing(points: Array) -> int | None:
    """Index of a segment that another one, not its neighbour, crosses."""
    a, d = points[:-1], np.diff(points, axis=0)
    for i in range(len(a) - 2):
        b, e = a[i + 2 :], d[i + 2 :]
        gap = b - a[i]
        area = d[i, 0] * e[:, 1] - d[i, 1] * e[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (gap[:, 0] * e[:, 1] - gap[:, 1] * e[:, 0]) / area
            t = (gap[:, 0] * d[i, 1] - gap[:, 1] * d[i, 0]) / area
        if ((s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)).any():
            return i
    return None


def _fit(points: Array, tolerance: float) -> Parametric:
    from scipy.interpolate import splev, splprep  # late: 0.2 s, and few scenes have a contour

    mirrored = points[-2::-1] * (-1, 1)  # down the other side, the bottom pole again at the end
    outline = np.concatenate([points, mirrored])
    along = np.concatenate([[0.0], np.cumsum(_steps(outline))])
    total = along[-1]
    smoothing = (len(outline) - 1) * tolerance**2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of points that will turn out to cross
        knots, _ = splprep(outline.T, u=along / total, k=_DEGREE, s=smoothing, per=1)

    def point(t: Array, order: int) -> tuple[Array, Array]:
        """Mean of the spline and its mirror image, which differ by the choice of knots."""
        u = np.asarray(t) / total
        r, z = (np.reshape(x, u.shape) for x in splev(u.ravel() % 1, knots, der=order))
        sign = (-1) ** order
        r_m, z_m = (np.reshape(x, u.shape) for x in splev(-u.ravel() % 1, knots, der=order))
        return (r - sign * r_m) / 2 / total**order, (z + sign * z_m) / 2 / total**order

    return Parametric(point, total / 2)


def _steps(points: Array) -> Array:
    return np.hypot(*np.diff(points, axis=0).T)


def _near(point: Sequence[float] | Array) -> str:
    return f"near r = {point[0]:.3g}, z = {point[1]:.3g} µm"
