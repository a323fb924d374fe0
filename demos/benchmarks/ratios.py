"""Ratios by which a change of speed shows on any machine, compared with the committed ones.

Whole processes are timed in turn, the minimum of each; CPU time includes all child processes. A
ratio that is more than 10 % larger than in ``ratios.json`` is marked. With ``--write`` the ratios
found replace those of that file.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

SCENE = Path(__file__).parent.parent / "scenes" / "bud.toml"
COMMITTED = Path(__file__).with_suffix(".json")
IMPORT = ["-c", "import dolfinx"]
RUN = ["-m", "fenics_yeast", "run", str(SCENE), "--quiet", "--set", "numerics={preset='default'}"]
REPEATS, CHANGE = 7, 1.1


def seconds(arguments: list[str], **environment: str) -> tuple[float, float]:
    """Return wall and CPU time of a Python process and its children."""
    before, began = os.times(), perf_counter()
    whole = os.environ | environment
    subprocess.run([sys.executable, *arguments], check=True, env=whole, stdout=subprocess.DEVNULL)
    wall, after = perf_counter() - began, os.times()
    user = after.children_user - before.children_user
    return wall, user + after.children_system - before.children_system


def measure(directory: Path) -> dict[str, float]:
    """Return all ratios; runs write into a directory."""
    run = [*RUN, "--out", str(directory / "out")]
    bare = [*run, "--no-figures"]
    (directory / "cache").mkdir()
    cold = seconds(bare, XDG_CACHE_HOME=str(directory / "cache"))
    seconds(run)  # compiles what is missing
    commands = {"import": IMPORT, "figures": run, "bare": bare}
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
    for _ in range(REPEATS):
        for name, each in commands.items():
            times[name].append(seconds(each))
    wall, cpu = ({n: min(t[i] for t in ts) for n, ts in times.items()} for i in (0, 1))
    return {
        "run with figures / import dolfinx, wall": wall["figures"] / wall["import"],
        "run with figures / import dolfinx, CPU": cpu["figures"] / cpu["import"],
        "run without figures / import dolfinx, wall": wall["bare"] / wall["import"],
        "run without figures / import dolfinx, CPU": cpu["bare"] / cpu["import"],
        "first run of a kind / import dolfinx, wall": cold[0] / wall["import"],
        "first run of a kind / import dolfinx, CPU": cold[1] / cpu["import"],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="replace the committed ratios")
    write = parser.parse_args().write
    with tempfile.TemporaryDirectory() as directory:
        found = measure(Path(directory))
    committed = json.loads(COMMITTED.read_text()) if COMMITTED.exists() else {}
    print("| ratio | committed | now | |\n|---|---|---|---|")
    for name, ratio in found.items():
        before = committed.get(name)
        mark = "slower" if before is not None and ratio > CHANGE * before else ""
        shown = "" if before is None else f"{before:.2f}"
        print(f"| {name} | {shown} | {ratio:.2f} | {mark} |")
    if write:
        rounded = {name: round(ratio, 2) for name, ratio in found.items()}
        COMMITTED.write_text(json.dumps(rounded, indent=2) + "\n")


if __name__ == "__main__":
    main()
