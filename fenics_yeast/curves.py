"""Reference meridians: curves of revolution by arc length.

Arc length `S` runs from the bottom pole to the top pole, `R' = cos Φ`, `Z' = sin Φ`; the outward
normal is `(sin Φ, -cos Φ)`. Every function of `S` takes and returns arrays of one shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Curve(Protocol):
    """A reference meridian of the given length in µm."""

    @property
    def length(self) -> float: ...

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
