"""Pictures of buckling modes: critical pressures over waves, profile and buckled shape."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry import Array
from .style import COLOURS, figure_of, place, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..simulation import BucklingMode

_AROUND = 96  # points of a ring
_WIDE = 10.0  # range of pressures from which on they have a logarithmic axis
_AMPLITUDE = 0.2  # largest displacement that is drawn, over the largest radius


def draw_modes(modes: Sequence[BucklingMode], title: str, path: Path) -> None:
    """Draw the garland of critical pressures, and the first mode: its profile and its shape.

    Parameters
    ----------
    modes
        A mode for each number of waves, some with a critical pressure.
    title
        Title of the figure.
    path
        PNG, PDF or SVG file; its directory is created if missing.
    """
    from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

    known = [mode for mode in modes if mode.pressure is not None]
    first = first_mode(known)
    with figure_of(path, 7.4, 3.2) as figure:
        garland = place(figure, 0.75, 0.55, 2.3, 2.2)
        pressures = [-1e3 * mode.pressure for mode in known if mode.pressure is not None]
        waves = [mode.waves for mode in known]
        garland.plot(waves, pressures, "o-", color=COLOURS[0], ms=4)
        garland.plot([first.waves], [min(pressures)], "o", color=COLOURS[1], ms=6)
        garland.set_xlabel("waves around the axis n")
        garland.set_ylabel("critical external pressure (kPa)")
        garland.xaxis.set_major_locator(MaxNLocator(integer=True))
        if max(pressures) > _WIDE * min(pressures):
            garland.set_yscale("log")
            garland.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            garland.yaxis.set_major_formatter("{x:g}")
            garland.yaxis.set_minor_formatter(NullFormatter())
        else:
            garland.set_ylim(bottom=0)
        garland.set_title(plain(title))
        garland.grid(True)
        _profile(place(figure, 3.75, 0.55, 1.5, 2.2), first)
        _shape(figure, 0.72, 0.27, first)


def draw_mode(mode: BucklingMode, title: str, path: Path) -> None:
    """Draw the mode of a bifurcation: its profile along the meridian and the buckled shape.

    Parameters
    ----------
    mode, title, path
        As in `draw_modes`.
    """
    with figure_of(path, 4.6, 3.2) as figure:
        profile = place(figure, 0.75, 0.55, 1.6, 2.2)
        _profile(profile, mode)
        profile.set_title("")
        figure.text(0.5, 0.96, plain(title), ha="center", va="center")
        _shape(figure, 0.54, 0.44, mode)


def _profile(axes: Axes, mode: BucklingMode) -> None:
    """Draw the displacements of a mode along the meridian."""
    names = ("radial", "around", "axial")
    for name, colour in zip(names, COLOURS[:3], strict=True):
        axes.plot(getattr(mode, name), mode.S, color=colour, label=name)
    axes.set_xlabel("displacement (1)")
    axes.set_ylabel("arc length (µm)")
    axes.set_title(f"mode with n = {mode.waves}")
    axes.legend(fontsize=7, loc="best", handlelength=1)


def _shape(figure: Figure, left: float, width: float, mode: BucklingMode) -> None:
    """Draw the buckled wall in three dimensions, red where it bulges; places are parts of 1."""
    from matplotlib import colormaps

    shape: Any = figure.add_axes((left, 0.0, width, 0.88), projection="3d")
    x, y, z = _surface(mode, amplitude_of(mode))
    outward = np.outer(mode.radial, np.cos(mode.waves * _angles()))
    middles = (outward[1:, 1:] + outward[:-1, :-1]) / 2 / (abs(outward).max() or 1.0)
    shape.plot_surface(
        x, y, z, facecolors=colormaps["RdBu_r"](0.5 + 0.4 * middles), linewidth=0, rstride=1,
        cstride=1, shade=True, antialiased=False,
    )  # fmt: skip
    shape.set_box_aspect((np.ptp(x), np.ptp(y), np.ptp(z)), zoom=1.15)
    shape.view_init(elev=38, azim=-75)
    shape.patch.set_visible(False)
    shape.set_axis_off()
    amplitude = f"n = {mode.waves}, buckled by {amplitude_of(mode):.2g} µm"
    figure.text(left + width / 2, 0.89, amplitude, ha="center")


def write_mode(mode: BucklingMode, path: Path) -> None:
    """Write the buckled shape for ParaView (VTU), with the displacement in µm at each point."""
    import meshio

    amplitude = amplitude_of(mode)
    shape, rest = _surface(mode, amplitude), _surface(mode, 0.0)
    rings, around = rest[0].shape
    index = np.arange(rings * around).reshape(rings, around)
    quads = np.column_stack(
        [part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1])]
    )
    points = np.column_stack([x.ravel() for x in shape])
    moved = points - np.column_stack([x.ravel() for x in rest])
    mesh = meshio.Mesh(points, [("quad", quads)], point_data={"displacement (µm)": moved})
    temporary = path.with_name(path.name + ".part")
    path.parent.mkdir(parents=True, exist_ok=True)
    mesh.write(temporary, file_format="vtu")
    temporary.replace(path)


def first_mode(modes: Sequence[BucklingMode]) -> BucklingMode:
    """Return the mode of the least critical external pressure."""
    return max(modes, key=lambda mode: mode.pressure or -np.inf)


def amplitude_of(mode: BucklingMode) -> float:
    """Return the largest displacement in µm that is drawn."""
    return _AMPLITUDE * float(mode.r.max())


def _surface(mode: BucklingMode, amplitude: float) -> tuple[Array, Array, Array]:
    """Return the points of the surface moved by the mode, each of shape ``(rings, around)``."""
    theta = _angles()
    cos, sin = np.cos(mode.waves * theta), np.sin(mode.waves * theta)
    r = mode.r[:, None] + amplitude * mode.radial[:, None] * cos
    t = amplitude * mode.around[:, None] * sin
    x, y = r * np.cos(theta) - t * np.sin(theta), r * np.sin(theta) + t * np.cos(theta)
    return x, y, mode.z[:, None] + amplitude * mode.axial[:, None] * cos


def _angles() -> Array:
    return np.linspace(0, 2 * np.pi, _AROUND + 1)
