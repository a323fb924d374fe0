"""Figures of a fit: data and best curve, correlations, profiles."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..figures import COLOURS, figure_of, plain
from .fit_result import Estimate, FitResult
from .fit_statistics import CHI2

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LABELS = {
    "volume_um3": "volume (µm³)",
    "volume_ratio": "volume V/V₀",
    "length_um": "length (µm)",
    "pole_height_um": "distance of the poles (µm)",
    "radius_um": "radius (µm)",
}
_MOST_NAMES = 6  # in a legend


def draw_fit(directory: Path, result: FitResult) -> list[Path]:
    """Draw all figures of a result into ``figures`` of a directory; return the files written."""
    folder = directory / "figures"
    drawn = [folder / "fit.png"]
    _draw_curves(drawn[0], result)
    if len(result.parameters) > 1:
        drawn.append(folder / "correlation.png")
        _draw_correlation(drawn[-1], result)
    if result.profiles:
        drawn.append(folder / "profile.png")
        _draw_profiles(drawn[-1], result)
    return drawn


def _draw_curves(path: Path, result: FitResult) -> None:
    """Draw data with error bars, best curves with bands, and residuals below."""
    quantities = list(dict.fromkeys(curve.quantity for curve in result.curves))
    with figure_of(path, 4.8 * len(quantities), 4.6) as figure:
        figure.set_layout_engine("constrained")
        grid = figure.subplots(
            2, len(quantities), squeeze=False, sharex="col", gridspec_kw={"height_ratios": (3, 1)}
        )
        for column, quantity in enumerate(quantities):
            upper, lower = grid[:, column]
            curves = [curve for curve in result.curves if curve.quantity == quantity]
            for number, curve in enumerate(curves):
                colour = COLOURS[number % len(COLOURS)]
                label = plain(Path(curve.name).name)
                upper.errorbar(
                    curve.time_min, curve.measured, curve.errors, fmt="o", ms=3, lw=0.8,
                    color=colour, label=label,
                )  # fmt: skip
                upper.plot(curve.fine_min, curve.fine, color=colour)
                band = curve.fine - curve.band, curve.fine + curve.band
                upper.fill_between(curve.fine_min, *band, color=colour, alpha=0.2, lw=0)
                lower.plot(curve.time_min, curve.residuals, "o", ms=3, color=colour)
            for axes in (upper, lower):
                axes.grid(True)
            lower.axhline(0, color="0.3", lw=0.8)
            lower.axhspan(-2, 2, color="0.93", zorder=0)
            largest = max(np.abs(curve.residuals).max() for curve in curves)
            lower.set_ylim(-1.1 * max(largest, 3.0), 1.1 * max(largest, 3.0))
            upper.set_ylabel(_LABELS[quantity])
            lower.set_xlabel("time (min)")
            lower.set_ylabel("residual / error")
            if len(curves) <= _MOST_NAMES:
                upper.legend(loc="upper left", fontsize=8)
            figure.align_ylabels([upper, lower])
        grid[0, 0].set_title("\n".join(map(_line, result.parameters[:4])), loc="left", fontsize=8)


def _line(one: Estimate) -> str:
    """Return a number with its interval."""
    unit = f" {one.unit}" if one.unit else ""
    return plain(f"{one.key} = {one.value:.3g}{unit} ({one.low:.3g} to {one.high:.3g})")


def _draw_correlation(path: Path, result: FitResult) -> None:
    names = [plain(_short(one.key)) for one in result.parameters]
    count = len(names)
    with figure_of(path, 3.4 + 0.75 * count, 1.9 + 0.6 * count) as figure:
        figure.set_layout_engine("constrained")
        axes: Axes = figure.add_subplot()
        image = axes.imshow(result.correlation, cmap="RdBu_r", vmin=-1, vmax=1)
        axes.set_xticks(range(count), names, rotation=30, ha="right")
        axes.set_yticks(range(count), names)
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
        for i in range(count):
            for j in range(count):
                value = float(result.correlation[i, j])
                text = "1" if i == j else f"{value:.4f}" if abs(value) > 0.99 else f"{value:.2f}"
                colour = "white" if abs(value) > 0.6 else "black"
                axes.text(
                    j, i, text.replace("-", "−"), ha="center", va="center", color=colour, fontsize=8
                )
        figure.colorbar(image, ax=axes, label="correlation", shrink=0.9)


def _short(key: str) -> str:
    """Return a key, and an offset by the name of its file."""
    return f"offset of {Path(key).name}" if key.startswith("offset of") else key


def _draw_profiles(path: Path, result: FitResult) -> None:
    count = len(result.profiles)
    with figure_of(path, 1.0 + 2.9 * count, 2.9) as figure:
        figure.set_layout_engine("constrained")
        grid = figure.subplots(1, count, squeeze=False, sharey=True)[0]
        for axes, profile in zip(grid, result.profiles, strict=True):
            estimate = result[profile.key]
            axes.plot(profile.values, profile.rise, "o-", color=COLOURS[0], ms=4)
            axes.axhline(CHI2, color=COLOURS[1], lw=1, ls="--")
            axes.axvspan(estimate.low, estimate.high, color="0.93", zorder=0)
            low, high = min(profile.values), max(profile.values)
            room = 0.06 * (high - low) or 0.1 * high
            axes.set_xlim(low - room, high + room)
            axes.set_ylim(0, min(1.05 * max(max(profile.rise), CHI2 * 1.1), 5 * CHI2))
            unit = f" ({estimate.unit})" if estimate.unit else ""
            axes.set_xlabel(plain(profile.key) + unit)
            axes.grid(True)
        grid[0].set_ylabel("rise of χ²")
        grid[0].annotate(
            "95 %", (0.02, CHI2), (0, 3), xycoords=("axes fraction", "data"),
            textcoords="offset points", color=COLOURS[1], fontsize=8,
        )  # fmt: skip
