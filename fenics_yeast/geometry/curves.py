"""Reference meridians: curves of revolution by arc length.

Arc length `S` runs from the lower to the upper end, `R' = cos Φ`, `Z' = sin Φ`; the outward normal
is `(sin Φ, -cos Φ)`. Every function of `S` takes and returns arrays of one shape.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEAR = 1e-9
"""Distance, in lengths of the meridian, below which two places on it are the same."""

_TABLE = 4000  # intervals of the parameter at which arc length is tabulated
_NEWTON_STEPS = 2
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


class Curve(Protocol):
    """A reference meridian; straight, unless a curve says otherwise."""

    @property
    def length(self) -> float:
        """Length in µm."""

    @property
    def joints(self) -> tuple[float, ...]:
        """Arc lengths in µm inside it at which its curvature jumps."""
        return ()

    def radius(self, S: Array) -> Array:
        """Return `R(S)` in µm."""

    def height(self, S: Array) -> Array:
        """Return `Z(S)` in µm."""

    def angle(self, S: Array) -> Array:
        """Return `Φ(S)` in radians."""

    def curvature(self, S: Array) -> Array:
        """Return `Φ'(S)` in 1/µm."""
        return np.zeros_like(S)


@dataclass(frozen=True)
class Sphere(Curve):
    """Meridian of a sphere of radius `R0` in µm, centred at the origin."""

    R0: float

    @property
    def length(self) -> float:
        return np.pi * self.R0

    def radius(self, S: Array) -> Array:
        return self.R0 * np.sin(S / self.R0)

    def height(self, S: Array) -> Array:
        return -self.R0 * np.cos(S / self.R0)

    def angle(self, S: Array) -> Array:
        return S / self.R0

    def curvature(self, S: Array) -> Array:
        return np.full_like(S, 1 / self.R0)


@dataclass(frozen=True)
class Cap(Curve):
    """Meridian of a part of a sphere, from an edge at height 0 to the top pole.

    `R0` is the radius of the sphere in µm, `half_angle` the polar angle of the edge in radians.
    """

    R0: float
    half_angle: float

    @property
    def length(self) -> float:
        return self.half_angle * self.R0

    def radius(self, S: Array) -> Array:
        return self.R0 * np.sin((self.length - S) / self.R0)

    def height(self, S: Array) -> Array:
        edge, here = self.half_angle, (self.length - S) / self.R0
        # cos(here) - cos(edge), without cancellation in shallow caps
        return 2 * self.R0 * np.sin((edge + here) / 2) * np.sin((edge - here) / 2)

    def angle(self, S: Array) -> Array:
        return np.pi - (self.length - S) / self.R0

    def curvature(self, S: Array) -> Array:
        return np.full_like(S, 1 / self.R0)


@dataclass(frozen=True)
class Capsule(Curve):
    """Meridian of a cylinder of radius `R0` between two hemispheres, its lower pole at height 0.

    `straight` is the length of the cylinder; both are in µm.
    """

    R0: float
    straight: float

    @property
    def length(self) -> float:
        return np.pi * self.R0 + self.straight

    @property
    def joints(self) -> tuple[float, ...]:
        quarter = np.pi * self.R0 / 2
        return quarter, quarter + self.straight

    def radius(self, S: Array) -> Array:
        return self.R0 * np.sin(self.angle(S))

    def height(self, S: Array) -> Array:
        start, end = self.joints
        return self.R0 * (1 - np.cos(self.angle(S))) + np.clip(S - start, 0, end - start)

    def angle(self, S: Array) -> Array:
        start, end = self.joints
        return np.where(S < end, np.minimum(S, start), S - self.straight) / self.R0

    def curvature(self, S: Array) -> Array:
        start, end = self.joints
        return np.where((S < start) | (S > end), 1 / self.R0, 0.0)


@dataclass(frozen=True)
class Straight(Curve):
    """A straight meridian from radius `R1` at height 0 to radius `R2` at height `top`, in µm.

    It is a cone, a cylinder if the radii are equal, or a disc if the height is 0.
    """

    R1: float
    R2: float
    top: float

    @property
    def length(self) -> float:
        return float(np.hypot(self.R2 - self.R1, self.top))

    def radius(self, S: Array) -> Array:
        return self.R1 + (self.R2 - self.R1) * (S / self.length)

    def height(self, S: Array) -> Array:
        return self.top * (S / self.length)

    def angle(self, S: Array) -> Array:
        return np.full_like(S, np.arctan2(self.top, self.R2 - self.R1))


@dataclass(frozen=True)
class Parametric(Curve):
    """A smooth meridian given by a parameter, from which its arc length follows.

    Attributes
    ----------
    point
        Function of parameters and an order: `(r, z)` in µm, or their derivatives of that order.
    end
        End of the range of the parameter, which begins at 0.
    """

    point: Callable[[Array, int], tuple[Array, Array]]
    end: float

    @cached_property
    def _table(self) -> tuple[Array, Array, Array]:
        """Parameters, and arc length and angle at them."""
        t = np.linspace(0, self.end, _TABLE + 1)
        half = self.end / _TABLE / 2
        speeds = self._speed(t[:-1, None] + half * (1 + _NODES))
        S = np.concatenate([[0.0], np.cumsum(half * speeds @ _WEIGHTS)])
        r_t, z_t = self.point(t, 1)
        return t, S, np.unwrap(np.arctan2(z_t, r_t))

    def _speed(self, t: Array) -> Array:
        return np.hypot(*self.point(t, 1))

    def arc_length(self, t: Array) -> Array:
        """Return the arc length in µm at parameters."""
        table, lengths, _ = self._table
        i = np.clip(np.searchsorted(table, t, side="right") - 1, 0, _TABLE - 1)
        return lengths[i] + self._integral(table[i], t)

    def _integral(self, start: Array, t: Array) -> Array:
        """Return the length of the curve between parameters that are near each other."""
        half = (t - start) / 2
        inner = self._speed(start[..., None] + half[..., None] * (1 + _NODES))
        return np.asarray(half * (inner @ _WEIGHTS))

    def parameter(self, S: Array) -> Array:
        """Return the parameter at arc lengths: from the table, then by Newton's method."""
        table, lengths, _ = self._table
        t = np.interp(S, lengths, table)
        i = np.clip(np.searchsorted(lengths, S, side="right") - 1, 0, _TABLE - 1)
        for _ in range(_NEWTON_STEPS):
            t = t + (S - lengths[i] - self._integral(table[i], t)) / self._speed(t)
        return t

    @property
    def length(self) -> float:
        return float(self._table[1][-1])

    def radius(self, S: Array) -> Array:
        return self.point(self.parameter(S), 0)[0]

    def height(self, S: Array) -> Array:
        return self.point(self.parameter(S), 0)[1]

    def angle(self, S: Array) -> Array:
        t = self.parameter(S)
        r_t, z_t = self.point(t, 1)
        angle = np.arctan2(z_t, r_t)
        turns = np.interp(t, self._table[0], self._table[2]) - angle
        return angle + 2 * np.pi * np.rint(turns / (2 * np.pi))

    def curvature(self, S: Array) -> Array:
        return self.curvature_at(self.parameter(S))

    def curvature_at(self, t: Array) -> Array:
        """Return the curvature in 1/µm at parameters."""
        (r_t, z_t), (r_tt, z_tt) = self.point(t, 1), self.point(t, 2)
        return (r_t * z_tt - z_t * r_tt) / np.hypot(r_t, z_t) ** 3

    @property
    def least_radius(self) -> float:
        """Least radius of curvature of the meridian in µm."""
        return float(1 / np.abs(self.curvature_at(self._table[0])).max())


def spheroid(a: float, c: float) -> Parametric:
    """Return the meridian of a spheroid: equatorial semi-axis `a`, polar semi-axis `c`, in µm."""

    def point(t: Array, order: int) -> tuple[Array, Array]:
        turned = t + order * np.pi / 2
        return a * np.sin(turned), -c * np.cos(turned)

    return Parametric(point, np.pi)


@dataclass(frozen=True)
class Polygon(Curve):
    """A meridian of straight conical elements, as in the paper.

    `S`, `R` and `Z` are arc length, radius and height of its corners in µm, shape ``(n + 1,)``.
    """

    S: Array
    R: Array
    Z: Array

    @classmethod
    def inscribed(cls, curve: Curve, S: Array) -> Polygon:
        """Return the polygon with its corners on a curve, at arc lengths of that curve."""
        R, Z = curve.radius(S), curve.height(S)
        R[np.isclose(R, 0, atol=1e-12 * curve.length)] = 0
        return cls(np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(R), np.diff(Z)))]), R, Z)

    @property
    def length(self) -> float:
        return float(self.S[-1])

    def radius(self, S: Array) -> Array:
        return np.interp(S, self.S, self.R)

    def height(self, S: Array) -> Array:
        return np.interp(S, self.S, self.Z)

    def angle(self, S: Array) -> Array:
        """Return the angle of the element; at a corner the mean of its two neighbours."""
        facets = np.unwrap(np.arctan2(np.diff(self.Z), np.diff(self.R)))
        near = NEAR * self.length
        before = np.searchsorted(self.S[1:-1], S - near)
        after = np.searchsorted(self.S[1:-1], S + near)
        return (facets[before] + facets[after]) / 2
