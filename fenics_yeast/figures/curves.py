"""Figures of curves: volume against time, and load along equilibrium paths."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import Array
from ..scene import Scene
from ..simulation import ErrorBars, History, Status
from .style import COLOURS, FINER, curve_axes, minutes, plain, spread
from .wall_fields import hermite

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_MOST_LABELS = 6  # beside a bar of colours

LOST: dict[Status | None, str] = {
    "no-equilibrium": "equilibrium lost",
    "unbounded": "growth without bound",
}
"""Statuses that a figure marks where a curve ends, with the words for them."""


@dataclass(frozen=True)
class Curve:
    """A run in a figure of several: legend label, history and status, None while it runs.

    `stops` says that it ends where its equilibrium becomes unstable.
    """

    label: str
    history: History
    status: Status | None = "finished"
    stops: bool = False

    @property
    def lost(self) -> str | None:
        """Words that mark its end; None if it ends as it should."""
        unstable = self.stops and self.status == "no-equilibrium"
        return "stability lost" if unstable else LOST.get(self.status)


def volume(
    history: History,
    scene: Scene,
    path: Path,
    status: Status | None = "finished",
    error_bars: ErrorBars | None = None,
    bifurcates: bool = False,
) -> None:
    """Draw V/V0 against time, with saved times and the loss of equilibrium marked.

    Error bars become a band with its width in numbers, because most are thinner than the line.
    """
    with _volume_axes(path) as axes:
        stops = scene.run is not None and scene.run.stop_at_bifurcation and bifurcates
        curve = Curve(plain(scene.title), history, status, stops)
        _draw_volume(axes, curve, COLOURS[0])
        saved = np.isin(history.time_min, scene.run.save if scene.run else ())
        axes.plot(
            history.time_min[saved], history.volume_ratio[saved], "o", color=COLOURS[0], ms=4.5
        )
        if not history.stable.all():
            handle = axes.plot([], [], "--", color=COLOURS[0])
            axes.legend(handle, ["unstable"], loc="best")
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
        PNG, PDF or SVG file; its directory is created if missing.
    title, heading
        Titles of the figure and of its legend.
    """
    colours = _colours(len(curves))
    with _volume_axes(path) as axes:
        for curve, colour in zip(curves, colours, strict=True):
            _draw_volume(axes, curve, colour, note=len(curves) <= len(COLOURS))
        axes.set_title(title)
        _explain(axes, curves, heading, "upper left")


def pressures(curves: Sequence[Curve], path: Path, title: str = "", heading: str = "") -> None:
    """Draw the pressure along several equilibrium paths against V/V0; see `volumes`."""
    with curve_axes(path, "volume V/V₀", "pressure (MPa)") as axes:
        for curve, colour in zip(curves, _colours(len(curves)), strict=True):
            V, p = curve.history.volume_ratio, curve.history.pressure_MPa
            _draw_path(axes, V, p, curve.history.stable, colour, curve.label)
        axes.set_title(title)
        _explain(axes, curves, heading, "lower right")


def equilibrium_path(history: History, scene: Scene, path: Path) -> None:
    """Draw the load along an equilibrium path against its conjugate, dashed where unstable."""
    force = scene.path is not None and scene.path.until.of_load
    x, y, labels = history.volume_ratio, history.pressure_MPa, ("volume V/V₀", "pressure (MPa)")
    if force:
        x, y = history.displacement_um, history.force_uN
        labels = "displacement (µm)", "force (µN)"
    unstable = f"unstable at given {'force' if force else 'pressure'}"
    with curve_axes(path, *labels) as axes:
        _draw_path(axes, x, y, history.stable, COLOURS[0], "stable", unstable)
        if not history.stable.all():
            axes.legend(loc="best" if force else "lower right")
        axes.set_title(plain(scene.title))


@contextmanager
def _volume_axes(path: Path) -> Iterator[Axes]:
    """Yield the axes of a figure of V/V0 against time."""
    with curve_axes(path, "time (min)", "volume V/V₀", 0.13) as axes:
        yield axes
        axes.set_xlim(left=0)


def _draw_path(
    axes: Axes, x: Array, y: Array, stable: NDArray[np.bool_], colour: Any, label: str,
    unstable: str = "_nolegend_",
) -> None:  # fmt: skip
    """Draw a path in pieces, dashed where unstable."""
    stable = stable.astype(bool)
    ends = stable[1:] & stable[:-1]  # of each piece
    for style, name, pieces in (("-", label, ends), ("--", unstable, ~ends)):
        gaps = np.where(pieces, 0.0, np.nan)
        # Neighbouring pieces share a point, which either of them may draw.
        shown = np.fmin(np.append(gaps, np.nan), np.append(np.nan, gaps))
        if pieces.any():
            axes.plot(x, y + shown, style, color=colour, label=name)


def _colours(count: int) -> list[Any]:
    """Return a colour per curve: distinct hues, or a sequence for many."""
    if count <= len(COLOURS):
        return list(COLOURS[:count])
    from matplotlib import colormaps

    return list(colormaps["viridis"](np.linspace(0.92, 0.0, count)))


def _explain(axes: Axes, curves: Sequence[Curve], heading: str, place: str) -> None:
    """Set a legend; many curves have a bar of colours instead."""
    handles, labels = axes.get_legend_handles_labels()
    if len(curves) <= len(COLOURS):
        axes.legend(handles, labels, title=heading or None, loc=place, alignment="left")
        return
    left, low = (0.04, 0.45) if place == "upper left" else (0.8, 0.2)
    _add_colours(axes, curves, heading, left, low)
    if ends := dict.fromkeys(curve.lost for curve in curves if curve.lost):
        marker = axes.plot([], [], "x", color="0.4", ms=5, mew=1.8)
        axes.legend(marker, [" or ".join(ends)], loc=(left - 0.03, low - 0.16))


def _add_colours(
    axes: Axes, curves: Sequence[Curve], heading: str, left: float, low: float
) -> None:
    """Draw the colours of curves in their order, with some of the labels, at a place in axes."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    number = len(curves)
    colours = ScalarMappable(Normalize(-0.5, number - 0.5), ListedColormap(_colours(number)))
    beside = axes.inset_axes((left, low, 0.035, 0.42))
    bar = axes.figure.colorbar(colours, cax=beside)
    shown = spread(range(number), _MOST_LABELS)
    bar.set_ticks(list(shown), labels=[curves[i].label for i in shown])
    bar.outline.set_visible(False)  # type: ignore[operator]
    beside.tick_params(length=0)
    beside.set_title(heading, loc="left")


def smooth(history: History) -> tuple[Array, Array]:
    """Return time and volume ratio, interpolated between rows while pressure is constant."""
    time, ratio = history.time_min, history.volume_ratio
    constant = np.flatnonzero(history.pressure_MPa == history.pressure_MPa[-1])
    first = constant[0] if len(constant) else len(time)
    if len(time) - first < 3 or np.any(np.diff(constant) != 1):
        return time, ratio
    # By length of the drawn curve, which stays smooth when the volume grows rapidly.
    t, V = time[first:], ratio[first:]
    lengths = np.hypot(np.diff(t) / np.ptp(t), np.diff(V) / (np.ptp(V) or 1.0))
    s = np.append(0.0, np.cumsum(lengths))
    t, V = (hermite(x, lengths, np.gradient(x, s, edge_order=2), FINER) for x in (t, V))
    return np.append(time[:first], t), np.append(ratio[:first], V)


def _draw_band(axes: Axes, history: History, bars: ErrorBars) -> None:
    """Draw estimated errors as a band, from zero at the start to the last known one."""
    known = ~np.isnan(bars.total) & (bars.time_min > 0)
    times, total = bars.time_min[known], bars.total[known]
    if not len(times):
        return
    time, ratio = smooth(history)
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
    """Draw a curve; mark where its run lost equilibrium and, with a note, when."""
    history = curve.history
    time, ratio = smooth(history)
    rows = np.searchsorted(history.time_min, time * (1 - 1e-12), side="left")
    stable = history.stable[np.minimum(rows, len(history) - 1)]
    _draw_path(axes, time, ratio, stable, colour, curve.label)
    if curve.status == "unbounded":
        axes.set_yscale("log")
    if curve.lost and len(history):
        time, ratio = history.time_min[-1], history.volume_ratio[-1]
        axes.plot([time], [ratio], "x", color=colour, ms=7 if note else 5, mew=1.8)
        axes.margins(y=0.12)  # room for the words
        when = "beyond" if curve.status == "unbounded" else "at"
        if note:
            axes.annotate(
                f"{curve.lost}\n{when} {minutes(time)}", (time, ratio), (-8, -2),
                textcoords="offset points", ha="right", va="center", color=colour, fontsize=8,
            )  # fmt: skip
