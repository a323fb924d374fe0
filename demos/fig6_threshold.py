"""Figure 6 of the paper: the volume of the budding cell for three stress thresholds of growth.

The characteristic time is 45 min throughout. The paper notes that varying the
threshold is equivalent to varying the turgor; the second part measures how far that holds.
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

# The criterion knows only the ratio of stress to threshold, and the stress of a membrane is
# p r / 2h: a turgor higher by 1/0.9 should do what the threshold lower by 0.9 does. It does more:
# it also stretches the wall more, and r in that stress is the stretched one.
higher, lower = simulate(bud.with_values({"turgor.pressure": p / 0.9})), results[0.9]


def growth(result, time):
    """Volume grown since the turgor was applied, over V0."""
    history = result.history
    return history.at(time).volume_ratio - history.at(bud.turgor.ramp).volume_ratio


for time in (20, 40, 60):
    by_turgor, by_threshold = growth(higher, time), growth(lower, time)
    print(
        f"{time} min: grown by {by_threshold:.5f} V0 with σ_trs · 0.9, by {by_turgor:.5f} V0 "
        f"with turgor / 0.9, {by_turgor / by_threshold - 1:.1%} more"
    )
print(
    f"Equilibrium is lost at {lower.end_time:.2f} min with σ_trs · 0.9, "
    f"at {higher.end_time:.2f} min with turgor / 0.9"
)
