"""An animation of the cell beside its volume: GIF, and MP4 with ffmpeg.

Each frame is a computed state. The scene is therefore rerun with a profile for every frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING, Any

import numpy as np

from ..scene import Scene
from ..simulation import History, Profile, Profiles, Result
from .curves import smooth
from .shapes import draw_wall
from .style import COLOURS, STYLE, growth_colours
from .wall_fields import area_strain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
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
    from mpi4py import MPI

    from ..simulation import simulate
    from .gif import GifWriter

    if scene.run is None or end <= 0:
        raise AnimationError(f"{directory}: cannot be animated; only a run in time can")
    times = np.linspace(0.0, end, frames).tolist()
    result = simulate(scene.with_values({"run.end": end, "run.save": times}), comm=MPI.COMM_SELF)
    if len(result.profiles) < 2:
        raise AnimationError(f"{directory}: {result.message}")
    figures = directory / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    made = [figures / "film.gif"]
    shown = result.profiles.all
    _save(made[0], GifWriter(_RATE, _HOLD), shown, result, scene, progress)
    if FFMpegWriter.isAvailable():
        made.append(figures / "film.mp4")
        options = ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
        writer = FFMpegWriter(_RATE, codec="libx264", extra_args=options)
        shown = (*shown, *[shown[-1]] * round(_HOLD * _RATE))
        _save(made[1], writer, shown, result, scene, progress)
    return made


def _save(
    path: Path,
    writer: Any,
    shown: Sequence[Profile],
    result: Result,
    scene: Scene,
    progress: bool,
) -> None:
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
        draw = _Frame(figure, result.profiles, result.history, scene)
        moving = FuncAnimation(figure, draw, shown, init_func=list, cache_frame_data=False)
        try:
            moving.save(temporary, writer, dpi=_DPI, progress_callback=lambda *_: bar.advance(task))
        except CalledProcessError as error:
            temporary.unlink(missing_ok=True)
            raise AnimationError(f"{path}: {writer.__class__.__name__} failed: {error}") from None
    temporary.replace(path)


class _Frame:
    """Draws one frame after the other into a figure."""

    def __init__(
        self,
        figure: Figure,
        profiles: Profiles,
        history: History,
        scene: Scene,
    ) -> None:
        self._history, self._profiles = history, profiles
        self._thickness = scene.wall.thickness
        width, height = figure.get_size_inches()
        right = 1.08 * max(float(p.r.max()) for p in profiles) + scene.wall.thickness
        low, high = min(float(p.z.min()) for p in profiles), max(float(p.z.max()) for p in profiles)
        margin, left = 0.05 * (high - low), -right
        low, high = low - margin, high + margin
        self._box = left, right, low, high
        self._scale = min(_INCHES / (high - low), 2.6 / (right - left))  # inches per µm
        across, up = self._scale * (right - left), self._scale * (high - low)
        self._cell = figure.add_axes((0.55 / width, 0.5 / height, across / width, up / height))
        largest = max(float(area_strain(p).max(initial=0.0)) for p in profiles)
        self._colouring = growth_colours(largest)
        start = 0.55 + across + 0.15
        if largest > 0:
            bar = figure.add_axes((start / width, 0.5 / height, 0.1 / width, up / height))
            figure.colorbar(self._colouring, cax=bar, label="growth strain ε₁ + ε₂")
            start += 0.75
        start += 0.65
        beside = (start / width, 0.5 / height, (width - start - 0.1) / width, _INCHES / height)
        self._volume(figure.add_axes(beside), profiles)

    def _volume(self, axes: Axes, profiles: Profiles) -> None:
        self._time, self._ratio = smooth(self._history)
        axes.plot(self._time, self._ratio, color="0.85")
        (self._gone,) = axes.plot([], [], color=COLOURS[0])
        (self._now,) = axes.plot([], [], "o", color=COLOURS[0], ms=5, clip_on=False)
        axes.set_xlim(0, profiles.all[-1].time)
        axes.set_xlabel("time (min)")
        axes.set_ylabel("volume V/V₀")
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)

    def __call__(self, profile: Profile) -> list[Artist]:
        axes: Any = self._cell
        axes.clear()
        axes.set_xlim(*self._box[:2])
        axes.set_ylim(*self._box[2:])
        axes.set_xlabel("r (µm)")
        axes.set_ylabel("z (µm)")
        ratio = self._history.at(profile.time).volume_ratio
        axes.set_title(f"{profile.time:5.1f} min   V/V₀ = {ratio:.3f}")
        draw_wall(
            axes, profile, self._profiles.zones, self._thickness, self._scale, self._colouring
        )
        gone = self._time <= profile.time
        self._gone.set_data(self._time[gone], self._ratio[gone])
        self._now.set_data([profile.time], [ratio])
        return []
