"""Pictures of buckling modes: critical pressures over waves, profile and buckled shape."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry import Array
from .style import COLOURS, figure_of, place, plain

if TYPE_CHECKING:
    from ..simulation import BucklingMode

_AROUND = 96  # points of a ring
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
        garland.set_ylim(bottom=0)
        garland.set_title(plain(title))
        garland.grid(True)
        profile = place(figure, 3.75, 0.55, 1.5, 2.2)
        names = ("radial", "around", "axial")
        for name, colour in zip(names, COLOURS[:3], strict=True):
            profile.plot(getattr(first, name), first.S, color=colour, label=name)
        profile.set_xlabel("displacement (1)")
        profile.set_ylabel("arc length (µm)")
        profile.set_title(f"mode with n = {first.waves}")
        profile.legend(fontsize=7, loc="best", handlelength=1)
        shape: Any = figure.add_axes((0.72, 0.0, 0.27, 0.88), projection="3d")
        x, y, z = _surface(first, amplitude_of(first))
        shape.plot_surface(
            x, y, z, color="#9ecae1", linewidth=0, rstride=1, cstride=1, shade=True
        )  # fmt: skip
        shape.set_box_aspect((np.ptp(x), np.ptp(y), np.ptp(z)), zoom=1.15)
        shape.view_init(elev=38, azim=-75)
        shape.patch.set_visible(False)
        shape.set_axis_off()
        figure.text(0.85, 0.89, f"buckled by {amplitude_of(first):.2g} µm", ha="center")


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
    theta = np.linspace(0, 2 * np.pi, _AROUND + 1)
    cos, sin = np.cos(mode.waves * theta), np.sin(mode.waves * theta)
    r = mode.r[:, None] + amplitude * mode.radial[:, None] * cos
    t = amplitude * mode.around[:, None] * sin
    x, y = r * np.cos(theta) - t * np.sin(theta), r * np.sin(theta) + t * np.cos(theta)
    return x, y, mode.z[:, None] + amplitude * mode.axial[:, None] * cos
