"""Time of a run by part, and how it grows with elements and through-thickness integration points.

Only the time stepping of the bud is timed, without set-up and output. The time in Python is that of
the loop less all compiled parts. When first run, compiling the forms of 16 points takes minutes.
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
    """Return a function whose time is added to a part."""

    @wraps(function)
    def call(*arguments, **options):
        began = perf_counter()
        try:
            return function(*arguments, **options)
        finally:
            spent[part] += perf_counter() - began

    return call


def linear_algebra() -> float:
    """Return the seconds that PETSc has spent on factorisation and solution."""
    events = [PETSc.Log.Event(name) for name in ("PCSetUp", "KSPSolve")]
    return sum(event.getPerfInfo()["time"] for event in events)


def best(numerics: dict[str, object], end: float = 90.0) -> tuple[Result, dict[str, float]]:
    """Return the result of the fastest of some runs to a time in min, and its seconds by part."""
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
    """Print the time of an iteration by part for each preset."""
    simulate(BUD)  # a first run, which is discarded
    print(f"{'µs per Newton iteration':24}", *(f"{part:>13}" for part in [*spent, "Python", "all"]))
    for name, numerics in PRESETS.items():
        result, parts = best(numerics)
        loop, n = result.timings.loop_s, result.newton_iterations
        print(f"{name:24}", *(f"{1e6 * part / n:13.0f}" for part in [*parts.values(), loop]))
        print(f"{'':24}", *(f"{part / loop:13.0%}" for part in [*parts.values(), loop]))
        steps = f"{n} iterations in {result.steps} steps, {loop:.3f} s"
        print(f"{'':24} {steps}, {result.dofs} DOFs")


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
    """Print the peak memory of a process with one run."""
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
