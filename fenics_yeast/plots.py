"""Figures of a run: the shapes of the cell at the saved times, and its volume against time.

Of a static path it is the pressure against the volume.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .output import SHAPES, VOLUME
from .record import ErrorBars, History, Profile, Profiles, Status
from .scene import Scene
from .wall_fields import area_strain, hermite, outline, zone_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Okabe and Ito's colours, told apart with any colour vision; yellow is left out, faint on white.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
_WALL = "#666666"
_STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "savefig.dpi": 200,
}
_PANEL, _GAP, _LEFT = 1.75, 0.15, 0.55  # width of a shape's panel and around it, inches
_MOST_IN_A_ROW, _MOST_SHAPES = 5, 20
_POINTS = 72.0  # of an inch
_FINER = 8  # pieces drawn between two nodes, or two steps


@dataclass(frozen=True)
class Curve:
    """A run in a figure of several.

    Attributes
    ----------
    label
        Its name in the legend.
    history
        Its volume in time.
    status
        How it ended; None while it goes on.
    """

    label: str
    history: History
    status: Status | None = "finished"


def draw(
    directory: Path,
    scene: Scene,
    history: History,
    profiles: Profiles,
    status: Status | None = "finished",
    error_bars: ErrorBars | None = None,
) -> list[Path]:
    """Draw the figures of an output folder that there is anything to see in.

    Returns
    -------
    list of Path
        What has been drawn.
    """
    drawn = []
    if len(profiles):
        shapes(profiles, history, scene, directory / SHAPES)
        drawn.append(directory / SHAPES)
    if scene.run is not None and len(history) > 1:
        volume(history, scene, directory / VOLUME, status, error_bars)
        drawn.append(directory / VOLUME)
    if scene.path is not None and len(history) > 1:
        pressure(history, scene, directory / VOLUME)
        drawn.append(directory / VOLUME)
    return drawn


def shapes(profiles: Profiles, history: History, scene: Scene, path: Path) -> None:
    """Draw the cell at the saved times, both halves, in true proportions: the paper's Figure 4.

    The growing zone is coloured by its growth strain `ε1 + ε2`, the mean through the wall. Of
    more than 20 profiles 20 are drawn, spread evenly from the first to the last.

    Parameters
    ----------
    profiles
        What to draw, at least one.
    history
        Of the same run; its volumes stand above the shapes.
    scene
        What was run.
    path
        PNG, PDF or SVG file; its folder is made where missing.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    drawn = _selection(profiles)
    columns = min(len(drawn), _MOST_IN_A_ROW)
    rows = -(-len(drawn) // columns)
    half = 1.08 * max(float(p.r.max()) for p in drawn) + scene.wall.thickness
    bottom = min(float(p.z.min()) for p in drawn)
    top = max(float(p.z.max()) for p in drawn)
    margin = 0.05 * (top - bottom)
    scale = _PANEL / (2 * half)  # inches per µm
    panel_height = (top - bottom + 2 * margin) * scale
    strains = [area_strain(p) for p in drawn]
    largest = max(float(strain.max(initial=0.0)) for strain in strains)
    colouring = ScalarMappable(Normalize(0.0, largest or 1.0), "viridis_r")
    row_height = panel_height + 0.95
    panels = columns * (_PANEL + _GAP)
    width = _LEFT + panels + (0.8 if largest > 0 else 0.05)
    height = rows * row_height
    with figure_of(path, width, height) as figure:

        def place(x: float, y: float, w: float, h: float) -> Axes:
            return figure.add_axes((x / width, y / height, w / width, h / height))

        for i, (profile, strain) in enumerate(zip(drawn, strains, strict=True)):
            row, column = divmod(i, columns)
            x, y = _LEFT + column * (_PANEL + _GAP), height - (row + 1) * row_height + 0.45
            axes = place(x, y, _PANEL, panel_height)
            axes.set_xlim(-half, half)
            axes.set_ylim(bottom - margin, top + margin)
            axes.set_title(_caption(profile, history, scene), linespacing=1.4)
            axes.set_xlabel("r (µm)")
            if column == 0:
                axes.set_ylabel("z (µm)")
            else:
                axes.tick_params(labelleft=False)
            _draw_wall(axes, profile, strain, scene, scale, colouring)
        if largest > 0:
            axes = place(_LEFT + panels, height - row_height + 0.45, 0.1, panel_height)
            figure.colorbar(colouring, cax=axes, label="growth strain ε₁ + ε₂")


def volume(
    history: History,
    scene: Scene,
    path: Path,
    status: Status | None = "finished",
    error_bars: ErrorBars | None = None,
) -> None:
    """Draw V/V0 against time with the saved times marked; where equilibrium is lost, say so.

    Error bars become a band that is told in numbers too: most are thinner than the line.
    """
    with _volume_axes(path) as axes:
        curve = Curve(scene.title, history, status)
        _draw_volume(axes, curve, COLOURS[0])
        saved = np.isin(history.time_min, scene.run.save if scene.run else ())
        axes.plot(
            history.time_min[saved], history.volume_ratio[saved], "o", color=COLOURS[0], ms=4.5
        )
        axes.set_title(curve.label)
        if error_bars is not None:
            _draw_band(axes, history, error_bars)


def volumes(curves: Sequence[Curve], path: Path, title: str = "", heading: str = "") -> None:
    """Draw V/V0 of several runs against time: the paper's Figures 5 and 6.

    Parameters
    ----------
    curves
        The runs, in the order of the legend.
    path
        PNG, PDF or SVG file; its folder is made where missing.
    title, heading
        Of the figure, and of its legend.
    """
    colours = _colours(len(curves))
    with _volume_axes(path) as axes:
        for curve, colour in zip(curves, colours, strict=True):
            _draw_volume(axes, curve, colour, note=len(curves) <= len(COLOURS))
        axes.set_title(title)
        _explain(axes, curves, heading, "upper left")


def pressures(curves: Sequence[Curve], path: Path, title: str = "", heading: str = "") -> None:
    """Draw the pressure along several static paths against V/V0; see `volumes`."""
    with _pressure_axes(path) as axes:
        for curve, colour in zip(curves, _colours(len(curves)), strict=True):
            _draw_pressure(axes, curve.history, colour, curve.label)
        axes.set_title(title)
        _explain(axes, curves, heading, "lower right")


def pressure(history: History, scene: Scene, path: Path) -> None:
    """Draw the pressure along a static path against V/V0; what is unstable is dashed."""
    with _pressure_axes(path) as axes:
        _draw_pressure(axes, history, COLOURS[0], "stable", "unstable at given pressure")
        if not history.stable.all():
            axes.legend(loc="lower right")
        axes.set_title(scene.title)


@contextmanager
def figure_of(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Figure of the given size in inches, saved at the end; no window, no state left behind."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        figure = Figure(figsize=(width, height))
        FigureCanvasAgg(figure)
        yield figure
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path)


def _selection(profiles: Profiles) -> list[Profile]:
    """All profiles, or as many as fit a page."""
    count = min(len(profiles), _MOST_SHAPES)
    return [profiles.all[i] for i in np.linspace(0, len(profiles) - 1, count).round().astype(int)]


@contextmanager
def _volume_axes(path: Path) -> Iterator[Axes]:
    """Axes of V/V0 against time, the only ones of a figure."""
    with figure_of(path, 4.8, 3.4) as figure:
        axes = figure.add_axes((0.13, 0.14, 0.84, 0.77))
        yield axes
        axes.set_xlabel("time (min)")
        axes.set_ylabel("volume V/V₀")
        axes.set_xlim(left=0)
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)


@contextmanager
def _pressure_axes(path: Path) -> Iterator[Axes]:
    """Axes of pressure against V/V0, the only ones of a figure."""
    with figure_of(path, 4.8, 3.4) as figure:
        axes = figure.add_axes((0.13, 0.14, 0.84, 0.77))
        yield axes
        axes.set_xlabel("volume V/V₀")
        axes.set_ylabel("pressure (MPa)")
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)


def _draw_pressure(
    axes: Axes, history: History, colour: Any, label: str, unstable: str = "_nolegend_"
) -> None:
    """Draw a path in pieces, those that are unstable dashed."""
    V, p, stable = history.volume_ratio, history.pressure_MPa, history.stable.astype(bool)
    ends = stable[1:] & stable[:-1]  # of each piece
    for style, name, pieces in (("-", label, ends), ("--", unstable, ~ends)):
        gaps = np.where(pieces, 0.0, np.nan)
        # A piece and the one after it share a point, which either of them shows.
        shown = np.fmin(np.append(gaps, np.nan), np.append(np.nan, gaps))
        if pieces.any():
            axes.plot(V, p + shown, style, color=colour, label=name)


def _colours(count: int) -> list[Any]:
    """A colour for each of several curves: told apart by hue, or in order where they are many."""
    if count <= len(COLOURS):
        return list(COLOURS[:count])
    from matplotlib import colormaps

    return list(colormaps["viridis"](np.linspace(0.92, 0.0, count)))


def _explain(axes: Axes, curves: Sequence[Curve], heading: str, place: str) -> None:
    """Set a legend; of many curves it names some, evenly spread."""
    handles, labels = axes.get_legend_handles_labels()
    named = np.linspace(0, len(handles) - 1, min(len(handles), len(COLOURS))).round().astype(int)
    handles, labels = [handles[i] for i in named], [labels[i] for i in named]
    if len(curves) > len(COLOURS) and any(curve.status == "no-equilibrium" for curve in curves):
        handles += axes.plot([], [], "x", color="0.4", ms=5, mew=1.8)
        labels.append("equilibrium lost")
    axes.legend(handles, labels, title=heading or None, loc=place, alignment="left")


def _caption(profile: Profile, history: History, scene: Scene) -> str:
    ratio = f"V/V₀ = {history.at(profile.time).volume_ratio:.3f}"
    return f"{profile.time:.4g} min\n{ratio}" if scene.run else ratio


def _draw_wall(
    axes: Axes, profile: Profile, strain: Array, scene: Scene, scale: float, colouring: Any
) -> None:
    """Draw both halves, as thick as the wall is (or as a line that prints)."""
    from matplotlib.collections import LineCollection

    linewidth = max(1.3, scene.wall.thickness * scale * _POINTS)
    S, r, z = outline(profile, _FINER)
    middle = (S[1:] + S[:-1]) / 2
    zone = zone_numbers(scene, middle) > 0
    colours = colouring.to_rgba(np.interp(middle[zone], profile.S_points, strain))
    for side in (-1, 1):
        nodes = np.column_stack([side * r, z])
        pieces = np.stack([nodes[:-1], nodes[1:]], axis=1)
        for part, colour in ((~zone, _WALL), (zone, colours)):
            axes.add_collection(
                LineCollection(
                    pieces[part].tolist(), colors=colour, linewidths=linewidth, capstyle="round"
                )
            )


def _smooth(history: History) -> tuple[Array, Array]:
    """Time and volume ratio, curved between the rows where the pressure stands still."""
    time, ratio = history.time_min, history.volume_ratio
    held = np.flatnonzero(history.pressure_MPa == history.pressure_MPa[-1])
    first = held[0] if len(held) else len(time)
    if len(time) - first < 3 or np.any(np.diff(held) != 1):
        return time, ratio
    # Against the length of the drawn curve, which stays smooth where the volume runs away.
    t, V = time[first:], ratio[first:]
    lengths = np.hypot(np.diff(t) / np.ptp(t), np.diff(V) / (np.ptp(V) or 1.0))
    s = np.append(0.0, np.cumsum(lengths))
    t, V = (hermite(x, lengths, np.gradient(x, s, edge_order=2), _FINER) for x in (t, V))
    return np.append(time[:first], t), np.append(ratio[:first], V)


def _draw_band(axes: Axes, history: History, bars: ErrorBars) -> None:
    """Draw estimated errors about the curve, from nothing at the start to the last known one."""
    known = ~np.isnan(bars.total) & (bars.time_min > 0)
    times, total = bars.time_min[known], bars.total[known]
    if not len(times):
        return
    time, ratio = _smooth(history)
    covered = time <= times[-1]
    time, ratio = time[covered], ratio[covered]
    error = np.interp(time, [0.0, *times], [0.0, *total])
    axes.fill_between(time, ratio - error, ratio + error, color=COLOURS[1], alpha=0.45, lw=0)
    at = history.at(times[-1]).volume_ratio
    axes.errorbar(
        times, [history.at(t).volume_ratio for t in times], total, color=COLOURS[1], fmt="none",
        capsize=4, lw=1.2, zorder=3,
    )  # fmt: skip
    axes.annotate(
        f"± {total[-1]:.2g}", (times[-1], at), (-8, 0), textcoords="offset points",
        ha="right", va="center", color=COLOURS[1], fontsize=8,
    )  # fmt: skip


def _draw_volume(axes: Axes, curve: Curve, colour: Any, note: bool = True) -> None:
    """Draw a curve and mark where its run lost equilibrium; with a note, say when."""
    history = curve.history
    axes.plot(*_smooth(history), color=colour, label=curve.label)
    if curve.status == "no-equilibrium" and len(history):
        time, ratio = history.time_min[-1], history.volume_ratio[-1]
        axes.plot([time], [ratio], "x", color=colour, ms=7 if note else 5, mew=1.8)
        if note:
            axes.annotate(
                f"equilibrium lost\nat {time:.1f} min", (time, ratio), (-8, -2),
                textcoords="offset points", ha="right", va="center", color=colour, fontsize=8,
            )  # fmt: skip
