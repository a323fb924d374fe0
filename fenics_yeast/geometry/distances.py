"""Distances of measured points from a meridian, along its normals."""

from typing import NamedTuple

import numpy as np

from .curves import Array, Parametric

_SAMPLES = 1001  # of the curve, among which the nearest is looked for
_ITERATIONS = 20
_EXACT = 1e-12  # of the parameter's range, to which the foot of a normal is found
_SHIFTS, _STILL = 30, 1e-10  # iterations of the shift; of the cell's size, that no longer counts


class Distances(NamedTuple):
    """Distances of points from a meridian.

    Attributes
    ----------
    distance
        Signed distance in µm, positive outside, shape ``(n,)``.
    t
        Parameter of the foot of each normal.
    normal
        Outward unit normal `(n_r, n_z)` there, shape ``(n, 2)``. If the meridian moves by `v`, the
        distance changes by `-n · v`, to first order.
    shift
        What was added to the heights of the points, in µm.
    """

    distance: Array
    t: Array
    normal: Array
    shift: float = 0.0

    @property
    def root_mean_square(self) -> float:
        """Root mean square distance in µm."""
        return float(np.sqrt(np.mean(self.distance**2)))


def signed_distances(curve: Parametric, points: Array) -> Distances:
    """Return the distances of points from a meridian.

    Parameters
    ----------
    curve
        The meridian, from bottom to top.
    points
        `(r, z)` in µm, shape ``(n, 2)``. Points beyond the axis are taken from the other side;
        those beyond an edge have their distance from it.
    """
    points = np.column_stack([np.abs(points[:, 0]), points[:, 1]])
    sampled = np.linspace(0, curve.end, _SAMPLES)
    nearest = np.column_stack(curve.point(sampled, 0))
    gaps = np.hypot(*(points[:, None] - nearest).transpose(2, 0, 1))
    t = sampled[gaps.argmin(axis=1)]
    low, high = np.maximum(t - sampled[1], 0.0), np.minimum(t + sampled[1], curve.end)
    for _ in range(_ITERATIONS):
        x, x_t, x_tt = (np.column_stack(curve.point(t, order)) for order in range(3))
        slope = ((x - points) * x_t).sum(axis=1)  # of half the squared distance
        bend = (x_t**2).sum(axis=1) + ((x - points) * x_tt).sum(axis=1)
        low, high = np.where(slope < 0, t, low), np.where(slope > 0, t, high)
        newton = t - slope / np.where(bend > 0, bend, 1.0)
        inside = (bend > 0) & (low <= newton) & (newton <= high)
        before, t = t, np.where(inside, newton, (low + high) / 2)
        if np.abs(t - before).max(initial=0.0) < _EXACT * curve.end:
            break
    x, x_t = (np.column_stack(curve.point(t, order)) for order in range(2))
    tangent = x_t / np.hypot(*x_t.T)[:, None]
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    across = ((points - x) * normal).sum(axis=1)
    return Distances(np.where(across < 0, -1.0, 1.0) * np.hypot(*(points - x).T), t, normal)


def aligned_distances(curve: Parametric, points: Array) -> Distances:
    """Return the distances after the shift along the axis that makes their squares least.

    The parameters are those of `signed_distances`.
    """
    shift = float(np.mean(curve.point(np.array([0.0, curve.end]), 0)[1]) - np.ptp(points[:, 1]) / 2)
    shift -= float(points[:, 1].min())
    for _ in range(_SHIFTS):
        found = signed_distances(curve, points + np.array([0.0, shift]))
        axial = found.normal[:, 1]
        step = -float(axial @ found.distance) / (float(axial @ axial) or 1.0)
        shift += step
        if abs(step) < _STILL * np.ptp(points):
            break
    return signed_distances(curve, points + np.array([0.0, shift]))._replace(shift=shift)
