"""The work of `fenics-yeast plot`: all figures of a run or sweep, from its files."""

from pathlib import Path

from ..figures import draw, write_mode, write_surfaces
from ..output import (
    FIGURES,
    MODE_SURFACE,
    read_history,
    read_mode,
    read_profiles,
    read_scene,
    read_summary,
)
from ..studies import TABLE, draw_sweep, is_combined, read_table
from .exits import on_terminal


def draw_folder(directory: Path, *, pdf: bool = False, moving: bool = False) -> list[Path]:
    """Draw the figures of a run or sweep, finished or in progress, and ParaView surfaces.

    Parameters
    ----------
    directory
        Output directory of a run or of a sweep.
    pdf
        Whether to write each figure also as PDF.
    moving
        Whether to write an animation, which reruns the scene.

    Returns
    -------
    list of Path
        Files that were written.

    Raises
    ------
    OutputError, SceneError
        If the directory cannot be read.
    AnimationError
        If the animation cannot be made.
    """
    suffixes = (".png", ".pdf") if pdf else (".png",)
    if (directory / TABLE).exists():
        if moving:
            from ..figures import AnimationError

            raise AnimationError(
                f"{directory}: contains a sweep; to animate a case, name its directory"
            )
        return [path for suffix in suffixes for path in draw_sweep(directory, suffix)]
    scene, summary = read_scene(directory), read_summary(directory)
    profiles = read_profiles(directory)  # before the history, which is ahead of them
    history = read_history(directory)
    status, bars = (None, None) if summary is None else (summary.status, summary.error_bars)
    mode = read_mode(directory)
    made = []
    for suffix in suffixes:
        results = history, profiles, status, bars, mode
        made += draw(directory, scene, *results, names=FIGURES, suffix=suffix)
    if len(profiles):
        made.append(write_surfaces(directory, scene, profiles))
    if mode is not None:
        write_mode(mode, directory / MODE_SURFACE)
        made.append(directory / MODE_SURFACE)
    if moving:
        from ..figures import animate

        end = float(history.time_min.max(initial=0.0))
        made += animate(directory, scene, end, progress=on_terminal())
    return made


def nothing_drawn(directory: Path) -> str:
    """Return why a run or sweep has no figure yet."""
    if not (directory / TABLE).exists():
        return "nothing to plot yet; wait for the first saved time"
    keys, rows = read_table(directory)
    if len(keys) > 2 and is_combined(rows):
        return f"a sweep over more than two parameters has no figure; see {TABLE}"
    return "nothing to plot yet; wait for the first case to end"
