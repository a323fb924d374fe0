"""Figures of results: curves, shapes, fields along the meridian, animations, ParaView surfaces.

Draws what it is given; matplotlib is imported when a figure is drawn.
"""

from __future__ import annotations

from .curves import Curve, pressures, volumes
from .film import FilmError, animate
from .paraview import write_surfaces
from .run_figures import draw, draw_all
from .shapes import shapes
from .style import COLOURS, figure_of

__all__ = [
    "COLOURS",
    "Curve",
    "FilmError",
    "animate",
    "draw",
    "draw_all",
    "figure_of",
    "pressures",
    "shapes",
    "volumes",
    "write_surfaces",
]
