"""The work of `fenics-yeast run`: a run, its figures and its error bars."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ..output import SHAPES, VOLUME, Job, Screen, failed_figures
from ..scene import Scene
from ..simulation import Result


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

    def drawing(result: Result) -> Callable[[], None] | None:
        return (lambda: _draw(path, scene, result)) if with_figures else None

    with Job(path, scene, screen=screen, began=began, resume=resume) as job:
        ended = job.ended
        if ended is not None and (ended.error_bars or not with_error_bars):
            job.note_ended()
            if with_figures and job.comm.rank == 0 and _lacks_figures(path, scene):
                failed = failed_figures(path, lambda: _draw(path, scene, ended))
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


def _draw(path: Path, scene: Scene, result: Result) -> None:
    from ..figures import draw, write_surfaces

    if len(result.profiles):
        write_surfaces(path, scene, result.profiles)
    parts = result.history, result.profiles, result.status, result.error_bars, result.mode
    draw(path, scene, *parts)
