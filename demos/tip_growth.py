"""A hypha: a tube that keeps its radius while its tip advances at constant speed.

Growth is polarised: its rate is weighted by a Gaussian of the arc length from the tip, which stays
at the tip while the wall moves away from it. The wall's energy is per unit grown volume: per unit
reference volume the wall would soften as it grows, and there would be no steady state. Radius and
speed are compared with the balance in tip_balance.py.
"""

from itertools import pairwise
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from tip_balance import steady

from fenics_yeast import Scene, simulate

scene = Scene.load(Path(__file__).parent / "scenes" / "hypha.toml")
growth, width = scene.growth, scene.growth.polarity.width
load = scene.turgor.pressure * width / (2 * scene.wall.thickness * growth.threshold)
radius, speed = np.multiply(steady(load), (width, width / growth.time))
print(f"Balance: radius {radius:.4f} µm, speed {speed:.5f} µm/min")

result = simulate(scene)
for before, wall in pairwise(result.profiles):
    below_tip = (wall.z[-1] - wall.z)[::-1]
    tube = np.interp(5 * width, below_tip, wall.r[::-1])
    start, end = (result.history.at(profile.time).pole_height_um for profile in (before, wall))
    advance = (end - start) / (wall.time - before.time)
    print(f"{wall.time:.0f} min: tube radius {tube:.4f} µm, speed of the tip {advance:.5f} µm/min")

figure = Path("out/tip_growth.png")
figure.parent.mkdir(exist_ok=True)
fig, (shapes, speeds) = plt.subplots(
    2, 1, figsize=(6.6, 5.2), height_ratios=(1, 1.1), layout="constrained"
)
for wall, colour in zip(result.profiles, plt.cm.viridis_r(np.linspace(0.15, 1, 9)), strict=True):
    r, z = np.r_[-wall.r[::-1], wall.r], np.r_[wall.z[::-1], wall.z]
    shapes.plot(z, r, color=colour, lw=1.5)
shapes.hlines([-radius, radius], *shapes.get_xlim(), color="0.5", lw=1, ls="--", zorder=0)
shapes.set(xlabel="z (µm)", ylabel="r (µm)", aspect="equal", ylim=(-2.6, 2.6), title="every 5 min")
time, height = result.history.time_min, result.history.pole_height_um
late = time > 0.1  # earlier, the wall mainly stretches
advance = np.diff(height[late]) / np.diff(time[late])
speeds.plot(time[late][1:], advance, color="#0072b2", label="shell")
speeds.axhline(speed, color="0.5", ls="--", lw=1, label="balance")
speeds.set(xlabel="time (min)", ylabel="speed of the tip (µm/min)", xlim=(0, None), ylim=(0, None))
speeds.legend(frameon=False)
fig.savefig(figure, dpi=200)
print(f"Shapes and speed: {figure}")
