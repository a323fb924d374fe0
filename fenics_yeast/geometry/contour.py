"""Contours traced in a microscope: checked, and smoothed into a reference meridian.

The noise of the points is estimated by generalised cross-validation: P. Craven, G. Wahba, Smoothing
noisy data with spline functions, Numer. Math. 31 (1979) 377-403.
"""

import warnings
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .contour_file import ContourError
from .curves import Array, Parametric

_FEWEST, _MOST = 8, 5000  # points
_DEGREE = 5  # of the spline: its curvature has two continuous derivatives
_SHARP = 2.0  # least radius of curvature, in tolerances or distances of points
_NOISE = 4.0  # tolerances by which a point may lie beyond the axis
_ABOVE_NOISE = 1.4  # tolerance over noise: below it, curvatures follow the noise
_MORE = 1.25  # from one tolerance to the next, until the curve no longer follows the noise
_MOST_INCREASES = 9
_STEADY = 0.1  # relative change of the stress from one tolerance to the next
_SAFETY = 2.0  # stress error over change of the stress by a tolerance above
_SPACING = 0.1  # of points, so that scipy's bounds of the smoothing include none and a lot
_BEYOND, _MOST_FOR_NOISE = 30, 600  # points whose noise is estimated
_SAMPLES = 1500  # of the smooth curve, in which crossings and kinks are looked for


@lru_cache(maxsize=8)
def smooth_contour(
    r: tuple[float, ...],
    z: tuple[float, ...],
    tolerance: float | None = None,
    edge: bool = False,
) -> Parametric:
    """Fit a meridian to a contour, by a spline through it and its mirror image.

    The curve is symmetric about the axis, so that a wall is smooth at its poles. It has as few
    knots as the tolerance allows.

    Parameters
    ----------
    r, z
        Points in µm from the bottom pole, or from the edge, to the top pole.
    tolerance
        Root mean square distance of the points from the curve in µm; 0 interpolates them. By
        default, a little more than the noise of the points, so that curvatures do not follow it.
    edge
        Whether its lower end is an edge instead of a pole.

    Raises
    ------
    ContourError
        If the contour crosses itself, is unordered or kinked, or an end is not where it must be.
    """
    if tolerance is None:
        tolerance = tolerance_of(r, z, edge)
    return _smooth(_points(r, z), tolerance, edge)


@lru_cache(maxsize=8)
def tolerance_of(r: tuple[float, ...], z: tuple[float, ...], edge: bool = False) -> float:
    """Return the default tolerance in µm of a contour; see `smooth_contour`.

    Raises
    ------
    ContourError
        If the contour cannot be smoothed.
    """
    points = _points(r, z)
    enough = _FEWEST <= len(points) <= _MOST
    tolerance, last = _ABOVE_NOISE * _noise(r, z, edge) if enough else 0.0, None
    _check(points, tolerance, edge)
    for _ in range(_MOST_INCREASES):
        try:
            stress = _hoop_resultant(_smooth(points, tolerance, edge))
        except ContourError:
            stress = None
        if last is not None and stress is not None and _change(last, stress) < _STEADY:
            return tolerance / _MORE
        last, tolerance = stress, tolerance * _MORE
    return tolerance / _MORE


class Smoothing(NamedTuple):
    """What smoothing does to a contour.

    Attributes
    ----------
    tolerance
        Root mean square distance of the points from the curve in µm.
    volume_change
        Relative change of the volume, from that of the points joined by straight lines.
    stress_error
        Estimated error of the membrane stress over its maximum, by a tolerance of 1.4 times.
    """

    tolerance: float
    volume_change: float
    stress_error: float


@lru_cache(maxsize=8)
def describe_smoothing(
    r: tuple[float, ...],
    z: tuple[float, ...],
    tolerance: float | None = None,
    edge: bool = False,
) -> Smoothing:
    """Return what smoothing does to a contour that `smooth_contour` accepts."""
    tolerance = tolerance_of(r, z, edge) if tolerance is None else tolerance
    curve, points = smooth_contour(r, z, tolerance, edge), _points(r, z)
    joined = _enclosed(points)
    t = np.linspace(0, curve.end, _SAMPLES + 1)
    discs = curve.point(t, 0)[0] ** 2 * curve.point(t, 1)[1]  # they vanish at poles
    volume = float((discs[1:] + discs[:-1]).sum() / 2 * curve.end / _SAMPLES)
    try:
        smoother = _smooth(points, _ABOVE_NOISE * max(tolerance, _noise(r, z, edge)), edge)
    except ContourError:
        return Smoothing(tolerance, volume / joined - 1, 1.0)
    error = _SAFETY * _change(*(_hoop_resultant(each) for each in (curve, smoother)))
    return Smoothing(tolerance, volume / joined - 1, min(error, 1.0))


def _enclosed(points: Array) -> float:
    """Return the volume per π in µm³ within a cubic spline through the points."""
    from scipy.interpolate import CubicSpline  # late, as below

    along = np.append(0.0, np.cumsum(_steps(points)))
    radius, height = (CubicSpline(along, x) for x in points.T)
    places, weights = np.polynomial.legendre.leggauss(5)  # exact for what is integrated
    widths = np.diff(along)[:, None]
    u = along[:-1, None] + widths * (places + 1) / 2
    return float((radius(u) ** 2 * height(u, 1) * weights * widths / 2).sum())


def _hoop_resultant(curve: Parametric) -> Array:
    """Return `N_θ/p = R2 (1 - κ1 R2/2)` of a membrane, between the poles."""
    t = np.linspace(0, curve.end, 402)[1:-1]
    slope_r, slope_z = curve.point(t, 1)
    across = curve.point(t, 0)[0] * np.hypot(slope_r, slope_z) / slope_z
    return np.asarray(across * (1 - curve.curvature_at(t) * across / 2))


def _change(one: Array, other: Array) -> float:
    return float(np.abs(one - other).max() / np.abs(other).max())


def _points(r: tuple[float, ...], z: tuple[float, ...]) -> Array:
    """Return the points without repetitions."""
    points = np.array([r, z], dtype=float).T
    return points[np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))]


@lru_cache(maxsize=8)
def _noise(r: tuple[float, ...], z: tuple[float, ...], edge: bool) -> float:
    """Return the root mean square residual in µm of smoothing splines that cross-validate."""
    from scipy.interpolate import make_smoothing_spline  # late, as below

    points = _points(r, z)
    points = points[:: -(-len(points) // _MOST_FOR_NOISE)]
    beyond = min(_BEYOND, len(points) - 1)  # points of the mirror image at each pole
    before = points[:0] if edge else points[beyond:0:-1] * (-1, 1)
    longer = np.concatenate([before, points, points[-2 : -2 - beyond : -1] * (-1, 1)])
    steps = _steps(longer)
    u = np.append(0.0, np.cumsum(steps)) * _SPACING / steps.mean()
    residuals = [make_smoothing_spline(u, x)(u) - x for x in longer.T]
    inside = slice(len(before), len(before) + len(points))
    return float(np.sqrt(np.mean(np.square(residuals).sum(axis=0)[inside])))


def _smooth(points: Array, tolerance: float, edge: bool) -> Parametric:
    """Fit a curve to points and check it."""
    _check(points, tolerance, edge)
    points = points.copy()
    points[[-1] if edge else [0, -1], 0] = 0
    curve = _fit(points, tolerance, edge)
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


def _check(points: Array, tolerance: float, edge: bool) -> None:
    if not _FEWEST <= len(points) <= _MOST:
        raise ContourError(f"has {len(points)} points; expected {_FEWEST} to {_MOST}")
    near = max(tolerance, 1e-6 * float(np.ptp(points)))
    reach = max(near, float(np.median(_steps(points))) / 2)
    first, last = abs(points[[0, -1], 0])
    if edge and first <= reach:
        raise ContourError("is closed: its first point is on the axis; remove cell.edge")
    if first > reach and not edge:
        raise ContourError(
            f"is open: its first point is {first:.3g} µm from the axis; both ends must be at "
            'r = 0, or set cell.edge, e.g. "clamped"'
        )
    if last > reach:
        must = "its top" if edge else "both ends"
        raise ContourError(
            f"is open: its last point is {last:.3g} µm from the axis; {must} must be at r = 0"
        )
    i = int(np.argmin(points[:, 0]))
    if points[i, 0] < -_NOISE * near:
        raise ContourError(f"meets the axis {_near(points[i])}; r must be > 0 between its ends")
    if points[0, 1] >= points[-1, 1]:
        raise ContourError("runs from top to bottom; reverse the order of its points")


def _crossing(points: Array) -> int | None:
    """Return the index of a segment that another one, not its neighbour, crosses."""
    z = points[:, 1]
    # A rising segment above all before it and below all after it crosses none.
    highest = np.append(-np.inf, np.maximum.accumulate(z)[:-2])
    lowest = np.append(np.minimum.accumulate(z[::-1])[-3::-1], np.inf)
    falls = z[1:] <= z[:-1]
    others = np.flatnonzero(falls | (z[:-1] <= highest) | (z[1:] >= lowest))
    a, b = points[others], points[others + 1]
    low, high = np.minimum(a, b), np.maximum(a, b)
    near = (low[:, None, 1] <= high[:, 1]) & (high[:, None, 1] >= low[:, 1])
    i, j = np.nonzero(np.triu(near, 2))  # at the same height
    d, e, gap = (b - a)[i], (b - a)[j], a[j] - a[i]
    area = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (gap[:, 0] * e[:, 1] - gap[:, 1] * e[:, 0]) / area
        t = (gap[:, 0] * d[:, 1] - gap[:, 1] * d[:, 0]) / area
    crossed = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return int(others[i[crossed][0]]) if crossed.any() else None


def _fit(points: Array, tolerance: float, edge: bool) -> Parametric:
    from scipy.interpolate import splev, splprep  # late: 0.2 s, and few scenes have a contour

    mirrored = points[-2::-1] * (-1, 1)  # down the other side, to the bottom pole again
    outline = np.concatenate([points, mirrored])
    along = np.concatenate([[0.0], np.cumsum(_steps(outline))])
    total = along[-1]
    smoothing = (len(outline) - 1) * tolerance**2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # about points that cross, found later
        knots, _ = splprep(outline.T, u=along / total, k=_DEGREE, s=smoothing, per=not edge)

    def point(t: Array, order: int) -> tuple[Array, Array]:
        """Mean of the spline and its mirror image, which differ by the choice of knots."""
        u = np.asarray(t) / total
        sides = (splev(v.ravel() if edge else v.ravel() % 1, knots, der=order) for v in (u, 1 - u))
        (r, z), (r_m, z_m) = ([np.reshape(x, u.shape) for x in side] for side in sides)
        sign = (-1) ** order
        return (r - sign * r_m) / 2 / total**order, (z + sign * z_m) / 2 / total**order

    return Parametric(point, total / 2)


def _steps(points: Array) -> Array:
    return np.hypot(*np.diff(points, axis=0).T)


def _near(point: Array) -> str:
    return f"near r = {point[0]:.3g}, z = {point[1]:.3g} µm"
