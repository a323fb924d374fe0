"""Figures of results: curves, shapes, fields along the meridian, animations, ParaView surfaces.

Draws what it is given; matplotlib is imported when a figure is drawn.
"""

from .animation import AnimationError, animate
from .curves import LOST, Curve, pressures, volumes
from .modes import draw_mode, draw_modes, first_mode, write_mode
from .paraview import write_surfaces
from .run_figures import draw
from .shapes import shapes
from .style import COLOURS, curve_axes, figure_of, minutes, place, plain

__all__ = [
    "COLOURS",
    "LOST",
    "AnimationError",
    "Curve",
    "animate",
    "curve_axes",
    "draw",
    "draw_mode",
    "draw_modes",
    "figure_of",
    "first_mode",
    "minutes",
    "place",
    "plain",
    "pressures",
    "shapes",
    "volumes",
    "write_mode",
    "write_surfaces",
]  # fmt: skip
