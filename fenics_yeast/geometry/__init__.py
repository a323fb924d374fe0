"""Curves of revolution and what lies on them: contours, zones, edges, meshes of the meridian.

Knows neither scenes nor dolfinx: everything here is NumPy.
"""

from __future__ import annotations

from .contour import ContourError, read_contour, smooth_contour
from .curves import Cap, Capsule, Curve, Polygon, Sphere, Straight, spheroid
from .intervals import NEAR, Interval, Intervals, apart, edges, merged, neck, polar_extent, within
from .mesh import Discretisation, place_nodes
from .supports import CONSTRAINED, Edge, End, Pole

__all__ = [
    "CONSTRAINED",
    "NEAR",
    "Cap",
    "Capsule",
    "ContourError",
    "Curve",
    "Discretisation",
    "Edge",
    "End",
    "Interval",
    "Intervals",
    "Pole",
    "Polygon",
    "Sphere",
    "Straight",
    "apart",
    "edges",
    "merged",
    "neck",
    "place_nodes",
    "polar_extent",
    "read_contour",
    "smooth_contour",
    "spheroid",
    "within",
]
