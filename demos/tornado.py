"""Which parameter matters: the change of a bud's volume when each of them changes by 1 %.

Derivatives by stresses, times and the wall are exact; those by the shape are differences of runs
that repeat its steps. In other units of stress or length the cell is the same: two sums vanish.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from fenics_yeast import Scene
from fenics_yeast.studies import simulate_with_derivatives

NAMES = {
    "cell.diameter": "diameter of the cell",
    "growth.zone.half_angle": "half-angle of the zone",
    "turgor.pressure": "turgor p",
    "wall.thickness": "wall thickness h",
    "growth.threshold": "threshold σ$_{trs}$",
    "growth.time": "growth time t$_{grw}$",
    "wall.shear_modulus": "shear modulus µ",
    "wall.ogden_exponent": "Ogden exponent α",
}
bud = Scene.load(Path(__file__).parent / "scenes" / "bud.toml")
bud = bud.with_values({"numerics": {"preset": "default"}, "run": {"end": 80, "save": [40, 80]}})
run = simulate_with_derivatives(bud, tuple(NAMES))
found = run.sensitivities
TIMES = (40, 80)
ratios = run.history.interpolate("volume_ratio", TIMES)
percent = found.interpolate("volume_ratio", TIMES) * found.values / ratios[:, None]
for key, values in zip(NAMES, percent.T, strict=True):
    print(f"{key} + 1 %: V/V0 {values[0]:+.4f} % at 40 min, {values[1]:+.4f} % at 80 min")
at = dict(zip(NAMES, percent[1], strict=True))
stresses = at["turgor.pressure"] + at["growth.threshold"] + at["wall.shear_modulus"]
print(f"All stresses together: {stresses:.1e} %")
print(f"All lengths together: {at['cell.diameter'] + at['wall.thickness']:.1e} %")

order = sorted(range(len(NAMES)), key=lambda i: abs(percent[1, i]))
labels = [list(NAMES.values())[i] for i in order]
figure = Path("out/tornado.png")
figure.parent.mkdir(exist_ok=True)
fig, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for row, colour, height in ((1, "#0072b2", 0.68), (0, "#e69f00", 0.34)):
    values = percent[row, order]
    bars = axes.barh(labels, values, height, color=colour, label=f"{TIMES[row]} min")
    if row:
        sizes = [f"{x:+.2g}".replace("-", "−") for x in values]
        axes.bar_label(bars, sizes, padding=4, color="0.3", size=8)
axes.axvline(0, color="0.2", lw=0.8)
axes.set_xlabel("change of V/V$_0$ (%) when the parameter is 1 % larger")
axes.margins(x=0.12)
axes.spines[["top", "right", "left"]].set_visible(False)
axes.tick_params(left=False)
axes.legend(frameon=False, loc="lower right")
fig.savefig(figure, dpi=200)
print(f"Tornado: {figure}")
