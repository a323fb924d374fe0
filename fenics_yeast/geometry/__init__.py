"""Curves of revolution and what lies on them: contours, zones, supports, meshes of the meridian.

Knows neither scenes nor dolfinx: everything here is NumPy and SciPy.
"""

from .contour import Smoothing, describe_smoothing, smooth_contour
from .contour_file import Contour, ContourError, read_contour, read_contours
from .curves import (
    NEAR,
    Array,
    Cap,
    Capsule,
    Curve,
    Parametric,
    Polygon,
    Sphere,
    Straight,
    spheroid,
)
from .displaced import curve_through, displaced
from .distances import Distances, aligned_distances, signed_distances
from .intervals import Interval, Intervals, apart, edges, merged, neck, polar_extent, within
from .mesh import Discretisation, place_nodes
from .supports import CONSTRAINED, Edge, End, Pole, Poles

__all__ = [
    "CONSTRAINED",
    "NEAR",
    "Array",
    "Cap",
    "Capsule",
    "Contour",
    "ContourError",
    "Curve",
    "Discretisation",
    "Distances",
    "Edge",
    "End",
    "Interval",
    "Intervals",
    "Parametric",
    "Pole",
    "Poles",
    "Polygon",
    "Smoothing",
    "Sphere",
    "Straight",
    "aligned_distances",
    "apart",
    "curve_through",
    "describe_smoothing",
    "displaced",
    "edges",
    "merged",
    "neck",
    "place_nodes",
    "polar_extent",
    "read_contour",
    "read_contours",
    "signed_distances",
    "smooth_contour",
    "spheroid",
    "within",
]  # fmt: skip
