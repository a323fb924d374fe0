"""Figure 6 of the paper: volume of the budding cell for three stress thresholds of growth.

The characteristic growth time is 45 min. The paper notes that varying the threshold is equivalent
to varying the turgor; the second part measures how far that is true.
"""

from pathlib import Path

from fenics_yeast import Scene, simulate
from fenics_yeast.figures import Curve, volumes

bud = Scene.load(Path(__file__).parent / "scenes" / "bud.toml")
bud = bud.with_values({"run.save": [20, 40, 60, 90]})
p = bud.turgor.pressure

results = {}
for threshold in (0.9, 1.0, 1.1):
    results[threshold] = result = simulate(bud.with_values({"growth.threshold": threshold}))
    ratio, end = result.history.at(60).volume_ratio, result.history.rows[-1]
    last = f"{end.volume_ratio:.6f} at {end.time_min:.2f} min, {result.status}"
    print(f"σ_trs = {threshold} MPa: V/V0 = {ratio:.6f} at 60 min, {last}")

figure = Path("out/fig6_threshold.png")
volumes([Curve(f"$σ_{{trs}}$ = {s} MPa", r.history, r.status) for s, r in results.items()], figure)
print(f"Volume against time: {figure}")

# The growth law depends only on the ratio of stress to threshold, and the stress of a membrane is
# p r / 2h. So turgor / 0.9 should have the effect of 0.9 σ_trs. It has more, because it also
# stretches the wall, which increases r.
higher, lower = simulate(bud.with_values({"turgor.pressure": p / 0.9})), results[0.9]


def growth(result, time):
    """Return the increase of V/V0 since turgor was applied."""
    history = result.history
    return history.at(time).volume_ratio - history.at(bud.turgor.ramp).volume_ratio


for time in (20, 40, 60):
    by_turgor, by_threshold = growth(higher, time), growth(lower, time)
    print(
        f"{time} min: growth {by_threshold:.5f} V0 with 0.9 σ_trs, {by_turgor:.5f} V0 "
        f"with turgor / 0.9: {by_turgor / by_threshold - 1:.1%} more"
    )
print(
    f"Equilibrium lost at {lower.end_time:.2f} min with 0.9 σ_trs, "
    f"at {higher.end_time:.2f} min with turgor / 0.9"
)
