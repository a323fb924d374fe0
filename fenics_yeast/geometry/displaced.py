"""A meridian whose points are displaced, as an outline from the unloaded shape."""

import numpy as np

from .curves import Array, Parametric

_BEYOND = 6  # places mirrored at a pole, more than the spline looks ahead
_DEGREE = 5  # of the spline: the curvature of the displaced curve has two continuous derivatives


def displaced(
    curve: Parametric, t: Array, displacement: Array, poles: tuple[bool, bool]
) -> Parametric:
    """Return a curve displaced at some of its parameters, and smoothly between them.

    Parameters
    ----------
    curve
        The curve, whose parameters the new one shares.
    t
        Increasing parameters from the lower to the upper end, shape ``(n,)``.
    displacement
        Displacement `(u_r, u_z)` in µm at them, shape ``(n, 2)``.
    poles
        Whether the lower and the upper end are poles, about which the displacement is symmetric.
    """
    from scipy.interpolate import make_interp_spline  # late: 0.2 s, and few scenes need it

    mirror, m = np.array([-1.0, 1.0]), min(_BEYOND, len(t) - 1)
    places, values = [t], [displacement]
    if poles[0]:
        places.insert(0, 2 * t[0] - t[m:0:-1])
        values.insert(0, displacement[m:0:-1] * mirror)
    if poles[1]:
        places.append(2 * t[-1] - t[-2 : -2 - m : -1])
        values.append(displacement[-2 : -2 - m : -1] * mirror)
    moved = make_interp_spline(np.concatenate(places), np.concatenate(values), k=_DEGREE)

    def point(t: Array, order: int) -> tuple[Array, Array]:
        r, z = curve.point(t, order)
        shift = moved(t, nu=order)
        return r + shift[..., 0], z + shift[..., 1]

    return Parametric(point, curve.end)
