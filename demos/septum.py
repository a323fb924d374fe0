"""Mother and daughter: a septum closes the bud neck at 85 min, and both continue as separate cells.

The septum is a rigid disc that fixes radius and rotation of the wall at the neck. Each cell starts
from the state of the wall at the separation, so that nothing moves then and the two volumes add up
to that of the whole. The daughter grows until 90 min; the mother buds again at her other pole.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import discretise, pieces

CUT = 85.0  # min
LIFT = 1.0  # µm, by which the daughter is drawn above her mother
bud = Scene.load(Path(__file__).parent / "scenes" / "bud.toml").with_values({"numerics": {}})
first = bud.growth.model_dump(exclude_unset=True) | {"until": 90.0}
second = first | {"zone": {"pole": "bottom", "half_angle": 24}, "from": CUT, "until": 200}
neck = discretise(bud).growing[0].start
bud = bud.with_values(
    {"growth": [first, second], "septum.at": neck, "run": {"end": 165}, "numerics.elements": 64}
)
whole = simulate(bud.with_values({"run": {"end": CUT}}))
lower, upper = pieces(bud, CUT)
mother, daughter = (simulate(piece, state=whole.profiles.at(CUT)) for piece in (lower, upper))
for name, result in (("whole", whole), ("mother", mother), ("daughter", daughter)):
    print(f"{name}: {result.status}, {result.message}")
    for row in (result.history.rows[0], result.history.rows[-1]):
        print(f"{name}: {row.volume_um3:.12f} µm³ after {row.time_min:g} min")
sum_of_both = mother.history.volume_um3[0] + daughter.history.volume_um3[0]
gap = sum_of_both / whole.history.volume_um3[-1] - 1
print(f"Relative gap of the volumes at the separation: {gap:.0e}")

figure = Path("out/septum.png")
figure.parent.mkdir(exist_ok=True)
fig, (before, after, volumes) = plt.subplots(
    1, 3, figsize=(8.4, 3.9), width_ratios=(1, 1, 1.5), layout="constrained"
)
cells = {"whole": (whole, "0.5"), "mother": (mother, "#0072b2"), "daughter": (daughter, "#d55e00")}
for name, (result, colour) in cells.items():
    wall, history, separate = result.profiles.all[-1], result.history, result is not whole
    lift = LIFT if result is daughter else 0.0
    r, z = np.r_[-wall.r[::-1], wall.r], np.r_[wall.z[::-1], wall.z] + lift
    panel = after if separate else before
    panel.fill(r, z, facecolor="none", edgecolor=colour, lw=1.5)
    volumes.plot(history.time_min + CUT * separate, history.volume_um3, color=colour, label=name)
before.set_ylabel("z (µm)")
for panel, title in ((before, f"whole cell, {CUT:.0f} min"),
                     (after, f"165 min, daughter\nlifted by {LIFT:g} µm")):  # fmt: skip
    panel.set(xlabel="r (µm)", aspect="equal", xlim=(-3, 3), ylim=(-5.2, 6.8), title=title)
volumes.set(xlabel="time (min)", ylabel="volume (µm³)", ylim=(0, None), xlim=(0, None))
volumes.legend(frameon=False, loc="center left")
fig.savefig(figure, dpi=200)
print(f"Shapes and volumes: {figure}")
