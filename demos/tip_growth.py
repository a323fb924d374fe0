"""A hypha: a tube that keeps its radius while its tip advances at constant speed.

Growth is polarised: its rate is weighted by a Gaussian of the arc length from the tip, which stays
at the tip while the wall moves out of it. The wall's energy is counted per grown volume: counted
per reference volume, the wall would soften as it grows, and there would be no steady state.

The balance of the model, for a wall that is stiff against its turgor (a membrane that only grows):
let s be the arc length from the tip, r(s) the radius, φ(s) the angle of the meridian against the
plane of the tip, and v(s) the speed of the wall away from the tip. Steady growth is

    v' = g σ1/‖σ‖,     v cos φ / r = g σ2/‖σ‖,     g = w(s)/t_grw <‖σ‖/σ_trs - 1>⁺
    σ1 = p / (2 h κ2),  σ2 = σ1 (2 - κ1/κ2),  κ1 = φ',  κ2 = sin φ / r,  r' = cos φ

The second equation gives κ1, hence φ'. Of all curvatures at the tip only one leads to a tube: with
a larger one the meridian turns back to the axis, with a smaller one it never becomes parallel to
it. Tube radius and speed over the width of the Gaussian depend on p width / (2 h σ_trs) alone.
"""

from itertools import pairwise
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_yeast import Scene, simulate

FURTHEST = 7.0  # widths from the tip, beyond which nothing grows


def growth_rates(s, sigma1, sigma2):
    """Rates of both strains at a distance s from the tip, times t_grw; stresses in thresholds."""
    size = np.hypot(sigma1, sigma2)
    rate = np.exp(-(s**2) / 2) * max(size - 1, 0)
    return rate * sigma1 / size, rate * sigma2 / size


def dome(load, curvature):
    """`(s, r, φ, v)` from the tip to where the meridian is parallel to the axis, if it ever is."""

    def slope(s, y):
        r, phi, v = y
        sigma1 = load * r / np.sin(phi)
        wanted = v * np.cos(phi) / r

        def missing(ratio):
            return growth_rates(s, sigma1, ratio * sigma1)[1] - wanted

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
    """Radius and speed of the tube, in widths and widths per t_grw, of `p width / (2 h σ_trs)`."""
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
        """What little still grows there, on a cylinder."""
        along, around = growth_rates(s, load * y[0], 2 * load * y[0])
        return [y[0] * around / y[1], along]

    r, v = solve_ivp(tube, (s, FURTHEST), [r, v], rtol=1e-9).y[:, -1]
    return r, v


if __name__ == "__main__":
    scene = Scene.load(Path(__file__).parent / "scenes" / "hypha.toml")
    result = simulate(scene)
    growth, wall = scene.growing[0], scene.wall
    width = growth.polarity.width
    load = scene.turgor.pressure * width / (2 * wall.thickness * growth.threshold)
    radius, speed = steady(load)
    print(f"{result.status}: {result.message}")
    print(
        f"Balance: radius {radius * width:.4f} µm, speed {speed * width / growth.time:.5f} µm/min"
    )
    rows = [result.history.at(time) for time in scene.run.save]
    for before, row in pairwise(rows):
        profile = result.profiles.at(row.time_min)
        below_tip = (profile.z[-1] - profile.z) / width
        tube = np.interp(5.0, below_tip[::-1], profile.r[::-1])
        advance = (row.pole_height_um - before.pole_height_um) / (row.time_min - before.time_min)
        print(
            f"{row.time_min:5.0f} min: tube radius {tube:.4f} µm, speed of the tip "
            f"{advance:.5f} µm/min"
        )

    figure = Path("out/tip_growth.png")
    figure.parent.mkdir(exist_ok=True)
    fig, (shapes, speeds) = plt.subplots(
        1, 2, figsize=(6.6, 4.4), width_ratios=(1, 1.3), layout="constrained"
    )
    colours = plt.cm.viridis_r(np.linspace(0.15, 1, len(result.profiles)))
    for profile, colour in zip(result.profiles, colours, strict=True):
        shapes.plot(np.r_[-profile.r[::-1], profile.r], np.r_[profile.z[::-1], profile.z],
                    color=colour, lw=1.5)  # fmt: skip
    for side in (-1, 1):
        shapes.axvline(side * radius * width, color="0.5", lw=1, ls="--", zorder=0)
    shapes.set(xlabel="r (µm)", ylabel="z (µm)", aspect="equal", xlim=(-2.6, 2.6))
    shapes.set_title("every 5 min", fontsize=9)
    time, height = result.history.time_min, result.history.pole_height_um
    middle, advance = (time[1:] + time[:-1]) / 2, np.diff(height) / np.diff(time)
    grows = middle > 0.1  # before that the wall mostly stretches
    speeds.plot(middle[grows], advance[grows], color="#0072b2", label="shell")
    speeds.axhline(speed * width / growth.time, color="0.5", ls="--", lw=1, label="balance")
    speeds.set(xlabel="time (min)", ylabel="speed of the tip (µm/min)")
    speeds.set(xlim=(0, None), ylim=(0, None))
    speeds.legend(frameon=False)
    fig.savefig(figure, dpi=200)
    print(f"Shapes and speed: {figure}")
