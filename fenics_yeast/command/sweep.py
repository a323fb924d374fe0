"""The work of `fenics-yeast sweep`: its cases, its screen and its figure."""

import os
from pathlib import Path

from ..output import DolfinxMissing, OutputError, writing
from ..scene import Scene, SceneError
from ..studies import (
    TABLE,
    Case,
    CaseRow,
    draw_sweep,
    parse_variation,
    plan,
    read_paired,
    run_sweep,
)
from .exits import BAD_INPUT, BROKEN, fail, launched, on_terminal
from .sweep_terminal import SweepBar, SweepLines, tally
from .terminal import print_line


def cases_of(
    scene: Scene, variations: list[str], paired: list[Path]
) -> tuple[list[str], list[Case]]:
    """Return the varied keys and the cases of the options `--with` and `--vary`.

    Raises
    ------
    SceneError
        If there is neither, or one cannot be used.
    """
    varied = [*map(read_paired, paired), *map(parse_variation, variations)]
    if not varied:
        raise SceneError("nothing to vary; give --vary TABLE.KEY=V1,V2,... or --with FILE.csv")
    return [key for variation in varied for key in variation.keys], plan(scene, varied)


def sweep_into(
    directory: Path, keys: list[str], cases: list[Case], jobs: int | None, quiet: bool
) -> list[CaseRow]:
    """Run the cases of a sweep into a directory and draw its figure; return the rows on rank 0."""
    # Threads of NumPy would compete with the worker processes.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    comm = launched()
    screen = (SweepBar if on_terminal() else SweepLines)(keys)
    jobs = jobs or len(os.sched_getaffinity(0))
    try:
        if quiet:
            rows = run_sweep(directory, keys, cases, jobs=jobs, comm=comm)
        else:
            with screen:
                rows = run_sweep(directory, keys, cases, jobs=jobs, comm=comm, screen=screen)
        if comm is not None and comm.rank > 0:
            return []
        with writing(directory):
            drawn = draw_sweep(directory)
    except OutputError as error:
        fail(str(error), BAD_INPUT)
    except DolfinxMissing as error:
        fail(str(error), BROKEN)
    if not quiet:
        figure = f", {drawn[0]}" if drawn else ""
        print_line(f"{tally(rows)}; see {directory / TABLE}{figure}")
    return rows
