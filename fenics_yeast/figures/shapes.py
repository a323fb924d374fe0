"""The figure of cell shapes, growing zones coloured by their growth strain."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry import Intervals
from ..scene import Scene
from ..simulation import History, Profile, Profiles
from .style import FINER, WALL, figure_of, growth_colours
from .wall_fields import area_strain, outline, zone_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PANEL, _GAP, _LEFT = 1.75, 0.15, 0.55  # width of a shape's panel and around it, inches
_LABEL = 1.6  # length of the label of growth, inches
_MOST_IN_A_ROW, _MOST_SHAPES = 5, 20
_POINTS = 72.0  # of an inch


def shapes(profiles: Profiles, history: History, scene: Scene, path: Path) -> None:
    """Draw the cell at the saved times in true proportions: the paper's Figure 4.

    Growing zones are coloured by the growth strain `ε1 + ε2`, the mean through the wall. At most
    20 profiles are drawn.

    Parameters
    ----------
    profiles, history, scene
        Profiles to draw, at least one; history and scene of the same run.
    path
        PNG, PDF or SVG file; its directory is created if missing.
    """
    drawn = _selection(profiles)
    columns = min(len(drawn), _MOST_IN_A_ROW)
    rows = -(-len(drawn) // columns)
    half = 1.08 * max(float(p.r.max()) for p in drawn) + scene.wall.thickness
    bottom = min(float(p.z.min()) for p in drawn)
    top = max(float(p.z.max()) for p in drawn)
    margin = 0.05 * (top - bottom)
    scale = _PANEL / (2 * half)  # inches per µm
    panel_height = (top - bottom + 2 * margin) * scale
    largest = max(float(area_strain(p).max(initial=0.0)) for p in drawn)
    colouring = growth_colours(largest)
    row_height = panel_height + 0.95
    panels = columns * (_PANEL + _GAP)
    low = panel_height < _LABEL  # as a disc's
    width = _LEFT + panels + ((0.95 if low else 0.8) if largest > 0 else 0.05)
    height = rows * row_height
    with figure_of(path, width, height) as figure:

        def place(x: float, y: float, w: float, h: float) -> Axes:
            return figure.add_axes((x / width, y / height, w / width, h / height))

        for i, profile in enumerate(drawn):
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
            draw_wall(axes, profile, profiles.zones, scene.wall.thickness, scale, colouring)
        if largest > 0:
            axes = place(_LEFT + panels, height - row_height + 0.45, 0.1, panel_height)
            label = "growth strain\nε₁ + ε₂" if low else "growth strain ε₁ + ε₂"
            figure.colorbar(colouring, cax=axes, label=label)


def _selection(profiles: Profiles) -> list[Profile]:
    """Return all profiles, or as many as fit a page, evenly spread."""
    count = min(len(profiles), _MOST_SHAPES)
    return [profiles.all[i] for i in np.linspace(0, len(profiles) - 1, count).round().astype(int)]


def _caption(profile: Profile, history: History, scene: Scene) -> str:
    ratio = f"V/V₀ = {history.at(profile.time).volume_ratio:.3f}"
    return f"{profile.time:.4g} min\n{ratio}" if scene.run else ratio


def draw_wall(
    axes: Axes,
    profile: Profile,
    zones: Sequence[Intervals],
    thickness: float,
    scale: float,
    colouring: Any,
) -> None:
    """Draw both halves of the wall at its thickness in µm, or as a line that prints."""
    from matplotlib.collections import LineCollection

    linewidth = max(1.3, thickness * scale * _POINTS)
    S, r, z = outline(profile, FINER)
    middle = (S[1:] + S[:-1]) / 2
    zone = zone_numbers(zones, middle) > 0
    colours = colouring.to_rgba(np.interp(middle[zone], profile.S_points, area_strain(profile)))
    # Each part that does not grow is one line.
    parts = np.split(np.arange(len(zone)), np.flatnonzero(np.diff(zone)) + 1)
    rests = [slice(part[0], part[-1] + 2) for part in parts if not zone[part[0]]]
    for side in (-1, 1):
        nodes = np.column_stack([side * r, z])
        pieces = np.stack([nodes[:-1], nodes[1:]], axis=1)[zone]
        for lines, colour in (([nodes[rest] for rest in rests], WALL), (list(pieces), colours)):
            axes.add_collection(
                LineCollection(
                    lines, colors=colour, linewidths=linewidth, capstyle="round", joinstyle="round"
                )
            )
