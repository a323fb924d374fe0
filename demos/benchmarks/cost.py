"""Where the time of a run goes, and how it grows with elements and points through the thickness.

The time stepping of the bud, set-up and output excluded. The parts are timed one within another:
what is left to Python is the loop less all that is compiled. The first time, compiling the forms of
16 points takes some minutes.
"""

import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from time import perf_counter

import numpy as np
from petsc4py import PETSc

from fenics_yeast import Scene, simulate
from fenics_yeast import _dolfinx as dx
from fenics_yeast.simulation import Result

SCENE = Path(__file__).parent.parent / "scenes" / "bud.toml"
BUD = Scene.load(SCENE).with_values({"turgor.ramp": 0, "numerics": {"preset": "default"}})
PRESETS = {
    "default": {"preset": "default"},
    "default, 3 points": {"preset": "default", "thickness_points": 3},
    "paper": {"preset": "paper"},
}
REPEATS = 3

spent = {"residual": 0.0, "Jacobian": 0.0, "solve": 0.0, "local update": 0.0, "functionals": 0.0}


def timed(part: str, function: Callable) -> Callable:
    """The function, its time added to a part."""

    @wraps(function)
    def call(*arguments, **options):
        began = perf_counter()
        try:
            return function(*arguments, **options)
        finally:
            spent[part] += perf_counter() - began

    return call


def linear_algebra() -> float:
    """Seconds that PETSc has spent on factors and on solving with them."""
    events = [PETSc.Log.Event(name) for name in ("PCSetUp", "KSPSolve")]
    return sum(event.getPerfInfo()["time"] for event in events)


def best(numerics: dict[str, object], end: float = 90.0) -> tuple[Result, dict[str, float]]:
    """The fastest of some runs to a time in min: its result, and seconds by part."""
    scene = BUD.with_values({"run": {"end": end}, "numerics": numerics})
    fastest, parts = None, {}
    for _ in range(REPEATS):
        for part in spent:
            spent[part] = 0.0
        before = linear_algebra()
        result = simulate(scene)
        spent["solve"] = linear_algebra() - before
        if fastest is None or result.timings.loop_s < fastest.timings.loop_s:
            fastest, parts = result, dict(spent)
    parts["Python"] = fastest.timings.loop_s - sum(parts.values())
    return fastest, parts


def split() -> None:
    """Print the parts of an iteration for each preset."""
    simulate(BUD)  # a first run that does not count
    print(f"{'µs per Newton iteration':24}", *(f"{part:>13}" for part in [*spent, "Python", "all"]))
    for name, numerics in PRESETS.items():
        result, parts = best(numerics)
        loop, n = result.timings.loop_s, result.newton_iterations
        print(f"{name:24}", *(f"{1e6 * part / n:13.0f}" for part in [*parts.values(), loop]))
        print(f"{'':24}", *(f"{part / loop:13.0%}" for part in [*parts.values(), loop]))
        steps = f"{n} iterations in {result.steps} steps, {loop:.3f} s"
        print(f"{'':24} {steps}, {result.dofs} unknowns")


def growth_with(key: str, values: Sequence[int]) -> None:
    """Print the time of an iteration against a number of the default preset."""
    print(f"\n{key:>18} {'µs per iteration':>18}")
    times = []
    for value in values:
        result, _ = best({"preset": "default", key: value}, end=10.0)
        times.append(1e6 * result.timings.loop_s / result.newton_iterations)
        print(f"{value:18} {times[-1]:18.0f}", flush=True)
    for part, name in ((slice(None), "all"), (slice(len(values) // 2, None), "the larger half")):
        exponent = np.polyfit(np.log(values[part]), np.log(times[part]), 1)[0]
        print(f"fitted exponent, {name}: {exponent:.2f}")


def memory() -> None:
    """Print what a process with one run takes at most."""
    code = """
import resource, sys
from fenics_yeast import Scene, simulate
def largest(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
scene = Scene.load(sys.argv[1]).with_values({"numerics": {"preset": sys.argv[2]}})
imported = largest()
simulate(scene)
print(f"{sys.argv[2]:10} {imported:6.0f} MB after imports, {largest():6.0f} MB at most")
"""
    print("\nmemory of a process")
    for preset in ("default", "paper"):
        subprocess.run([sys.executable, "-c", code, SCENE, preset], check=True)


if __name__ == "__main__":
    PETSc.Log.begin()
    dx.fem.assemble_vector = timed("residual", dx.fem.assemble_vector)
    dx.assemble_matrix = timed("Jacobian", dx.assemble_matrix)
    dx.evaluate = timed("local update", dx.evaluate)
    dx.assemble_scalar = timed("functionals", dx.assemble_scalar)
    split()
    growth_with("elements", (60, 120, 240, 480, 960, 1920, 3840))
    growth_with("thickness_points", (2, 4, 8, 16))
    memory()
