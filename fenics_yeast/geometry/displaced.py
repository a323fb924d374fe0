"""Smooth meridians through points, and meridians displaced as an outline from an unloaded shape."""

import numpy as np

from .curves import Array, Parametric

_BEYOND = 6  # places mirrored at a pole, more than the spline looks ahead
_DEGREE = 5  # of the spline: its curvature has two continuous derivatives


def curve_through(t: Array, points: Array, poles: tuple[bool, bool]) -> Parametric:
    """Return the smooth curve through points at given parameters.

    Parameters
    ----------
    t
        Increasing parameters from 0, from the lower to the upper end, shape ``(n,)``.
    points
        `(r, z)` in µm at them, shape ``(n, 2)``.
    poles
        Whether the lower and the upper end are poles, about which the curve is symmetric.
    """
    from scipy.interpolate import make_interp_spline  # late: 0.2 s, and few scenes need it

    mirror, m = np.array([-1.0, 1.0]), min(_BEYOND, len(t) - 1)
    places, values = [t], [points]
    if poles[0]:
        places.insert(0, 2 * t[0] - t[m:0:-1])
        values.insert(0, points[m:0:-1] * mirror)
    if poles[1]:
        places.append(2 * t[-1] - t[-2 : -2 - m : -1])
        values.append(points[-2 : -2 - m : -1] * mirror)
    spline = make_interp_spline(np.concatenate(places), np.concatenate(values), k=_DEGREE)

    def point(t: Array, order: int) -> tuple[Array, Array]:
        found = spline(t, nu=order)
        return found[..., 0], found[..., 1]

    return Parametric(point, float(t[-1]))


def displaced(
    curve: Parametric, t: Array, displacement: Array, poles: tuple[bool, bool]
) -> Parametric:
    """Return a curve displaced at some of its parameters, and smoothly between them.

    Parameters
    ----------
    curve
        The curve, whose parameters the new one shares.
    t
        Increasing parameters from its lower to its upper end, shape ``(n,)``.
    displacement
        Displacement `(u_r, u_z)` in µm at them, shape ``(n, 2)``.
    poles
        Whether the lower and the upper end are poles, about which the displacement is symmetric.
    """
    moved = curve_through(t, displacement, poles)

    def point(t: Array, order: int) -> tuple[Array, Array]:
        (r, z), (u_r, u_z) = curve.point(t, order), moved.point(t, order)
        return r + u_r, z + u_z

    return Parametric(point, curve.end)
