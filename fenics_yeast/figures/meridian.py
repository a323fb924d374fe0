"""The figure of stress and growth strain along the meridian."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry import Array, merged
from ..scene import Scene
from ..simulation import Profiles
from .style import figure_of, plain, spread
from .wall_fields import mean, zone_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_MOST_CURVES = 7
_AROUND = 0.75  # length shown beside the growing zones, over theirs


def meridian(profiles: Profiles, scene: Scene, path: Path) -> None:
    """Draw Cauchy stress and growth strain, means through the wall, against reference arc length.

    Stresses beyond twice the threshold have a logarithmic scale, because they are large in the
    bud neck. Only the growing zones and their surroundings are shown, and at most 7 profiles.
    """
    from matplotlib import colormaps
    from matplotlib.lines import Line2D

    drawn = spread(profiles.all, _MOST_CURVES)
    stresses = [mean(profile, profile.stress) for profile in drawn]
    shades = np.linspace(0.85, 0.0, len(drawn)) if len(drawn) > 1 else [0.3]
    colours = list(colormaps["viridis"](shades))
    grows = scene.growth is not None
    height = 4.6 if grows else 2.7
    with figure_of(path, 5.8, height) as figure:
        panels = figure.subplots(2 if grows else 1, 1, sharex=True, squeeze=False)[:, 0]
        figure.subplots_adjust(0.11, 0.5 / height, 0.78, 1 - 0.3 / height, hspace=0.12)
        _draw(panels[0], profiles, stresses, colours)
        panels[0].set_ylabel("Cauchy stress (MPa)")
        panels[0].set_title(plain(scene.title))
        if grows:
            _draw(panels[1], profiles, [mean(p, p.growth_strain) for p in drawn], colours)
            panels[1].set_ylabel("growth strain")
            _scale(panels[0], stresses, scene)
        for axes in panels:
            axes.grid(True)
            _mark_zones(axes, profiles)
        panels[-1].set_xlabel("arc length from the bottom of the unloaded meridian (µm)")
        lines = [Line2D([], [], color=colour) for colour in colours]
        labels = [f"{profile.time:.4g} min" for profile in drawn]
        if scene.run is None:
            lines, labels = [], []
        kinds = [("meridional", "-", "black"), ("hoop", "--", "black")]
        kinds += [("threshold", ":", "0.4")] if grows else []
        for label, style, colour in kinds:
            lines.append(Line2D([], [], color=colour, ls=style, lw=1.2))
            labels.append(label)
        panels[0].legend(lines, labels, loc="upper left", bbox_to_anchor=(1.01, 1.0))


def _draw(axes: Axes, profiles: Profiles, values: Sequence[Array], colours: Sequence[Any]) -> None:
    """Draw meridional and hoop components against arc length, broken at the edges of zones."""
    S = profiles.all[0].S_points
    cuts = np.flatnonzero(np.diff(zone_numbers(profiles.zones, S))) + 1
    for components, colour in zip(values, colours, strict=True):
        for i, style in enumerate(("-", "--")):
            broken = np.insert(components[:, i], cuts, np.nan)
            axes.plot(np.insert(S, cuts, np.nan), broken, style, color=colour, lw=1.2)


def _scale(axes: Axes, stresses: Sequence[Array], scene: Scene) -> None:
    """Mark the thresholds; scale the stress axis, linear around them."""
    thresholds = {growth.threshold for growth in scene.growing}
    for threshold in thresholds:
        axes.axhline(threshold, color="0.4", lw=0.8, ls=":")
    linear = 2 * max(thresholds)
    axes.set_yscale("symlog", linthresh=linear, linscale=1.5)
    axes.set_ylabel(f"Cauchy stress (MPa)\nlog above {linear:.3g}")
    low = min(0.0, 1.2 * min(float(stress.min()) for stress in stresses))
    high = 1.3 * max(float(stress.max()) for stress in stresses)
    unit = 10.0 ** np.floor(np.log10(max(thresholds)))
    sizes = [factor * unit * 10**power for power in range(6) for factor in (1, 2, 5)]
    ticks = [tick for size in sizes for tick in (-size, size) if low <= tick <= high]
    axes.set_yticks([0.0, *ticks], [f"{tick:g}" for tick in [0.0, *ticks]])
    axes.set_ylim(low, high)


def _mark_zones(axes: Axes, profiles: Profiles) -> None:
    """Shade the growing zones, and show only them and their surroundings."""
    parts, S = merged(part for zone in profiles.zones for part in zone), profiles.all[0].S
    if not parts:
        return
    for part in parts:
        axes.axvspan(part.start, part.end, color="0.95", lw=0, zorder=0)
    first, last = min(part.start for part in parts), max(part.end for part in parts)
    beside = _AROUND * (last - first)
    axes.set_xlim(max(S[0], first - beside), min(S[-1], last + beside))
