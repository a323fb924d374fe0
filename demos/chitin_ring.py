"""A stiff chitin ring at the bud neck: the same bud with and without it.

The ring lies below the edge of the growing zone. It is thicker and stiffer than the rest of the
wall and does not grow: it keeps the neck narrow while the bud grows.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import discretise

TIMES = (0, 40, 70, 85)
bare = Scene.load(Path(__file__).parent / "scenes" / "bud.toml")
bare = bare.with_values({"numerics": {"elements": 64}, "run": {"end": 85, "save": TIMES}})
edge = discretise(bare).growing[0].start
zone = {"from": edge - 0.25, "to": edge, "thickness": "0.2 um", "modulus_factor": 4}
scenes = {"without ring": bare, "with chitin ring": bare.with_values({"wall.zone": [zone]})}

figure = Path("out/chitin_ring.png")
figure.parent.mkdir(exist_ok=True)
fig, axes = plt.subplots(1, 2, figsize=(6.4, 3.9), sharey=True, layout="constrained")
for panel, (name, scene) in zip(axes, scenes.items(), strict=True):
    result = simulate(scene)
    print(f"{name}: {result.status}, {result.message}")
    for time, colour in zip(TIMES, plt.cm.viridis_r(np.linspace(0.15, 1, 4)), strict=True):
        wall, row = result.profiles.at(time), result.history.at(time)
        print(
            f"{name}, {time} min: neck radius {row.neck_radius_um:.4f} µm, "
            f"bud radius {row.bud_radius_um:.4f} µm, V/V0 = {row.volume_ratio:.5f}"
        )
        panel.plot(np.r_[-wall.r[::-1], wall.r], np.r_[wall.z[::-1], wall.z], color=colour, lw=1.5,
                   label=f"{time} min")  # fmt: skip
    if scene.wall.zone:
        ring = (wall.S >= zone["from"] - 1e-9) & (wall.S <= edge + 1e-9)
        for side in (-1, 1):
            panel.plot(side * wall.r[ring], wall.z[ring], color="#d55e00", lw=4)
        panel.text(1.5, 2.3, "ring", color="#d55e00", va="center")
    panel.set(title=name, xlabel="r (µm)", aspect="equal")
axes[0].set_ylabel("z (µm)")
axes[0].legend(frameon=False, loc="center")
fig.savefig(figure, dpi=200)
print(f"Shapes: {figure}")
