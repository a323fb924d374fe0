"""Find the parameters of buds whose volumes were made by another program, with noise added.

Threshold 1.07 MPa, growth time 38 min. The intervals of 95 % must contain these in 90 to 98 % of
all noise. One curve does not separate the two, a second one at a lower turgor does.

    python demos/fit_bud.py [SEEDS]        (default: 3; 200 take some 12 min on one core)
"""

import csv
import sys
from pathlib import Path

import numpy as np

from fenics_yeast import MeasuredCurve, Scene
from fenics_yeast.scene import FitProblem
from fenics_yeast.simulation import ShellPool
from fenics_yeast.studies import draw_fit, fit_problem

HERE = Path(__file__).parent
SEEDS = int(sys.argv[1]) if len(sys.argv) > 1 else 3
TRUE = {"growth.threshold": 1.07, "growth.time": 38.0}
NOISE = 0.01
BUD = Scene.load(HERE / "scenes" / "bud.toml").with_values({"numerics": {"preset": "default"}})
BUD = BUD.with_values({"turgor.pressure": 0.20265})


def exact(turgor):
    """Return times and V/V0 of the other program."""
    lines = (HERE / "data" / f"bud_{turgor:g}.csv").read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return [[float(row[name]) for row in rows] for name in ("time_min", "volume_ratio")]


def measured(turgor, random):
    """Return a curve with noise."""
    times, volumes = exact(turgor)
    values = volumes * (1 + NOISE * random.standard_normal(len(volumes)))
    settings = {} if turgor == 0.20265 else {"turgor.pressure": turgor}
    return MeasuredCurve(f"{turgor:g} MPa", "volume_ratio", times, values, NOISE, set=settings)


def coverage(keys, turgors, seeds, shells):
    """Fit many noisy data sets; return how often each interval has the true value, and runs."""
    held = {key: value for key, value in TRUE.items() if key not in keys}
    inside, runs, seconds = np.zeros(len(keys)), 0, 0.0
    for seed in range(seeds):
        random = np.random.default_rng(seed)
        curves = [measured(turgor, random) for turgor in turgors]
        problem = FitProblem.of(BUD.with_values(held), curves, keys)
        found = fit_problem(problem, shells=shells)
        inside += [found[key].low <= TRUE[key] <= found[key].high for key in keys]
        runs, seconds = runs + found.runs, seconds + found.seconds
    return inside / seeds, runs / seeds, seconds / seeds


with ShellPool() as shells:
    cases = [
        (["growth.threshold"], [0.20265]),
        (["growth.time"], [0.20265]),
        (list(TRUE), [0.20265, 0.19]),
    ]
    for keys, turgors in cases:
        shares, runs, seconds = coverage(keys, turgors, SEEDS, shells)
        for key, share in zip(keys, shares, strict=True):
            print(f"{key}, {len(turgors)} curve(s): true value inside in {100 * share:.1f} %")
        print(f"  {runs:.1f} runs, {seconds:.2f} s per fit", flush=True)

    # What one curve does not tell.
    one = fit_problem(
        FitProblem.of(BUD, [measured(0.20265, np.random.default_rng(0))], list(TRUE)),
        shells=shells,
    )
    print(f"one curve: correlation {one.correlation[0, 1]:.4f}; {one.warnings[0]}")

    # Ten starts end in one place.
    limits = {
        "growth.threshold": {"from": 0.8, "to": 1.6},
        "growth.time": {"from": 15, "to": 120},
    }
    random = np.random.default_rng(0)
    curves = [measured(turgor, random) for turgor in (0.20265, 0.19)]
    places = []
    for start in np.random.default_rng(1).uniform(np.log([0.9, 25]), np.log([1.5, 100]), (10, 2)):
        problem = FitProblem.of(BUD, curves, limits)
        found = fit_problem(problem, start=np.exp(start), shells=shells)
        places.append([np.log(one.value) for one in found.parameters])
    drawn = draw_fit(Path("out/fit_bud"), found)[0].replace("out/fit_bud.png")
    print(f"Fit: {drawn}")
    spread = np.ptp(places, axis=0)
    print(f"ten starts: values differ by {spread[0]:.1e} and {spread[1]:.1e} (relative)")
