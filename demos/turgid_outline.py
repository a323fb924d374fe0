"""From the outline of a turgid cell to its unloaded shape, and back.

An egg and the tip of a hypha, whose unloaded shapes are known, are inflated. Their outlines alone,
as a microscope sees them, are then given with `outline_is = "turgid"`: the unloaded shapes are
found again, and inflated they lie on the outlines. The hypha is cut; its edge is clamped.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from fenics_yeast import Scene, simulate
from fenics_yeast.geometry import aligned_distances, signed_distances
from fenics_yeast.simulation import find_unloaded

TABLES = {"wall": {"thickness": 0.1, "shear_modulus": 8.0}, "turgor": {"pressure": 0.25}}
t = np.linspace(0, np.pi, 200)
egg = 2.2 * np.sin(t) * (1 - 0.16 * np.cos(t)), -3.2 * np.cos(t)
side, tip = np.linspace(0, 4, 200)[:-1], np.linspace(0, np.pi / 2, 100)
hypha = np.r_[1.7 - side**2 / 80, 1.5 * np.cos(tip)], np.r_[side, 4.0 + 2.6 * np.sin(tip)]


def cell(r: np.ndarray, z: np.ndarray, **keys: object) -> Scene:
    shape = {"shape": "profile", "r": r.tolist(), "z": z.tolist(), **keys}
    return Scene.model_validate({"cell": shape, **TABLES, "numerics": {"elements": 40}})


fig, (*panels, errors) = plt.subplots(1, 3, figsize=(8.4, 3.9), width_ratios=(1, 1, 1.5))
fig.set_layout_engine("constrained")
cases = zip(("egg", "hypha"), (egg, hypha), ({}, {"edge": "clamped"}), panels, "01", strict=True)
for name, shape, edge, panel, colour in cases:
    known = cell(*shape, tolerance=1e-3, **edge)
    seen = simulate(known).profiles.all[-1]
    found = find_unloaded(cell(seen.r, seen.z, tolerance=0.0, outline_is="turgid", **edge))
    final = simulate(found).profiles.all[-1]
    places = np.column_stack([found.cell.unloaded.r, found.cell.unloaded.z])
    missed = aligned_distances(known.cell.curve, places)
    back = signed_distances(found.cell.curve, np.column_stack([final.r, final.z]))
    print(f"{name}: the wall is stretched up to {(final.r / places[:, 0])[1:-1].max():.3f}")
    S = np.array(found.cell.unloaded.S) / found.cell.curve.length
    for what, away, style in (("unloaded shape", missed, "-"), ("outline", back, ":")):
        print(f"{name}: {what} missed by {1e3 * abs(away.distance).max():.2g} nm")
        errors.semilogy(S, 1e3 * abs(away.distance), f"C{colour}{style}", label=f"{name}: {what}")
    for sign, *labels in ((1, "outline", "unloaded shape found", "inflated"), (-1, "", "", "")):
        panel.plot(sign * seen.r, seen.z, color="0.6", lw=4, label=labels[0])
        panel.plot(sign * places[:, 0], places[:, 1], color=f"C{colour}", label=labels[1])
        panel.plot(sign * final.r[::4], final.z[::4], ".", color="black", ms=3, label=labels[2])
    panel.set(xlabel="r (µm)", ylabel="z (µm)", aspect="equal", title=name)
panels[0].set_ylim(top=6.4)
panels[0].legend(frameon=False, loc="upper center", fontsize=7)
errors.set(xlabel="fraction of the outline, from below", ylabel="missed by (nm)", ylim=(1e-9, 1))
errors.legend(frameon=False, fontsize=7, loc="upper left")
Path("out").mkdir(exist_ok=True)
fig.savefig("out/turgid_outline.png", dpi=200)
print("Shapes and distances: out/turgid_outline.png")
