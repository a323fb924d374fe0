"""Dense output: values between the accepted steps of a run."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Array

_DEGREE = 3
_SAME = 1e-12  # relative difference of equal times


def times_within(time: Array, at: ArrayLike) -> Array:
    """Return times in min at which accepted steps can be interpolated, shape ``(times,)``.

    Raises
    ------
    ValueError
        If there are no steps in time, or a time lies outside of them.
    """
    wanted = np.atleast_1d(np.asarray(at, dtype=float))
    if len(time) < 2 or time[-1] <= time[0]:
        raise ValueError("no steps in time to interpolate between")
    first, last = float(time[0]), float(time[-1])
    near = _SAME * max(1.0, last)
    outside = wanted[~((wanted >= first - near) & (wanted <= last + near))]
    if len(outside):
        raise ValueError(
            f"{outside[0]:g} min lies outside the run, which goes from {first:g} to {last:g} min"
        )
    return wanted


def interpolate(time: Array, values: Array, kinks: Sequence[float], at: ArrayLike) -> Array:
    """Interpolate values of accepted steps by a cubic spline between each two kinks.

    The error falls with the fourth power of the step size, and so faster than that of time
    integration. Between kinks with fewer than four steps the degree is lower.

    Parameters
    ----------
    time, values
        Times of the steps in min, shape ``(n,)``; values there, shape ``(n, ...)``.
    kinks
        Times in min at which slopes jump; a step ends at each of them.
    at
        Times in min within those of the steps.

    Returns
    -------
    Array
        The values, shape ``(times, ...)``.

    Raises
    ------
    ValueError
        If there are no steps in time, or a time lies outside of them.
    """
    from scipy.interpolate import BarycentricInterpolator, make_interp_spline

    wanted = times_within(time, at)
    later = np.diff(time, prepend=-np.inf) > _SAME * np.abs(time)
    time, values = time[later], values[later]
    first, last = float(time[0]), float(time[-1])
    inside = [int(np.abs(time - kink).argmin()) for kink in kinks if first < kink < last]
    ends = sorted({0, *inside, len(time) - 1})
    found = np.empty((len(wanted), *values.shape[1:]))
    for start, end in pairwise(ends):
        here = (wanted >= time[start]) | (start == 0)
        here &= (wanted <= time[end]) | (end == len(time) - 1)
        if here.any():
            t, y = time[start : end + 1], values[start : end + 1]
            few = end - start < _DEGREE
            curve = BarycentricInterpolator(t, y) if few else make_interp_spline(t, y, k=_DEGREE)
            found[here] = curve(wanted[here])
    return found
