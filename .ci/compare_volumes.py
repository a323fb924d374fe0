"""Compare the volumes of the demo on two platforms, from their output folders."""

import json
import sys
from pathlib import Path

from fenics_yeast.output.reading import load_history

folders = [Path(name) for name in sys.argv[1:]]
for folder in folders:
    versions = json.loads((folder / "run.json").read_text())["versions"]
    print(", ".join(f"{name} {version}" for name, version in versions.items()))
here, there = (load_history(folder) for folder in folders)
if list(here.time_min) != list(there.time_min):
    sys.exit("the platforms took other steps")
agree = True
for time in (10, 40, 70, 80, 90):
    row = abs(here.time_min - time).argmin()  # the same of both: their times are
    one, other = here.volume_ratio[row], there.volume_ratio[row]
    apart = abs(other / one - 1)
    print(f"{here.time_min[row]:.6g} min: V/V0 = {one:.10f} and {other:.10f}, {apart:.0e} apart")
    agree = agree and apart <= 1e-10
sys.exit(not agree)
