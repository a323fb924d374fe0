"""Fields along the meridian of a profile: outline, growing zones, means through the wall."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry import Array, Intervals
from ..simulation import Profile


def outline(profile: Profile, finer: int) -> tuple[Array, Array, Array]:
    """Return `S, r, z` of the meridian with a number of points between two nodes."""
    chord = np.hypot(np.diff(profile.r), np.diff(profile.z))
    r = hermite(profile.r, chord, np.cos(profile.psi), finer)
    z = hermite(profile.z, chord, np.sin(profile.psi), finer)
    return hermite(profile.S, np.diff(profile.S), np.ones_like(profile.S), finer), r, z


def hermite(values: Array, lengths: Array, slopes: Array, finer: int) -> Array:
    """Interpolate values with given slopes by cubics, with a number of points on each.

    Slopes refer to the lengths of the pieces, which need not add up to one parameter.
    """
    t = np.arange(finer)[:, None] / finer
    start, end = values[:-1], values[1:]
    m0, m1 = lengths * slopes[:-1], lengths * slopes[1:]
    blend = t**2 * (3 - 2 * t)
    inner = start + blend * (end - start) + t * (1 - t) * ((1 - t) * m0 - t * m1)
    return np.append(inner.T.ravel(), values[-1])


def zone_numbers(zones: Sequence[Intervals], S: Array) -> NDArray[np.int32]:
    """Return the number of the growing zone at arc lengths, from 1; 0 outside all zones."""
    numbers = np.zeros(len(S), dtype=np.int32)
    for number, zone in enumerate(zones, start=1):
        for part in zone:
            numbers[part.holds(S)] = number
    return numbers


def mean(profile: Profile, values: Array) -> Array:
    """Return the mean through the wall of values of shape ``(points, n, ...)``."""
    weights = np.polynomial.legendre.leggauss(len(profile.xi))[1] / 2
    return np.einsum("pj...,j->p...", values, weights)


def area_strain(profile: Profile) -> Array:
    """Return the growth strain `ε1 + ε2`, the mean through the wall, shape ``(points,)``."""
    return mean(profile, profile.growth_strain.sum(axis=2))


def stress_ratio(
    profile: Profile, zones: Sequence[Intervals], thresholds: Sequence[float]
) -> Array:
    """Return `‖σ‖/σ_trs`, the mean through the wall, shape ``(points,)``.

    Outside all zones, σ_trs is the lowest threshold.
    """
    numbers = zone_numbers(zones, profile.S_points)
    local = np.where(numbers > 0, np.array(thresholds)[numbers - 1], min(thresholds))
    return mean(profile, np.linalg.norm(profile.stress, axis=2)) / local
