"""Figure 4 of the paper: a bud grows out of a yeast cell.

A spherical cell, 5 µm across, with a wall of 100 nm and a shear modulus of 40 MPa, carries a turgor
of 2 atm, applied in 0.01 min and constant afterwards. Its top grows where the stress exceeds 1 MPa,
with a characteristic growth time of 45 min; the rest of the cell stays elastic. As in the paper:
480 conical two-node elements with reduced integration, steps of 0.2 min.
"""

from pathlib import Path

from fenics_yeast import Scene, simulate
from fenics_yeast.figures import shapes

scene = Scene.load(Path(__file__).parent / "scenes" / "bud.toml")
result = simulate(scene)

print("time (min)      V/V0")
for time in scene.run.save:
    print(f"{time:10g}  {result.history.at(time).volume_ratio:.6f}")

# A bud has about two thirds of its mother's diameter at division.
bud = result.history.at(90)
relative = 2 * bud.bud_radius_um / scene.cell.diameter
print(f"Bud diameter at 90 min: {relative:.2f} of the mother's unloaded diameter")

figure = Path("out/fig4_bud.png")
shapes(result.profiles, result.history, scene, figure)
print(f"Shapes of the cell: {figure}")
