"""Figures of a run: shapes of the cell, its volume in time, stress and growth along the meridian.

Of a static path it is the pressure against the volume.
"""

from __future__ import annotations

from pathlib import Path

from ..output import MERIDIAN, SHAPES, VOLUME
from ..scene import Scene
from ..simulation import ErrorBars, History, Profiles, Status
from .curves import Curve, force, pressure, pressures, volume, volumes
from .meridian import meridian
from .shapes import shapes

__all__ = [
    "Curve",
    "draw",
    "draw_all",
    "meridian",
    "pressure",
    "pressures",
    "shapes",
    "volume",
    "volumes",
]


def draw(
    directory: Path,
    scene: Scene,
    history: History,
    profiles: Profiles,
    status: Status | None = "finished",
    error_bars: ErrorBars | None = None,
    suffix: str = ".png",
) -> list[Path]:
    """Draw shapes and volume into an output folder, where there is anything to see.

    Parameters
    ----------
    directory
        The output folder.
    scene, history, profiles, status, error_bars
        What was run, and what came out; a run that is going has no status yet.
    suffix
        Kind of file: .png, .pdf or .svg.

    Returns
    -------
    list of Path
        What has been drawn.
    """
    shapes_file, volume_file = ((directory / name).with_suffix(suffix) for name in (SHAPES, VOLUME))
    drawn = []
    if len(profiles):
        shapes(profiles, history, scene, shapes_file)
        drawn.append(shapes_file)
    if scene.run is not None and len(history) > 1:
        volume(history, scene, volume_file, status, error_bars)
        drawn.append(volume_file)
    if scene.path is not None and len(history) > 1:
        (force if scene.path.until.of_load else pressure)(history, scene, volume_file)
        drawn.append(volume_file)
    return drawn


def draw_all(
    directory: Path,
    scene: Scene,
    history: History,
    profiles: Profiles,
    status: Status | None = "finished",
    error_bars: ErrorBars | None = None,
    suffix: str = ".png",
) -> list[Path]:
    """Draw what `draw` does, and stress and growth along the meridian."""
    drawn = draw(directory, scene, history, profiles, status, error_bars, suffix)
    if len(profiles):
        drawn.append((directory / MERIDIAN).with_suffix(suffix))
        meridian(profiles, scene, drawn[-1])
    return drawn
