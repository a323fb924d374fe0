"""Style of all figures: sizes for print, colours that any colour vision distinguishes."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..output import replace_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

T = TypeVar("T")

# Okabe and Ito's colours, without yellow, which is faint on white.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
# Whatever a user's matplotlibrc says: TeX and other fonts may be missing.
STYLE = {
    "text.usetex": False,
    "font.family": ["DejaVu Sans"],
    "mathtext.fontset": "dejavusans",
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "savefig.dpi": 200,
}
WALL = "#666666"  # where nothing grows
FINER = 8  # points drawn per element, or per step


@contextmanager
def figure_of(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Yield a figure of a size in inches and save it; opens no window, leaves no state."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing")  # of a title in other letters
        figure = Figure(figsize=(width, height))
        FigureCanvasAgg(figure)
        yield figure
        path.parent.mkdir(parents=True, exist_ok=True)
        content = BytesIO()
        figure.savefig(content, format=path.suffix[1:])
        replace_file(path, content.getvalue())


@contextmanager
def curve_axes(path: Path, xlabel: str, ylabel: str, left: float = 0.15) -> Iterator[Axes]:
    """Yield the axes, with a grid, of a figure of curves and save it."""
    with figure_of(path, 4.8, 3.4) as figure:
        axes = figure.add_axes((left, 0.14, 0.97 - left, 0.77))
        axes.set_xlabel(xlabel)
        axes.set_ylabel(ylabel)
        axes.grid(True)
        yield axes
        _make_room(figure, axes)


def _make_room(figure: Figure, axes: Axes) -> None:
    """Move the left side of axes until their label is inside of the figure."""
    outside = -axes.get_tightbbox().x0 / figure.bbox.width  # type: ignore[union-attr]
    if outside > 0:
        place = axes.get_position()
        left = place.x0 + outside + 0.01
        axes.set_position((left, place.y0, place.x1 - left, place.height))


def plain(text: str) -> str:
    """Return a user's text such that matplotlib reads no formula in it."""
    return text.replace("$", r"\$")


def place(figure: Figure, x: float, y: float, width: float, height: float) -> Axes:
    """Add axes at a place and of a size in inches."""
    across, up = figure.get_size_inches()
    return figure.add_axes((x / across, y / up, width / across, height / up))


def spread(items: Sequence[T], most: int) -> list[T]:
    """Return all items or, if there are more than some number, that many, evenly spread."""
    places = np.linspace(0, len(items) - 1, min(len(items), most)).round().astype(int)
    return [items[i] for i in places]


def minutes(time: float) -> str:
    """Return a time in min as a label, short runs with more decimals."""
    return f"{time:.1f} min" if time >= 10 else f"{time:.3g} min"


def growth_colours(largest: float) -> Any:
    """Return colours of growth strains from 0 to a largest one: dark to bright, none faint."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    steps = colormaps["plasma"](range(0, 216))
    return ScalarMappable(Normalize(0.0, largest or 1.0), ListedColormap(steps))
