"""All pictures of an output folder, drawn again from its files: a run's, or a sweep's."""

from __future__ import annotations

from pathlib import Path

from ..figures import run_figures as plots
from ..figures import write_surfaces
from ..output import read_error_bars, read_history, read_profiles, read_scene, read_status
from ..studies import TABLE
from ..studies import figure as sweep_plots
from .exits import on_terminal


def draw_folder(directory: Path, *, pdf: bool = False, moving: bool = False) -> list[Path]:
    """Draw the figures of a folder, finished or still going, and the surfaces for ParaView.

    Parameters
    ----------
    directory
        Output folder of a run or of a sweep.
    pdf
        Whether each figure is written as PDF too.
    moving
        Whether the run is filmed, which computes it once more.

    Returns
    -------
    list of Path
        What has been made.

    Raises
    ------
    OutputError, SceneError
        If the folder cannot be read.
    FilmError
        If the film cannot be made.
    """
    suffixes = (".png", ".pdf") if pdf else (".png",)
    if (directory / TABLE).exists():
        if moving:
            from ..figures import FilmError

            raise FilmError(f"{directory}: is a sweep; name the folder of one of its cases")
        return [path for suffix in suffixes for path in sweep_plots.draw(directory, suffix)]
    scene, status = read_scene(directory), read_status(directory)
    profiles = read_profiles(directory)  # before the history, which is ahead of them
    history, bars = read_history(directory), read_error_bars(directory)
    made = []
    for suffix in suffixes:
        made += plots.draw_all(directory, scene, history, profiles, status, bars, suffix)
    if len(profiles):
        made.append(write_surfaces(directory, scene, profiles))
    if moving:
        from ..figures import animate

        end = float(history.time_min.max(initial=0.0))
        made += animate(directory, scene, end, progress=on_terminal())
    return made
