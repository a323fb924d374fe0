"""The figure of cell shapes, growing zones coloured by their growth strain."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..scene import Scene
from ..simulation import History, Profile, Profiles
from .style import FINER, WALL, figure_of, growth_colours, place, spread
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
    drawn = spread(profiles.all, _MOST_SHAPES)
    view = WallView(profiles, drawn, scene.wall.thickness)
    columns = min(len(drawn), _MOST_IN_A_ROW)
    panel_height = _PANEL * view.height / view.width
    row_height = panel_height + 0.95
    panels = columns * (_PANEL + _GAP)
    low = panel_height < _LABEL  # as a disc's
    width = _LEFT + panels + ((0.95 if low else 0.8) if view.grows else 0.05)
    height = -(-len(drawn) // columns) * row_height
    with figure_of(path, width, height) as figure:
        for i, profile in enumerate(drawn):
            row, column = divmod(i, columns)
            x, y = _LEFT + column * (_PANEL + _GAP), height - (row + 1) * row_height + 0.45
            axes = place(figure, x, y, _PANEL, panel_height)
            view.draw(axes, profile, _PANEL / view.width)
            axes.set_title(_caption(profile, history, scene), linespacing=1.4)
            if column > 0:
                axes.set_ylabel("")
                axes.tick_params(labelleft=False)
        if view.grows:
            axes = place(figure, _LEFT + panels, height - row_height + 0.45, 0.1, panel_height)
            label = "growth strain\nε₁ + ε₂" if low else "growth strain ε₁ + ε₂"
            figure.colorbar(view.colours, cax=axes, label=label)


def _caption(profile: Profile, history: History, scene: Scene) -> str:
    ratio = f"V/V₀ = {history.at(profile.time).volume_ratio:.3f}"
    return f"{profile.time:.4g} min\n{ratio}" if scene.run else ratio


class WallView:
    """Draws profiles of a run with the same limits and colours.

    Attributes
    ----------
    width, height
        Size of what is shown in µm.
    grows
        Whether any of the profiles has grown.
    colours
        Colours of the growth strain.
    """

    def __init__(self, profiles: Profiles, drawn: Sequence[Profile], thickness: float) -> None:
        self._zones, self._thickness = profiles.zones, thickness
        self._half = 1.08 * max(float(p.r.max()) for p in drawn) + thickness
        low, high = min(float(p.z.min()) for p in drawn), max(float(p.z.max()) for p in drawn)
        margin = max(0.05 * (high - low), thickness)
        self._low, self._high = low - margin, high + margin
        self.width, self.height = 2 * self._half, self._high - self._low
        largest = max(float(area_strain(p).max(initial=0.0)) for p in drawn)
        self.grows, self.colours = largest > 0, growth_colours(largest)

    def draw(self, axes: Axes, profile: Profile, scale: float) -> None:
        """Draw both halves of the wall at its thickness, or as a line that prints.

        `scale` is in inches per µm.
        """
        from matplotlib.collections import LineCollection

        axes.set_xlim(-self._half, self._half)
        axes.set_ylim(self._low, self._high)
        axes.set_xlabel("r (µm)")
        axes.set_ylabel("z (µm)")
        S, r, z = outline(profile, FINER)
        middle = (S[1:] + S[:-1]) / 2
        zone = zone_numbers(self._zones, middle) > 0
        strain = np.interp(middle[zone], profile.S_points, area_strain(profile))
        colours = self.colours.to_rgba(strain)
        # Each part that does not grow is one line.
        parts = np.split(np.arange(len(zone)), np.flatnonzero(np.diff(zone)) + 1)
        rests = [slice(part[0], part[-1] + 2) for part in parts if not zone[part[0]]]
        width = max(1.3, self._thickness * scale * _POINTS)
        style: Any = {"linewidths": width, "capstyle": "round", "joinstyle": "round"}
        for side in (-1, 1):
            nodes = np.column_stack([side * r, z])
            pieces = np.stack([nodes[:-1], nodes[1:]], axis=1)[zone]
            for lines, colour in (([nodes[rest] for rest in rests], WALL), (list(pieces), colours)):
                axes.add_collection(LineCollection(lines, colors=colour, **style))
