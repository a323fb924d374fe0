"""Compare the volumes of the demo on two platforms, from their output folders."""

import sys
from pathlib import Path

from fenics_yeast.output import read_history, read_summary

folders = [Path(name) for name in sys.argv[1:]]
for folder in folders:
    summary = read_summary(folder)
    if summary is None:
        sys.exit(f"{folder}: no run.json; the run has not ended")
    print(", ".join(f"{name} {version}" for name, version in summary.versions.items()))
here, there = (read_history(folder) for folder in folders)
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
