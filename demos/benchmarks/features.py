"""Cost of each feature of a scene: DOFs, growth strains, time of a Newton iteration, stability.

The tables of `docs/cost.md`, which `--write` replaces. A first run of each scene, which may compile
forms, is discarded; the minimum of several others is reported.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import Result, build_shell
from fenics_yeast.simulation.waves import WaveCheck
from fenics_yeast.solve import Equilibrium, WaveModes

ROOT = Path(__file__).parent.parent.parent
REPEATS = 5

BUD = Scene.load(ROOT / "demos" / "scenes" / "bud.toml").with_values(
    {"numerics": {"preset": "default"}, "turgor.ramp": 0, "run": {"end": 40}}
)
STATIC = {"growth": None, "run": None}
LINEAR = {"law": "linear", "thickness": 0.1, "young_modulus": 120, "poisson_ratio": 0.5}
CAP = {"pole": "top", "half_angle": 24}
FEATURES: dict[str, dict[str, object]] = {
    "growing bud": {},
    "same, elastic (no growth)": {**STATIC, "run": {"end": 40}, "turgor.ramp": 40},
    "same, elastic, one equilibrium": STATIC,
    "bending off": {"wall.bending": False},
    "bending off, elastic, one equilibrium": {**STATIC, "wall.bending": False},
    "3 integration points": {"numerics.thickness_points": 3},
    "capsule": {"cell": {"shape": "capsule", "diameter": 5, "length": 8}},
    "Ogden wall of two terms": {
        "wall": {"thickness": 0.1, "shear_moduli": [30, 10], "ogden_exponents": [2, 4]}
    },
    "Saint Venant-Kirchhoff wall": {"wall": LINEAR},
    "energy per grown volume": {"wall.energy_per": "grown"},
    "wall that thins": {"wall.thickness_change": "elastic"},
    "point force": {"load": {"point_force": "-0.01 uN"}},
    "a stiff ring (zone of the wall)": {
        "wall.zone": [{"from_fraction": 0.8, "to_fraction": 0.85, "modulus_factor": 2.0}]
    },
    "two growing zones": {
        "growth": [
            {"zone": CAP, "threshold": 1, "time": 45},
            {"zone": {**CAP, "pole": "bottom"}, "threshold": 1.2, "time": 45},
        ]
    },
    "conical, straight elements": {"numerics.geometry": "conical", "numerics.order": 1,
                                   "numerics.elements": 64},
}  # fmt: skip


CAPSULE = Scene.load(ROOT / "demos" / "scenes" / "capsule.toml")
ON_A_PATH: dict[str, object] = {
    "run": None, "turgor.pressure": 0, "path": {"until": {"pressure": -0.02}, "steps": 20}
}  # fmt: skip
EXAMINED = {
    "growing bud": BUD.with_values({"run": {"end": 90}}),
    "capsule that loses its turgor": CAPSULE,
    "same, a path to -20 kPa": CAPSULE.with_values(ON_A_PATH),
    "same, four times the elements": CAPSULE.with_values(ON_A_PATH | {"numerics.elements": 124}),
}


def measured(values: dict[str, object]) -> tuple[int, int, int, float]:
    """Return numbers of DOFs, growth strains and iterations, and microseconds per iteration."""
    scene = BUD.with_values(values)
    shell = build_shell(scene)
    state = 0 if shell.growth is None else shell.growth.get().size
    runs = [simulate(scene) for _ in range(REPEATS + 1)][1:]
    least = min(run.timings.loop_s for run in runs)
    return runs[0].dofs, state, runs[0].newton_iterations, 1e6 * least / runs[0].newton_iterations


def table() -> str:
    lines = [
        "| scene | DOFs | growth strains | iterations | µs per iteration |",
        "|---|---|---|---|---|",
    ]
    for name, values in FEATURES.items():
        dofs, state, iterations, time = measured(values)
        lines.append(f"| {name} | {dofs} | {state} | {iterations} | {time:.0f} |")
        print(lines[-1], flush=True)
    return "\n".join(lines)


def stability() -> str:
    """Return the table of what it costs to examine waves around the axis."""
    lines = [
        "| scene | DOFs | rows | loop (ms) | loop without (ms) | one n (ms) |",
        "|---|---|---|---|---|---|",
    ]
    for name, scene in EXAMINED.items():
        times: dict[bool, list[float]] = {True: [], False: []}
        for examined in (True, False) * (REPEATS + 1):
            result = loop(scene, examined)
            times[examined].append(1e3 * result.timings.loop_s)
        full, without = (min(times[examined][1:]) for examined in (True, False))
        lines.append(
            f"| {name} | {result.dofs} | {len(result.history)} | {full:.0f} | {without:.0f} "
            f"| {1e3 * per_number(scene):.1f} |"
        )
        print(lines[-1], flush=True)
    return "\n".join(lines)


def loop(scene: Scene, examined: bool) -> Result:
    """Run a scene, with or without an examination of waves around the axis."""
    fall = WaveCheck._fall
    if not examined:
        WaveCheck._fall = lambda *_: iter(())
    try:
        return simulate(scene)
    finally:
        WaveCheck._fall = fall


def per_number(scene: Scene) -> float:
    """Return the seconds of one number of waves, in a slightly compressed state."""
    shell = build_shell(scene)
    with Equilibrium(shell, 1e-9) as equilibrium, WaveModes(shell) as modes:
        shell.pressure.value = -1e-3
        equilibrium.solve()
        modes.negative_modes(2)
        began = perf_counter()
        for n in range(2, 2 + REPEATS):
            modes.negative_modes(n)
        return (perf_counter() - began) / REPEATS


TEXT = """# Cost of each feature

The paper's bud in the preset `"default"`, to 40 min, with one thing changed at a time. A scene
pays only for what it uses. Without growth, there are no growth strains and no update; without
bending, neither rotation, shear force nor integration points through the thickness. A force is a
number added to the residual. Compiled forms contain only what a law uses, and new numbers need no
recompilation. More DOFs come from more elements, at joints, at edges of zones and near a point
force. Minimum of {repeats} runs on a shared machine; written by `demos/benchmarks/features.py
--write`.

{table}

## Stability against waves around the axis

A wall in tension everywhere is not examined. Otherwise each number of waves n is one factorisation,
up to that of the shortest buckles, after three assemblies; to locate a bifurcation, only the modes
that fall are followed. "Without" is the same run without this examination. Its form is set up when
the wall is first compressed, which takes 0.06 to 0.08 s; its first compilation takes some 10 s.

{stability}
"""

if __name__ == "__main__":
    found, examined = table(), stability()
    if "--write" in sys.argv[1:]:
        path = ROOT / "docs" / "cost.md"
        _, start, rest = path.read_text(encoding="utf-8").partition("\n## Start\n")
        text = TEXT.format(repeats=REPEATS, table=found, stability=examined)
        path.write_text(text + start + rest, encoding="utf-8")
