"""The work of `fenics-yeast run`: a run, its figures and its error bars."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

from ..output import SHAPES, VOLUME, Job, Screen
from ..scene import Scene
from ..simulation import Result
from .figure_process import FigureProcess


def run_completely(
    path: Path,
    scene: Scene,
    *,
    screen: Screen | None = None,
    began: float | None = None,
    with_error_bars: bool = False,
    with_figures: bool = True,
    resume: bool = False,
) -> Result:
    """Run a scene into a directory, with figures and, if requested, error bars of V/V0.

    Parameters and errors are those of `Job`; without figures, there are no files for ParaView.

    Raises
    ------
    KeyboardInterrupt
        If figures or error bars are interrupted; only those are missing then.
    """
    process = FigureProcess() if with_figures else nullcontext()
    job_of_run = Job(path, scene, screen=screen, began=began, resume=resume)
    with process as figures, job_of_run as job:

        def drawing(result: Result) -> Callable[[], str | None] | None:
            return None if figures is None else lambda: figures.draw(path, scene, result)

        ended = job.ended
        if ended is not None and (ended.error_bars or not with_error_bars):
            job.note_ended()
            if figures is not None and job.comm.rank == 0 and _lacks_figures(path, scene):
                failed = figures.draw(path, scene, ended)
                if failed is not None and failed not in ended.warnings:
                    return replace(ended, warnings=(*ended.warnings, failed))
            return ended
        result = job.run()
        result = job.complete(result, drawing(result))
        if not with_error_bars or result.status == "interrupted":
            return result

        def refined() -> Result:
            from ..studies import estimate_error_bars

            announce = screen.refining if screen is not None and job.comm.rank == 0 else None
            bars = estimate_error_bars(
                scene, result, announce=announce, observer=job.interrupts, comm=job.comm
            )
            return replace(result, error_bars=bars)

        full = job.extend(result, refined, "error bars")
        return job.complete(full, drawing(full))


def _lacks_figures(path: Path, scene: Scene) -> bool:
    """Whether a run has ended without its figures, as on a full disk."""
    names = [SHAPES] if scene.run is None and scene.path is None else [SHAPES, VOLUME]
    return not all((path / name).exists() for name in names)
