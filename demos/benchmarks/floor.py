"""Time of the presets' loops compared with that of a C++ program of the same model.

The program solves the paper's scheme (480 conical two-node elements, backward Euler, steps of
0.2 min, 3 through-thickness integration points) and prints ``time X s``. It is not part of this
repository; ``--floor PROGRAM`` names it. All run in turns, so that each is timed under the same
load; the minimum of each is reported.
"""

import argparse
import re
import subprocess
from pathlib import Path

from fenics_yeast import Scene, simulate

SCENE = Path(__file__).parent.parent / "scenes" / "bud.toml"
BUD = Scene.load(SCENE).with_values({"turgor.ramp": 0, "run.save": [40, 70, 80, 90]})
PRESETS = {
    "paper preset": {"preset": "paper"},
    "default preset, 3 points": {"preset": "default", "thickness_points": 3},
    "default preset, 5 points": {"preset": "default"},
    "tolerance 1e-3, 3 points": {"preset": "default", "thickness_points": 3, "tolerance": 1e-3},
    "tolerance 1e-2, 3 points": {"preset": "default", "thickness_points": 3, "tolerance": 1e-2},
}
GIVEN = ["conical=1", "ks=100", "nxi=3", "be=1", "dt=0.2", "p=0.20265", "at=40,70,80,90"]
FLOOR = "C++"
ROUNDS = 5


def native(program: Path) -> float:
    """Return the seconds that the program reports."""
    done = subprocess.run([program, *GIVEN], capture_output=True, text=True, check=True)
    return float(re.search(r"time ([\d.]+) s", done.stdout)[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--floor", type=Path, metavar="PROGRAM", help="the C++ program")
    program = parser.parse_args().floor
    if program is None:
        print("No C++ program to compare with. Build one that takes the arguments")
        print(f"    {' '.join(GIVEN)}")
        print("with g++ -O3 -march=native -ffast-math, then rerun with --floor PROGRAM.")

    scenes = {name: BUD.with_values({"numerics": given}) for name, given in PRESETS.items()}
    for scene in scenes.values():
        simulate(scene)  # a first run, which is discarded
    times: dict[str, list[float]] = {}
    for _ in range(ROUNDS):
        for name, scene in scenes.items():
            times.setdefault(name, []).append(simulate(scene).timings.loop_s)
            if program is not None:
                times.setdefault(FLOOR, []).append(native(program))

    print(f"loop of the bud to 90 min, minimum of {ROUNDS}")
    for name, seconds in times.items():
        ratio = f"{min(seconds) / min(times[FLOOR]):8.2f} x C++" if FLOOR in times else ""
        print(f"{name:26} {min(seconds):8.3f} s {ratio}")


if __name__ == "__main__":
    main()
