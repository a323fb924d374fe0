"""Speed against error: time taken and error of V/V0 of the budding cell for each scheme.

The bud of the paper grows for 90 min. Each scheme is run with coarse and fine settings: Runge-Kutta
methods in time, elements of degree 1 to 4, uniform and graded, through-thickness integration
points, shear penalties. The error is the largest relative error of V/V0 at 40, 70, 80 and 90 min.
The reference is a much finer run, which is compared with volumes from two other programs. The time
is that of the time stepping only, the minimum of several runs after a first one that is discarded.
With ``--floor PROGRAM`` the paper's scheme in C++ is timed too.

Writes out/speed_against_error.csv and out/speed_against_error.png.
"""

import argparse
import csv
import platform
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
from benchmarks.floor import native
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from fenics_yeast import Scene, simulate

TIMES = (40.0, 70.0, 80.0, 90.0)  # min
REQUESTED = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # errors in the table for users
PAPER = "the paper's scheme"
PRESET = "default preset"
# Okabe and Ito's colours, grey and brown: each has one meaning in all panels. Black is the default.
COLOURS = {
    "default preset": "black",
    "sdirk3": "black",
    "degree 4": "black",
    "sdirk2": "#e69f00",
    "forward-euler": "#0072b2",
    "backward-euler": "#d55e00",
    "the paper's scheme": "#d55e00",
    "degree 1": "#009e73",
    "degree 2": "#56b4e9",
    "degree 3": "#cc79a7",
    "integration points": "0.55",
    "shear penalty": "#8c510a",
}
PANELS = ("integrators", "elements", "wall")

# V/V0 at TIMES with 3, 5 and 9 through-thickness integration points by two independent programs:
# two-node elements in C++ and elements of degree 4 in NumPy. They agree to 2e-5, at 90 min to 5e-5.
REFERENCE = {
    3: (1.089066, 1.155312, 1.211736, 1.360678),
    5: (1.088995, 1.154472, 1.209810, 1.353801),
    9: (1.089004, 1.154355, 1.209470, 1.352381),
}

BUD = Scene.load(Path(__file__).parent / "scenes" / "bud.toml").with_values(
    {
        "turgor.ramp": 0,
        "run.save": list(TIMES),
        "numerics": {"thickness_points": 3, "shear_penalty": 1000.0},
    }
)
FINE = {"elements": 48, "tolerance": 1e-7}
PRECISE = {"elements": 33, "tolerance": 1e-6}  # so that the error is that of the setting under test


@dataclass(frozen=True)
class Scheme:
    """Settings to be timed: a point of a line in one panel of the figure.

    `truth` names the run that it is compared with.
    """

    panel: str
    line: str
    setting: str
    numerics: dict[str, object]
    truth: str = "curved"


@dataclass(frozen=True)
class Measured:
    """A row of the table; relative errors of V/V0, times in s."""

    panel: str
    line: str
    setting: str
    error: float
    loop_s: float
    steps: int
    newton_iterations: int
    dofs: int


def ladder(quick: bool) -> Iterator[Scheme]:
    """Yield all schemes, coarse to fine; with `quick` only a few of each line."""

    def some(values: tuple) -> tuple:
        return values[:2] if quick else values

    tolerances = (1e-1, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6)
    for tolerance in (1e-2, 1e-4) if quick else tolerances:
        setting = f"tolerance {tolerance:g}"
        yield Scheme("integrators", PRESET, setting, {"tolerance": tolerance})
        if not quick and tolerance >= 1e-5:
            numerics = {"integrator": "sdirk2", "tolerance": tolerance}
            yield Scheme("integrators", "sdirk2, adaptive", setting, numerics)
    fixed = {
        "forward-euler": (0.5, 0.25, 0.125),  # longer steps are unstable
        "backward-euler": (0.8, 0.4, 0.2, 0.1),
        "sdirk2": (5.0, 2.5, 1.25, 0.625),
        "sdirk3": (5.0, 2.5, 1.25, 0.625),
    }
    for integrator, steps in fixed.items():
        for step in some(steps):
            numerics = {"integrator": integrator, "step": step, "elements": 24}
            yield Scheme("integrators", f"{integrator}, fixed", f"step {step:g} min", numerics)
    yield Scheme(
        "integrators", PAPER, "preset paper", {"preset": "paper", "thickness_points": 3}, "conical"
    )

    numbers = {1: (60, 120, 240), 2: (24, 48, 96), 3: (16, 32, 64), 4: (8, 16, 32)}
    for grading, times in (("graded", 1),) if quick else (("graded", 1), ("uniform", 4)):
        for order, counts in numbers.items():
            for elements in (times * count for count in some(counts)):
                numerics = PRECISE | {"order": order, "grading": grading, "elements": elements}
                line = f"degree {order}, {grading}"
                yield Scheme("elements", line, f"{elements} elements", numerics)

    for points in (2, 3) if quick else (2, 3, 5, 9):
        numerics = PRECISE | {"thickness_points": points}
        yield Scheme("wall", "integration points", f"{points} points", numerics, "wall")
    for penalty in some((1.0, 10.0, 100.0, 1000.0)):
        numerics = PRECISE | {"shear_penalty": penalty}
        yield Scheme("wall", "shear penalty", f"κ = {penalty:g}", numerics, "no shear")


def run(numerics: dict[str, object]):
    """Return the result of the bud with some numerics changed."""
    result = simulate(BUD.with_values({f"numerics.{key}": v for key, v in numerics.items()}))
    if result.status != "finished":
        raise SystemExit(f"{numerics}: {result.message}")
    return result


def volumes(result) -> np.ndarray:
    """Return V/V0 at TIMES."""
    return np.array([result.history.at(time).volume_ratio for time in TIMES])


@cache
def truth(name: str, quick: bool) -> np.ndarray:
    """Return V/V0 at TIMES without the error that the name states.

    Conical elements converge to another limit, because they lack the meridian's curvature.
    """
    best = PRECISE if quick else FINE
    if name == "curved":
        return volumes(run(best))
    if name == "no shear":
        return volumes(run(best | {"shear_penalty": 1e6}))
    if name == "conical":
        linear = {"preset": "paper", "thickness_points": 3, "integrator": "sdirk3"}
        linear |= {"step": 1.0}
        numbers = (480, 960) if quick else (960, 1920)
        coarse, fine = (volumes(run(linear | {"elements": n})) for n in numbers)
        return fine + (fine - coarse) / 3  # second order
    few, many = (3, 5) if quick else (5, 9)
    coarse, fine = (volumes(run(best | {"thickness_points": n})) for n in (few, many))
    return fine + (fine - coarse) / ((many / few) ** 2 - 1)  # about second order


def error(found: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest relative error."""
    return float(np.abs(found / reference - 1).max())


def measure(schemes: list[Scheme], repeats: int, quick: bool) -> list[Measured]:
    """Run all schemes several times, in turns, so that each is timed under the same load.

    The time of the first run of each is discarded, unless it is the only one.
    """
    turns = [[run(scheme.numerics) for scheme in schemes] for _ in range(repeats)]
    rows = []
    for scheme, *runs in zip(schemes, *turns, strict=True):
        result = min(runs[1:] or runs, key=lambda result: result.timings.loop_s)
        measured = Measured(
            panel=scheme.panel,
            line=scheme.line,
            setting=scheme.setting,
            error=error(volumes(result), truth(scheme.truth, quick)),
            loop_s=result.timings.loop_s,
            steps=result.steps,
            newton_iterations=result.newton_iterations,
            dofs=result.dofs,
        )
        rows.append(measured)
    return rows


def draw(rows: list[Measured], floor_s: float | None, path: Path) -> None:
    """Draw error against time, a panel for each subject.

    The paper's scheme in C++ is drawn with the error of the same scheme here.
    """
    paper = next(row for row in rows if row.line == PAPER)
    figure = Figure(figsize=(11, 5.2), layout="constrained")
    panels = figure.subplots(1, len(PANELS), sharex=True, sharey=True)
    titles = ("time stepping", "elements", "integration points, shear")
    for axes, panel, title in zip(panels, PANELS, titles, strict=True):
        draw_lines(axes, [row for row in rows if row.panel == panel])
        if floor_s is not None:
            axes.axvline(floor_s, color="0.6", lw=1, ls=":")
            star = {"marker": "*", "ms": 13, "ls": "", "mfc": "white", "color": "black"}
            axes.plot(floor_s, paper.error, label="the paper's scheme in C++", **star)
        axes.set(title=title, xlabel="time of the loop (s)", xscale="log", yscale="log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(color="0.9", lw=0.5)
        axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2)
    panels[0].set_ylabel("largest relative error of V/V₀")
    figure.savefig(path, dpi=160)


def draw_lines(axes: Axes, rows: list[Measured]) -> None:
    """Draw a line for each scheme; the preset is bold, the paper's scheme is a star."""
    for line in dict.fromkeys(row.line for row in rows):
        points = [(row.loop_s, row.error) for row in rows if row.line == line]
        style = {"marker": "o", "ms": 3.5, "lw": 1.2, "color": COLOURS[line.split(",")[0]]}
        if "uniform" in line or "adaptive" in line:
            style |= {"ls": "--"}
        if line == PRESET:
            style |= {"lw": 2.2}
        if line == PAPER:
            style |= {"marker": "*", "ms": 13, "ls": ""}
        axes.plot(*zip(*points, strict=True), label=line, **style)


def machine() -> str:
    """Return the processor and versions on which times were measured."""
    import dolfinx  # importable because the package has found it

    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    cpu = models[0] if models else platform.processor()
    return f"{cpu}; Python {platform.python_version()}, dolfinx {dolfinx.__version__}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few points, timed once")
    parser.add_argument("--floor", type=Path, metavar="PROGRAM", help="the paper's scheme in C++")
    given = parser.parse_args()
    repeats = 1 if given.quick else 4
    print(machine())

    away = error(truth("curved", given.quick), np.array(REFERENCE[3]))
    print(f"Reference: a fine run, {away:.1e} from the volumes of other programs")
    if away > 5e-5:
        raise SystemExit("error: the reference differs from the two programs, which agree to 5e-5")
    facets = error(truth("conical", given.quick), truth("curved", given.quick))
    print(f"The paper's conical elements converge to volumes that differ by {facets:.1e}")

    rows = measure([*ladder(given.quick)], repeats, given.quick)
    for row in rows:
        scheme = f"{row.line:30} {row.setting:18}"
        print(f"{scheme} error {row.error:8.1e}  {row.loop_s:7.3f} s")
    floor_s = min(native(given.floor) for _ in range(repeats)) if given.floor else None
    if floor_s is not None:
        print(f"the paper's scheme in C++: {floor_s:.3f} s")

    out = Path("out")
    out.mkdir(exist_ok=True)
    with open(out / "speed_against_error.csv", "w", newline="") as file:
        table = csv.DictWriter(file, [*asdict(rows[0])])
        table.writeheader()
        table.writerows(asdict(row) for row in rows)
    draw(rows, floor_s, out / "speed_against_error.png")
    print(f"Figure and table: {out}/speed_against_error.png, .csv")
    print("\n| requested error of V/V0 | error found | time of the loop |\n|---|---|---|")
    requested = {f"tolerance {tolerance:g}": tolerance for tolerance in REQUESTED}
    for row in rows:
        if row.line == PRESET and row.setting in requested:
            tolerance = f"{requested[row.setting]:.0e}".replace("e-0", "e-")
            print(f"| {tolerance} | {row.error:.1e} | {row.loop_s:.3f} s |")


if __name__ == "__main__":
    main()
