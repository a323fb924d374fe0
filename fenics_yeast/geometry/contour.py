"""Contours traced in a microscope: read, checked, and smoothed into a reference meridian."""

import warnings
from functools import lru_cache
from pathlib import Path

import numpy as np

from .curves import Array, Parametric

_LARGEST_FILE = 10_000_000  # bytes
_FEWEST, _MOST = 8, 5000  # points
_DEGREE = 5  # of the spline: its curvature has two continuous derivatives
_SHARP = 2.0  # least radius of curvature, in tolerances or distances of points
_NOISE = 4.0  # tolerances by which a point may lie beyond the axis
_SAMPLES = 1500  # of the smooth curve, in which crossings and kinks are looked for


class ContourError(ValueError):
    """What is wrong with a contour, as the end of a sentence that begins with it."""


def read_contour(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Read the points `(r, z)` in µm of a table with the columns ``r,z``.

    Raises
    ------
    ContourError
        If the file cannot be read or is no such table; the message is a sentence of its own.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(_LARGEST_FILE + 1)
        if len(content) > _LARGEST_FILE:
            raise ContourError("is larger than 10 MB; expected a table of points")
        lines = content.decode("utf-8-sig").splitlines()
    except FileNotFoundError:
        raise ContourError(f"no such file beside the scene: {path.absolute()}") from None
    except (OSError, ValueError) as error:
        raise ContourError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    rows = [(i, line) for i, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    names = [name.strip().lower() for name in rows[0][1].split(",")] if rows else []
    if not {"r", "z"} <= set(names):
        raise ContourError('expected a table in µm with the heading "r,z" and one point per line')
    points = []
    for number, line in rows[1:]:
        try:
            r, z = (float(line.split(",")[names.index(name)]) for name in "rz")
        except (ValueError, IndexError):
            raise ContourError(f"line {number}: expected two numbers") from None
        if not np.isfinite([r, z]).all():
            raise ContourError(f"line {number}: not finite")
        points.append((r, z))
    if not points:
        raise ContourError("has no points")
    return tuple(r for r, _ in points), tuple(z for _, z in points)


@lru_cache(maxsize=8)
def smooth_contour(r: tuple[float, ...], z: tuple[float, ...], tolerance: float) -> Parametric:
    """Fit a meridian to a contour, by a periodic spline through it and its mirror image.

    The curve is symmetric about the axis, so that a wall is smooth at its poles. It has as few
    knots as the tolerance allows.

    Parameters
    ----------
    r, z
        Points in µm from the bottom pole to the top pole.
    tolerance
        Root mean square distance of the points from the curve in µm; 0 interpolates them.

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
    t = np.linspace(0, curve.end, _SAMPLES + 1)
    samples = np.column_stack(curve.point(t, 0))
    if (crossing := _crossing(samples)) is not None:
        raise ContourError(
            f"crosses itself {_near(samples[crossing])}, or its points are out of order; they must "
            "follow the wall from bottom to top"
        )
    i = int(np.argmin(samples[1:-1, 0])) + 1
    if samples[i, 0] <= 0:
        raise ContourError(f"meets the axis {_near(samples[i])}; r must be > 0 between its ends")
    bends = np.abs(curve.curvature_at(t))
    finest = _SHARP * max(tolerance, float(np.median(_steps(points))))
    if bends.max() * finest > 1:
        i = int(np.argmax(bends))
        raise ContourError(
            f"has a kink {_near(samples[i])}, with a radius of curvature of {1 / bends[i]:.2g} µm; "
            "increase the tolerance or add points"
        )
    return curve


def _check(points: Array, tolerance: float) -> None:
    if not _FEWEST <= len(points) <= _MOST:
        raise ContourError(f"has {len(points)} points; expected {_FEWEST} to {_MOST}")
    near = max(tolerance, 1e-6 * float(np.ptp(points)))
    for name, r in (("first", abs(points[0, 0])), ("last", abs(points[-1, 0]))):
        if r > near:
            raise ContourError(
                f"is open: its {name} point is {r:.3g} µm from the axis; both ends must be at r = 0"
            )
    i = int(np.argmin(points[:, 0]))
    if points[i, 0] < -_NOISE * near:
        raise ContourError(f"meets the axis {_near(points[i])}; r must be > 0 between its ends")
    if points[0, 1] >= points[-1, 1]:
        raise ContourError("runs from top to bottom; reverse the order of its points")


def _crossing(points: Array) -> int | None:
    """Return the index of a segment that another one, not its neighbour, crosses."""
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
        warnings.simplefilter("ignore", RuntimeWarning)  # about points that cross, found later
        knots, _ = splprep(outline.T, u=along / total, k=_DEGREE, s=smoothing, per=1)

    def point(t: Array, order: int) -> tuple[Array, Array]:
        """Mean of the spline and its mirror image, which differ by the choice of knots."""
        u = np.asarray(t) / total
        sides = (splev(v.ravel() % 1, knots, der=order) for v in (u, -u))
        (r, z), (r_m, z_m) = ([np.reshape(x, u.shape) for x in side] for side in sides)
        sign = (-1) ** order
        return (r - sign * r_m) / 2 / total**order, (z + sign * z_m) / 2 / total**order

    return Parametric(point, total / 2)


def _steps(points: Array) -> Array:
    return np.hypot(*np.diff(points, axis=0).T)


def _near(point: Array) -> str:
    return f"near r = {point[0]:.3g}, z = {point[1]:.3g} µm"
