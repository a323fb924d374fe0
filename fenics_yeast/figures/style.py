"""Style of all figures: sizes for print, colours that any colour vision distinguishes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..output import replace_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito's colours, without yellow, which is faint on white.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
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

    with rc_context(STYLE):
        figure = Figure(figsize=(width, height))
        FigureCanvasAgg(figure)
        yield figure
        path.parent.mkdir(parents=True, exist_ok=True)
        content = BytesIO()
        figure.savefig(content, format=path.suffix[1:])
        replace_file(path, content.getvalue())


def growth_colours(largest: float) -> Any:
    """Return colours of growth strains from 0 to a largest one: dark to bright, none faint."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    steps = colormaps["plasma"](range(0, 216))
    return ScalarMappable(Normalize(0.0, largest or 1.0), ListedColormap(steps))
