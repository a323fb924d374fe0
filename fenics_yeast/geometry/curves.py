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

_TABLE = 4000  # intervals of the parameter in which arc length is tabled
_NEWTON_STEPS = 2


class Curve(Protocol):
    """A reference meridian of the given length in µm.

    Attributes
    ----------
    joints
        Arc lengths in µm within the curve at which its curvature jumps.
    """

    @property
    def length(self) -> float: ...

    @property
    def joints(self) -> tuple[float, ...]: ...

    def radius(self, S: Array) -> Array:
        """`R(S)` in µm."""
        ...

    def height(self, S: Array) -> Array:
        """`Z(S)` in µm."""
        ...

    def angle(self, S: Array) -> Array:
        """`Φ(S)` in radians."""
        ...

    def curvature(self, S: Array) -> Array:
        """`Φ'(S)` in 1/µm."""
        ...


@dataclass(frozen=True)
class Sphere:
    """Meridian of a sphere of the given mid-surface radius in µm, centred at the origin."""

    R0: float
    joints = ()

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
class Cap:
    """Meridian of a part of a sphere, from an edge at height 0 to the top pole.

    Attributes
    ----------
    R0, half_angle
        Radius of the sphere in µm, polar angle of the edge in radians.
    """

    R0: float
    half_angle: float
    joints = ()

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
class Capsule:
    """Meridian of a cylinder between two half spheres, its lower pole at height 0.

    Attributes
    ----------
    R0, straight
        Radius and length of the cylinder in µm.
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
class Straight:
    """A straight meridian from radius `R1` at height 0 to radius `R2` at a height, in µm.

    That is a cone, a cylinder where the radii are equal, or a disc where it has no height.
    """

    R1: float
    R2: float
    top: float
    joints = ()

    @property
    def length(self) -> float:
        return float(np.hypot(self.R2 - self.R1, self.top))

    def radius(self, S: Array) -> Array:
        return self.R1 + (self.R2 - self.R1) * (S / self.length)

    def height(self, S: Array) -> Array:
        return self.top * (S / self.length)

    def angle(self, S: Array) -> Array:
        return np.full_like(S, np.arctan2(self.top, self.R2 - self.R1))

    def curvature(self, S: Array) -> Array:
        return np.zeros_like(S)


@dataclass(frozen=True)
class Parametric:
    """A smooth meridian given by a parameter; arc length, angle and curvature follow from it.

    Attributes
    ----------
    point
        Gives `(r, z)` in µm, or their derivatives of a given order, at parameters.
    end
        The parameter runs from 0 to here.
    """

    point: Callable[[Array, int], tuple[Array, Array]]
    end: float
    joints = ()

    @cached_property
    def _table(self) -> tuple[Array, Array, Array]:
        """Parameters, and arc length and angle there."""
        t = np.linspace(0, self.end, _TABLE + 1)
        nodes, weights = np.polynomial.legendre.leggauss(6)
        half = self.end / _TABLE / 2
        speeds = self._speed(t[:-1, None] + half * (1 + nodes))
        S = np.concatenate([[0.0], np.cumsum(half * speeds @ weights)])
        r_t, z_t = self.point(t, 1)
        return t, S, np.unwrap(np.arctan2(z_t, r_t))

    def _speed(self, t: Array) -> Array:
        return np.hypot(*self.point(t, 1))

    def _parameter(self, S: Array) -> Array:
        """Parameter at an arc length: from the table, then by Newton's method within a piece."""
        table, lengths, _ = self._table
        t = np.interp(S, lengths, table)
        i = np.clip(np.searchsorted(lengths, S, side="right") - 1, 0, _TABLE - 1)
        nodes, weights = np.polynomial.legendre.leggauss(6)
        for _ in range(_NEWTON_STEPS):
            half = (t - table[i]) / 2
            inner = self._speed(table[i][..., None] + half[..., None] * (1 + nodes))
            t = t + (S - lengths[i] - half * (inner @ weights)) / self._speed(t)
        return t

    @property
    def length(self) -> float:
        return float(self._table[1][-1])

    def radius(self, S: Array) -> Array:
        return self.point(self._parameter(S), 0)[0]

    def height(self, S: Array) -> Array:
        return self.point(self._parameter(S), 0)[1]

    def angle(self, S: Array) -> Array:
        t = self._parameter(S)
        r_t, z_t = self.point(t, 1)
        angle = np.arctan2(z_t, r_t)
        turns = np.interp(t, self._table[0], self._table[2]) - angle
        return angle + 2 * np.pi * np.rint(turns / (2 * np.pi))

    def curvature(self, S: Array) -> Array:
        return self.curvature_at(self._parameter(S))

    def curvature_at(self, t: Array) -> Array:
        """Curvature in 1/µm at parameters."""
        (r_t, z_t), (r_tt, z_tt) = self.point(t, 1), self.point(t, 2)
        return (r_t * z_tt - z_t * r_tt) / np.hypot(r_t, z_t) ** 3

    @property
    def least_radius(self) -> float:
        """Least radius of curvature of the meridian in µm."""
        return float(1 / np.abs(self.curvature_at(self._table[0])).max())


def spheroid(a: float, c: float) -> Parametric:
    """Meridian of a spheroid with the half axes a, from the axis, and c, along it, in µm."""

    def point(t: Array, order: int) -> tuple[Array, Array]:
        turned = t + order * np.pi / 2
        return a * np.sin(turned), -c * np.cos(turned)

    return Parametric(point, np.pi)


@dataclass(frozen=True)
class Polygon:
    """Straight conical elements between points of a curve: the paper's faceted meridian.

    Attributes
    ----------
    S, R, Z
        Arc length along the polygon, radius and height of its corners in µm, shape ``(n + 1,)``.
    """

    S: Array
    R: Array
    Z: Array
    joints = ()

    @classmethod
    def inscribed(cls, curve: Curve, S: Array) -> Polygon:
        """Polygon with its corners on a curve at the arc lengths `S` of that curve."""
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
        """Angle of the facet; at a corner the mean of its two neighbours."""
        facets = np.unwrap(np.arctan2(np.diff(self.Z), np.diff(self.R)))
        tiny = 1e-9 * self.length
        before = np.searchsorted(self.S[1:-1], S - tiny)
        after = np.searchsorted(self.S[1:-1], S + tiny)
        return (facets[before] + facets[after]) / 2

    def curvature(self, S: Array) -> Array:
        return np.zeros_like(S)
