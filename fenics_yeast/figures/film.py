"""A film of the cell, with its volume running beside it: GIF, and MP4 where ffmpeg is.

Each frame is a computed state: between the saved times of a run nothing is known of its shape, so
the scene is computed once more with a profile for every frame.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..scene import Scene
from ..simulation import History, Profile, Profiles
from .curves import smooth
from .shapes import draw_wall
from .style import COLOURS, STYLE, growth_colours
from .wall_fields import area_strain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Picture = NDArray[np.uint8]

_FRAMES = 120
_RATE, _HOLD = 20, 1.5  # frames per second, and seconds that the last one stays
_WIDTH, _DPI = 7.2, 100  # inches; even numbers of pixels, which MP4 asks for
_INCHES = 2.9  # height of the cell


class FilmError(Exception):
    """A film that cannot be made; the message is one line."""


def animate(
    directory: Path, scene: Scene, end: float, frames: int = _FRAMES, *, progress: bool = False
) -> list[Path]:
    """Compute a scene once more and film it, into the figures of its output folder.

    Parameters
    ----------
    directory
        The output folder.
    scene
        What was run; it needs a table `run`.
    end
        The last time in min.
    frames
        Number of frames, evenly spread in time.
    progress
        Show a bar: drawing them takes some seconds.

    Returns
    -------
    list of Path
        ``film.gif``, and ``film.mp4`` where there is ffmpeg.

    Raises
    ------
    FilmError
        If the scene has no course in time, or ffmpeg fails.
    ImportError
        If dolfinx cannot be loaded.
    """
    from mpi4py import MPI

    from ..simulation import simulate

    if scene.run is None or end <= 0:
        raise FilmError(f"{directory}: nothing moves in it; a film needs a run in time")
    times = np.linspace(0.0, end, frames).tolist()
    result = simulate(scene.with_values({"run.end": end, "run.save": times}), comm=MPI.COMM_SELF)
    if len(result.profiles) < 2:
        raise FilmError(f"{directory}: {result.message}")
    figures = directory / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    pictures = list(
        _shown(render(result.profiles, result.history, scene), len(result.profiles), progress)
    )
    made = [figures / "film.gif"]
    write_gif(pictures, made[0])
    if shutil.which("ffmpeg"):
        made.append(figures / "film.mp4")
        write_mp4(pictures, made[1])
    return made


def render(profiles: Profiles, history: History, scene: Scene) -> Iterator[Picture]:
    """Pictures of all profiles, RGB, shape ``(height, width, 3)``.

    Parameters
    ----------
    profiles
        A frame each.
    history
        Of the same run.
    scene
        What was run.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        half = 1.08 * max(float(p.r.max()) for p in profiles) + scene.wall.thickness
        bottom, top = (
            min(float(p.z.min()) for p in profiles),
            max(float(p.z.max()) for p in profiles),
        )
        margin = 0.05 * (top - bottom)
        box = (-half, half, bottom - margin, top + margin)
        height = _INCHES + 0.9
        figure = Figure(figsize=(_WIDTH, round(height * _DPI / 2) * 2 / _DPI), dpi=_DPI)
        canvas = FigureCanvasAgg(figure)
        draw = _Frame(figure, profiles, history, scene, box)
        for profile in profiles:
            draw(profile)
            canvas.draw()
            yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def _shown(pictures: Iterator[Picture], total: int, progress: bool) -> Iterable[Picture]:
    """The pictures, with a bar where that is asked for."""
    from rich.progress import track

    return track(pictures, "drawing", total, transient=True, disable=not progress)


class _Frame:
    """Draws a frame after the other into one figure."""

    def __init__(
        self,
        figure: Figure,
        profiles: Profiles,
        history: History,
        scene: Scene,
        box: tuple[float, float, float, float],
    ) -> None:
        self._history, self._scene, self._box = history, scene, box
        width, height = figure.get_size_inches()
        left, right, low, high = box
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

    def __call__(self, profile: Profile) -> None:
        axes: Any = self._cell
        axes.clear()
        axes.set_xlim(*self._box[:2])
        axes.set_ylim(*self._box[2:])
        axes.set_xlabel("r (µm)")
        axes.set_ylabel("z (µm)")
        ratio = self._history.at(profile.time).volume_ratio
        axes.set_title(f"{profile.time:5.1f} min   V/V₀ = {ratio:.3f}")
        draw_wall(axes, profile, self._scene, self._scale, self._colouring)
        gone = self._time <= profile.time
        self._gone.set_data(self._time[gone], self._ratio[gone])
        self._now.set_data([profile.time], [ratio])


def write_gif(pictures: list[Picture], path: Path) -> None:
    """Write pictures as a GIF that goes round and round; one palette for all, by Pillow."""
    from PIL import Image

    # The last picture has all the colours; Pillow tells those next to white from it only roughly.
    palette = Image.fromarray(pictures[-1]).quantize(128, Image.Quantize.MEDIANCUT)
    colours = np.array(palette.getpalette()).reshape(-1, 3)
    colours[colours.min(axis=1) >= 248] = 255
    palette.putpalette(colours.ravel().tolist())
    frames = [
        Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in pictures
    ]
    step = 1000 // _RATE
    durations = [step] * (len(frames) - 1) + [round(1000 * _HOLD)]
    temporary = path.with_name(path.name + ".part")
    frames[0].save(
        temporary, "GIF", save_all=True, append_images=frames[1:], duration=durations, loop=0,
        optimize=False,
    )  # fmt: skip
    temporary.replace(path)


def write_mp4(pictures: list[Picture], path: Path) -> None:
    """Write pictures as MP4 by ffmpeg, in the encoding that every player knows.

    Raises
    ------
    FilmError
        With what ffmpeg says, where it fails.
    """
    height, width, _ = pictures[0].shape
    held = [pictures[-1]] * round(_HOLD * _RATE)
    temporary = path.with_name(path.name + ".part")
    command = [
        "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{width}x{height}", "-r", str(_RATE), "-i", "-", "-c:v", "libx264",
        "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(temporary),
    ]  # fmt: skip
    content = b"".join(picture.tobytes() for picture in [*pictures, *held])
    done = subprocess.run(command, input=content, capture_output=True, check=False)
    if done.returncode:
        temporary.unlink(missing_ok=True)
        words = done.stderr.decode(errors="replace").strip().splitlines()
        raise FilmError(f"{path}: ffmpeg failed: {words[-1] if words else done.returncode}")
    temporary.replace(path)
