"""An animation of the cell beside its volume: GIF, and MP4 with ffmpeg.

Each frame is a computed state. The scene is therefore rerun with a profile for every frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING, Any

import numpy as np

from ..output import GIF, MP4
from ..scene import Scene
from ..simulation import Profile, Result
from .curves import smooth
from .shapes import WallView
from .style import COLOURS, STYLE, place

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

_FRAMES = 120
_RATE, _HOLD = 20, 1.5  # frames per second; seconds that the last one stays
_WIDTH, _DPI = 7.2, 100  # inches; even numbers of pixels, which MP4 needs
_INCHES = 2.9  # height of the cell


class AnimationError(Exception):
    """An animation that cannot be made; the message is one line."""


def animate(
    directory: Path, scene: Scene, end: float, frames: int = _FRAMES, *, progress: bool = False
) -> list[Path]:
    """Rerun a scene and write an animation to the figures of its output directory.

    Parameters
    ----------
    directory
        The output directory.
    scene
        What was run; it needs a table `run`.
    end
        The last time in min.
    frames
        Number of frames, evenly spaced in time.
    progress
        Whether to show a progress bar.

    Returns
    -------
    list of Path
        ``film.gif`` and, with ffmpeg, ``film.mp4``.

    Raises
    ------
    AnimationError
        If the scene has no run in time, or ffmpeg fails.
    ImportError
        If dolfinx cannot be loaded.
    """
    from matplotlib.animation import FFMpegWriter

    from .._mpi import MPI
    from ..simulation import simulate
    from .gif import GifWriter

    if scene.run is None or end <= 0:
        raise AnimationError(
            f"{directory}: cannot be animated; requires a run in time (a table [run])"
        )
    times = np.linspace(0.0, end, frames).tolist()
    result = simulate(scene.with_values({"run.end": end, "run.save": times}), comm=MPI.COMM_SELF)
    if len(result.profiles) < 2:
        raise AnimationError(f"{directory}: {result.message}")
    figures = directory / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    made = [directory / GIF]
    shown = result.profiles.all
    thickness = scene.wall.thickness
    _save(made[0], GifWriter(_RATE, _HOLD), shown, result, thickness, progress)
    if FFMpegWriter.isAvailable():
        made.append(directory / MP4)
        options = ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
        writer = FFMpegWriter(_RATE, codec="libx264", extra_args=options)
        shown = (*shown, *[shown[-1]] * round(_HOLD * _RATE))
        _save(made[1], writer, shown, result, thickness, progress)
    return made


def _save(
    path: Path, writer: Any, shown: Sequence[Profile], result: Result, thickness: float,
    progress: bool,
) -> None:  # fmt: skip
    """Write the animation of profiles by one of matplotlib's writers."""
    from matplotlib import rc_context
    from matplotlib.animation import FuncAnimation
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from rich.progress import Progress

    temporary = path.with_name(f"part-{path.name}")
    height = round((_INCHES + 0.9) * _DPI / 2) * 2 / _DPI
    with rc_context(STYLE), Progress(transient=True, disable=not progress) as bar:
        task = bar.add_task(f"drawing {path.name}", total=len(shown))
        figure = Figure(figsize=(_WIDTH, height), dpi=_DPI)
        FigureCanvasAgg(figure)
        draw = _Frame(figure, result, thickness)
        moving = FuncAnimation(figure, draw, shown, init_func=list, cache_frame_data=False)
        try:
            moving.save(temporary, writer, dpi=_DPI, progress_callback=lambda *_: bar.advance(task))
        except CalledProcessError as error:
            temporary.unlink(missing_ok=True)
            raise AnimationError(
                f"{path}: cannot be written: ffmpeg failed ({error}); the GIF is complete"
            ) from None
    temporary.replace(path)


class _Frame:
    """Draws one frame after the other into a figure."""

    def __init__(self, figure: Figure, result: Result, thickness: float) -> None:
        profiles, self._history = result.profiles, result.history
        self._view = view = WallView(profiles, profiles.all, thickness)
        self._scale = min(_INCHES / view.height, 2.6 / view.width)  # inches per µm
        across, up = self._scale * view.width, self._scale * view.height
        self._cell: Any = place(figure, 0.55, 0.5, across, up)
        start = 0.55 + across + 0.15
        if view.grows:
            bar = place(figure, start, 0.5, 0.1, up)
            figure.colorbar(view.colours, cax=bar, label="growth strain ε₁ + ε₂")
            start += 0.75
        start += 0.65
        axes = place(figure, start, 0.5, _WIDTH - start - 0.1, _INCHES)
        self._time, self._ratio = smooth(self._history)
        axes.plot(self._time, self._ratio, color="0.85")
        (self._gone,) = axes.plot([], [], color=COLOURS[0])
        (self._now,) = axes.plot([], [], "o", color=COLOURS[0], ms=5, clip_on=False)
        axes.set_xlim(0, profiles.all[-1].time)
        axes.set_xlabel("time (min)")
        axes.set_ylabel("volume V/V₀")
        axes.grid(True)

    def __call__(self, profile: Profile) -> list[Artist]:
        ratio = self._history.at(profile.time).volume_ratio
        self._cell.clear()
        self._view.draw(self._cell, profile, self._scale)
        self._cell.set_title(f"{profile.time:5.1f} min   V/V₀ = {ratio:.3f}")
        gone = self._time <= profile.time
        self._gone.set_data(self._time[gone], self._ratio[gone])
        self._now.set_data([profile.time], [ratio])
        return []
