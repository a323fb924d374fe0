"""Parallel efficiency of a sweep: time of one process over N times that of N processes.

60 cases of about a second with compiled forms; start-up, table and figure are included. With
`--mpi`, ranks of mpirun are used instead of processes.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

SCENE = Path(__file__).parent.parent / "scenes" / "bud.toml"
COMMAND = [sys.executable, "-m", "fenics_yeast"]


def run(directory: Path, cases: int, step: float, width: int, mpi: bool) -> float:
    """Return the seconds of a sweep from start to end."""
    launch = ["mpirun", "-n", str(width)] if mpi else []
    jobs = [] if mpi and width > 1 else ["--jobs", str(width)]
    command = [*(launch if width > 1 else []), *COMMAND, "sweep", SCENE, "--quiet", *jobs]
    vary = ["--vary", f"growth.time=45:75:{cases}", "--set", f"numerics.step={step}"]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    began = perf_counter()
    subprocess.run([*command, *vary, "--out", directory], check=True, env=environment)
    return perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--width", type=int, default=2, help="number of processes or ranks")
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--step", type=float, default=0.14, help="time step of a case in min")
    parser.add_argument("--mpi", action="store_true", help="use ranks instead of processes")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        run(Path(folder, "first"), 2, given.step, 1, False)  # compiles
        alone = run(Path(folder, "alone"), given.cases, given.step, 1, False)
        beside = run(Path(folder, "beside"), given.cases, given.step, given.width, given.mpi)
    efficiency = alone / (given.width * beside)
    kind = "ranks" if given.mpi else "processes"
    print(
        f"{given.cases} cases of {alone / given.cases:.2f} s: {alone:.1f} s in one process, "
        f"{beside:.1f} s on {given.width} {kind}, efficiency {efficiency:.2f}"
    )


if __name__ == "__main__":
    main()
