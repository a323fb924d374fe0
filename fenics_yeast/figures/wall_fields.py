"""What a profile shows along the meridian: its outline, and fields as means through the wall."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..geometry import Discretisation
from ..scene import Scene
from ..simulation import Profile, discretise

Array = NDArray[np.float64]


def outline(profile: Profile, finer: int) -> tuple[Array, Array, Array]:
    """`S, r, z` of the meridian, finer than the nodes: a coarse mesh of high degree is smooth.

    Parameters
    ----------
    profile
        The wall.
    finer
        Number of pieces between two nodes.
    """
    chord = np.hypot(np.diff(profile.r), np.diff(profile.z))
    r = hermite(profile.r, chord, np.cos(profile.psi), finer)
    z = hermite(profile.z, chord, np.sin(profile.psi), finer)
    return hermite(profile.S, np.diff(profile.S), np.ones_like(profile.S), finer), r, z


def hermite(values: Array, lengths: Array, slopes: Array, finer: int) -> Array:
    """Cubic pieces through values with given slopes, each in a number of pieces."""
    t = np.arange(finer)[:, None] / finer
    start, end = values[:-1], values[1:]
    m0, m1 = lengths * slopes[:-1], lengths * slopes[1:]
    blend = t**2 * (3 - 2 * t)
    inner = start + blend * (end - start) + t * (1 - t) * ((1 - t) * m0 - t * m1)
    return np.append(inner.T.ravel(), values[-1])


def zone_numbers(scene: Scene, S: Array) -> NDArray[np.int32]:
    """Number of the growing zone at arc lengths, from 1 on in the scene's order; 0 for none."""
    numbers = np.zeros(len(S), dtype=np.int32)
    if scene.growth is not None:
        for number, zone in enumerate(_cut(scene).zones, start=1):
            for part in zone:
                numbers[part.holds(S)] = number
    return numbers


@lru_cache(maxsize=4)
def _cut(scene: Scene) -> Discretisation:
    """The scene's cells, which every profile of its run shares."""
    return discretise(scene)


def mean(profile: Profile, values: Array) -> Array:
    """Mean through the wall of values at its points, shape ``(points, n, ...)``."""
    weights = np.polynomial.legendre.leggauss(len(profile.xi))[1] / 2
    return np.einsum("pj...,j->p...", values, weights)


def area_strain(profile: Profile) -> Array:
    """Growth strain `ε1 + ε2`, the mean through the wall, shape ``(points,)``."""
    return mean(profile, profile.growth_strain.sum(axis=2))


def stress_ratio(profile: Profile, scene: Scene) -> Array:
    """`‖σ‖/σ_trs`, the mean through the wall, shape ``(points,)``.

    Where nothing grows the threshold is the lowest of the scene's.
    """
    thresholds = np.array([growth.threshold for growth in scene.growing])
    numbers = zone_numbers(scene, profile.S_points)
    local = np.where(numbers > 0, thresholds[numbers - 1], thresholds.min())
    return mean(profile, np.linalg.norm(profile.stress, axis=2)) / local
