"""The figure of a sweep: volume curves of its cases, or a map over two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..figures import (
    COLOURS,
    LOST,
    Curve,
    curve_axes,
    figure_of,
    minutes,
    place,
    plain,
    pressures,
    volumes,
)  # fmt: skip
from ..output import read_history, read_scene
from ..scene import unit_symbol
from .cases import value_label
from .table import CaseRow, read_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIGURE = "sweep.png"  # in the directory of the sweep
_MOST_LABELS = 12  # fields of the map along an axis, whose volumes are written into them


def draw_sweep(directory: Path, suffix: str = ".png") -> list[Path]:
    """Draw the figure of a sweep, finished or in progress; return the files written.

    All combinations of two parameters are a map. Nothing is drawn of those of more parameters,
    or before a case has a result.

    Raises
    ------
    OutputError
        If the directory is not that of a sweep, or a file is damaged.
    """
    keys, rows = read_table(directory)
    combined = is_combined(rows)
    rows = [row for row in rows if row.end_ratio is not None]
    if not rows or (combined and len(keys) > 2):
        return []
    path = (directory / FIGURE).with_suffix(suffix)
    scene = read_scene(directory / rows[0].case)
    labels = [_label(key, unit_symbol(scene, key)) for key in keys]
    if combined:
        _draw_map(path, labels, rows, scene.title)
        return [path]
    if scene.run is None and scene.path is None:
        _draw_line(path, labels, rows, scene.title)
        return [path]
    stops = scene.run is not None and scene.run.stop_at_bifurcation
    curves = [
        Curve(
            plain(", ".join(map(value_label, row.values))),
            read_history(directory / row.case),
            row.status,
            stops,
        )
        for row in rows
    ]
    together = volumes if scene.run is not None else pressures
    together(curves, path, plain(scene.title), heading=",\n".join(labels))
    return [path]


def is_combined(rows: Sequence[CaseRow]) -> bool:
    """Whether cases are all combinations of several parameters' values, not pairs of a table."""
    counts = [len(set(column)) for column in zip(*(row.values for row in rows), strict=True)]
    return sum(count > 1 for count in counts) > 1 and len(rows) == prod(counts)


def _label(key: str, unit: str) -> str:
    return f"{key} ({unit})" if unit else key


def _draw_line(path: Path, labels: Sequence[str], rows: Sequence[CaseRow], title: str) -> None:
    """Draw V/V0 of single equilibria against their parameter; of several, case by case."""
    alone = len(labels) == 1
    with curve_axes(path, labels[0] if alone else "case", "volume V/V₀") as axes:
        places: list[float | str] = [
            row.values[0] if alone else str(i) for i, row in enumerate(rows, 1)
        ]
        marks = "o-" if alone else "o"
        axes.plot(places, [row.end_ratio or np.nan for row in rows], marks, color=COLOURS[0])
        axes.set_title(plain(title))


def _draw_map(path: Path, labels: Sequence[str], rows: Sequence[CaseRow], title: str) -> None:
    """Draw a map of V/V0 at the last saved time, or of when equilibrium was lost before."""
    across, up = (list(dict.fromkeys(row.values[i] for row in rows)) for i in range(2))
    time = max((t for row in rows for t, _ in row.ratios), default=None)
    ratios = np.full((len(up), len(across)), np.nan)
    for row in rows:
        at = row.end_ratio if time is None else dict(row.ratios).get(time)
        ratios[_field(row, across, up)] = np.nan if at is None else at
    size = min(0.62, max(0.28, 6.0 / max(len(across), len(up))))
    width, height = max(2.2, size * len(across)), max(1.6, size * len(up))
    with figure_of(path, width + 1.75, height + 0.95) as figure:
        axes = place(figure, 0.75, 0.55, width, height)
        picture = axes.imshow(ratios, origin="lower", aspect="auto", cmap="viridis")
        picture.cmap.set_bad("0.88")
        axes.set_xticks(*_ticks(across), rotation=45 if len(across) > 6 else 0)
        axes.set_yticks(*_ticks(up))
        axes.set_xlabel(labels[0])
        axes.set_ylabel(labels[1])
        axes.set_title(plain(title))
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0)
        _write_numbers(axes, rows, across, up, ratios)
        if not np.isnan(ratios).all():
            when = "" if time is None else f" at {time:g} min"
            beside = place(figure, 0.9 + width, 0.55, 0.12, height)
            bar = figure.colorbar(picture, cax=beside, label=f"V/V₀{when}")
            bar.outline.set_visible(False)  # type: ignore[operator]


def _ticks(values: Sequence[float | str]) -> tuple[list[int], list[str]]:
    """Return places and labels of about twelve ticks."""
    every = -(-len(values) // _MOST_LABELS)
    places = list(range(0, len(values), every))
    return places, [value_label(values[i]) for i in places]


def _field(
    row: CaseRow, across: Sequence[float | str], up: Sequence[float | str]
) -> tuple[int, int]:
    """Return the place of a case in the map."""
    return up.index(row.values[1]), across.index(row.values[0])


def _write_numbers(
    axes: Axes, rows: Sequence[CaseRow], across: Sequence[float | str],
    up: Sequence[float | str], ratios: np.ndarray,
) -> None:  # fmt: skip
    """Write volumes into the map, or when equilibrium was lost."""
    crowded = max(len(across), len(up)) > _MOST_LABELS
    middle = np.nanmean([np.nanmin(ratios), np.nanmax(ratios)]) if (~np.isnan(ratios)).any() else 0
    for row in rows:
        y, x = _field(row, across, up)
        at, colour = ratios[y, x], "black"
        if np.isnan(at):
            text = "×"
            if not crowded and row.status in LOST and row.end_time is not None:
                text = f"ends at\n{minutes(row.end_time)}"
        else:
            text = "" if crowded else f"{at:.3f}"
            colour = "white" if at < middle else "black"
        axes.text(x, y, text, ha="center", va="center", color=colour, fontsize=7)
