"""A GIF writer for matplotlib's animations, with one palette and a last frame that stays."""

from typing import Any

import numpy as np
from matplotlib.animation import AbstractMovieWriter
from PIL import Image


class GifWriter(AbstractMovieWriter):
    """Writes frames with one palette, which Pillow's own conversion frame by frame does not.

    Parameters
    ----------
    fps
        Frames per second.
    hold
        Seconds that the last frame stays.
    """

    def __init__(self, fps: int, hold: float) -> None:
        super().__init__(fps)
        self._hold = hold

    def setup(self, fig: Any, outfile: Any, dpi: Any = None) -> None:
        """Begin a file."""
        super().setup(fig, outfile, dpi=dpi)
        self._images: list[Image.Image] = []

    def grab_frame(self, **_: Any) -> None:
        """Add the figure, which the animation has just drawn, as a frame."""
        canvas: Any = self.fig.canvas
        self._images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3]))

    def finish(self) -> None:
        """Write the file; the last frame, which has all colours, gives the palette."""
        palette = self._images[-1].quantize(128, Image.Quantize.MEDIANCUT)
        colours = np.array(palette.getpalette()).reshape(-1, 3)
        colours[colours.min(axis=1) >= 248] = 255  # else white is slightly grey
        palette.putpalette(colours.ravel().tolist())
        frames = [
            image.quantize(palette=palette, dither=Image.Dither.NONE) for image in self._images
        ]
        durations = [1000 // self.fps] * (len(frames) - 1) + [round(1000 * self._hold)]
        options = {"save_all": True, "append_images": frames[1:], "loop": 0, "optimize": False}
        frames[0].save(self.outfile, "GIF", duration=durations, **options)
