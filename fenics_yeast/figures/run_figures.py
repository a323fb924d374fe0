"""All figures of a run: the only list of what `run` and `plot` draw."""

from collections.abc import Sequence
from pathlib import Path

from ..output import BUCKLED, MERIDIAN, SHAPES, VOLUME
from ..scene import Scene
from ..simulation import BucklingMode, ErrorBars, History, Profiles, Status
from .curves import equilibrium_path, volume
from .meridian import meridian
from .modes import draw_mode
from .shapes import shapes


def draw(
    directory: Path,
    scene: Scene,
    history: History,
    profiles: Profiles,
    status: Status | None = "finished",
    error_bars: ErrorBars | None = None,
    mode: BucklingMode | None = None,
    *,
    names: Sequence[str] = (SHAPES, VOLUME),
    suffix: str = ".png",
) -> list[Path]:
    """Draw figures of a run into its output directory, those for which it has results.

    Parameters
    ----------
    directory
        The output directory.
    scene, history, profiles, status, error_bars, mode
        What was run, and its results; the status is None while it runs.
    names
        Which figures, of `output.FIGURES`.
    suffix
        Kind of file: .png, .pdf or .svg.

    Returns
    -------
    list of Path
        Files that were written.
    """
    drawn = []
    for name in names:
        path = (directory / name).with_suffix(suffix)
        if name == VOLUME and len(history) > 1 and scene.run is not None:
            volume(history, scene, path, status, error_bars, mode is not None)
        elif name == VOLUME and len(history) > 1 and scene.path is not None:
            equilibrium_path(history, scene, path)
        elif name == SHAPES and len(profiles):
            shapes(profiles, history, scene, path)
        elif name == MERIDIAN and len(profiles):
            meridian(profiles, scene, path)
        elif name == BUCKLED and mode is not None:
            draw_mode(mode, scene.title, path)
        else:
            continue
        drawn.append(path)
    return drawn
