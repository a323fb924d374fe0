"""Figure 5 of the paper: volume of the budding cell for three characteristic growth times.

The stress threshold is 1 MPa. Each curve begins with a jump, because turgor is applied in 0.01 min.
Growth softens the wall until it can no longer carry the turgor. With a characteristic growth time
of 30 min this happens before 90 min, and the curve ends there.
"""

from pathlib import Path

from fenics_yeast import Scene, simulate
from fenics_yeast.figures import Curve, volumes

bud = Scene.load(Path(__file__).parent / "scenes" / "bud.toml")

curves = []
for t_grw in (30, 45, 60):
    result = simulate(bud.with_values({"growth.time": t_grw}))
    curves.append(Curve(f"$t_{{grw}}$ = {t_grw} min", result.history, result.status))
    end = result.history.rows[-1]
    last = f"V/V0 = {end.volume_ratio:.6f} at {end.time_min:.2f} min"
    print(f"t_grw = {t_grw} min: {last}, {result.status}")

# Time enters the model only as t / t_grw: the curves would coincide but for the ramp and the error
# of the time step, which is 0.2 min for all of them.
for curve, t_grw in zip(curves, (30, 45), strict=False):
    print(f"t_grw = {t_grw} min: V/V0 = {curve.history.at(2 * t_grw).volume_ratio:.6f} at 2 t_grw")

figure = Path("out/fig5_growth_time.png")
volumes(curves, figure)
print(f"Volume against time: {figure}")
