"""Steady growth of a tip whose wall is stiff compared with its turgor.

Such a wall is a membrane that grows but does not stretch. Let s be the arc length from the tip,
r(s) the radius, φ(s) the angle between the meridian and the plane of the tip, and v(s) the speed
of the wall away from the tip. Steady growth by equation (13), weighted by w(s), is

    v' = g σ1/‖σ‖,     v cos φ / r = g σ2/‖σ‖,     g = w(s)/t_grw <‖σ‖/σ_trs - 1>⁺
    σ1 = p / (2 h κ2),  σ2 = σ1 (2 - κ1/κ2),  κ1 = φ',  κ2 = sin φ / r,  r' = cos φ

The second equation gives κ1, hence φ'. Only one curvature at the tip leads to a tube: with a larger
one the meridian turns back to the axis, with a smaller one it never becomes parallel to it. Units
of length, time and stress are the width of the Gaussian w, t_grw and the threshold; the remaining
parameter is the load p width / (2 h σ_trs).
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FURTHEST = 7.0  # widths from the tip, beyond which nothing grows


def growth_rates(s, sigma1, sigma2):
    """Return the rates of both growth strains at a distance s from the tip."""
    size = np.hypot(sigma1, sigma2)
    rate = np.exp(-(s**2) / 2) * max(size - 1, 0)
    return rate * sigma1 / size, rate * sigma2 / size


def dome(load, curvature):
    """Integrate `r, φ, v` from the tip to where the meridian is parallel to the axis, if it is."""

    def slope(s, y):
        r, phi, v = y
        sigma1 = load * r / np.sin(phi)
        hoop = v * np.cos(phi) / r

        def missing(ratio):
            return growth_rates(s, sigma1, ratio * sigma1)[1] - hoop

        ratio = 2.0 if missing(2.0) < 0 else brentq(missing, -2, 2, xtol=1e-13)
        sigma = growth_rates(s, sigma1, ratio * sigma1)
        return [np.cos(phi), np.sin(phi) / r * (2 - ratio), sigma[0]]

    def parallel(s, y):
        return np.cos(y[1])

    parallel.terminal = True
    start = 1e-3
    speed = growth_rates(0.0, load / curvature, load / curvature)[0]
    y = [start, start * curvature, start * speed]
    return solve_ivp(
        slope, (start, FURTHEST), y, events=parallel, rtol=1e-9, atol=1e-11, max_step=0.05
    )


def steady(load):
    """Return radius and speed of the tube for the load `p width / (2 h σ_trs)`."""
    flat, sharp = 0.5, 1.1
    while sharp - flat > 1e-9:
        curvature = (flat + sharp) / 2
        if dome(load, curvature).t[-1] < FURTHEST:
            sharp = curvature
        else:
            flat = curvature
    solution = dome(load, sharp)
    s, (r, _, v) = solution.t[-1], solution.y[:, -1]

    def tube(s, y):
        """Return the slopes of r and v on the cylinder, where growth fades."""
        along, around = growth_rates(s, load * y[0], 2 * load * y[0])
        return [y[0] * around / y[1], along]

    r, v = solve_ivp(tube, (s, FURTHEST), [r, v], rtol=1e-9).y[:, -1]
    return r, v
