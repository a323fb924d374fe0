"""How well data fix the numbers of a fit: intervals, correlations, and warnings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ..geometry import Array
from ..scene import FitProblem

NORMAL = 1.959963984540054  # standard deviations of an interval of 95 %
CHI2 = NORMAL**2  # rise of chi2 at its ends
_ONE = 0.99  # correlation from which two numbers are fixed only together
_FACTOR = 2.0  # width of an interval from which it says little
_LEAST = 1e-9  # singular value, relative to the largest, below which data say nothing
_STRESS = re.compile(
    r"turgor\.pressure|wall\.(shear_modulus|young_modulus)|growth(\.\d+)?\.threshold"
)
_MODULUS = ("wall.shear_modulus", "wall.young_modulus")
_TURGOR = 'a curve at another turgor, set = { "turgor.pressure" = ... }'


def covariance(jacobian: Array) -> Array:
    """Return the covariance of the unknowns, from residuals in units of the noise."""
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1e-12  # data that do not depend on an unknown do not fix it
    _, s, V = np.linalg.svd(jacobian / scale, full_matrices=False)
    s = np.maximum(s, _LEAST * max(s[0], 1e-300))
    inverse: Array = (V.T / s**2) @ V / np.outer(scale, scale)
    return inverse


def correlations(C: Array) -> Array:
    """Return the correlations of a covariance."""
    deviations = np.sqrt(np.diag(C))
    R: Array = C / np.outer(deviations, deviations)
    return R


def half_widths(C: Array) -> Array:
    """Return half of the intervals of 95 % of the unknowns, in their logarithms or min."""
    return np.minimum(NORMAL * np.sqrt(np.diag(C)), 300.0)


def data_warnings(problem: FitProblem, names: Sequence[str], C: Array) -> list[str]:
    """Return warnings of numbers that the data fix only together, or hardly."""
    R, widths, logs = correlations(C), half_widths(C), len(problem.varied)
    found = []
    for i, j in combinations(range(len(names)), 2):
        if abs(R[i, j]) > _ONE:
            found.append(
                f"the data fix {names[i]} and {names[j]} only together (correlation "
                f"{R[i, j]:.4f}); {_advice(problem, names[i], names[j])}"
            )
    for name, width in zip(names[:logs], widths, strict=False):
        factor = np.exp(2 * width)
        if factor > _FACTOR:
            size = f"{factor:.3g}" if factor < 1e6 else "more than a million"
            found.append(
                f"the data hardly fix {name}: the ends of its interval differ by a factor of {size}"
            )
    return found


def _advice(problem: FitProblem, *pair: str) -> str:
    """Return what separates a pair of numbers."""
    kept = {name for name in pair if not name.startswith("offset")}
    if len(kept) < len(pair):
        return "measure earlier and later times, or give the offset"
    if kept <= set(_stresses(problem)):
        return "only ratios of stresses matter; give one of them"
    if "turgor.pressure" in kept:
        return "give one of them, measured in another way"
    if _turgors(problem) > 1:
        return "add a curve at a turgor that differs more, or less noise"
    return f"to separate them, add {_TURGOR}"


def structural_warnings(problem: FitProblem) -> list[str]:
    """Return warnings of varied numbers that are one by the model, or nearly so, before a run."""
    keys = [varied.key for varied in problem.varied]
    found = []
    stresses = _stresses(problem)
    fixed = [key for key in ("turgor.pressure",) if key not in keys]
    lengths = {curve.column for curve in problem.curves} <= {"volume_ratio"}
    if len(stresses) > 1 and not fixed and _every_stress(problem):
        found.append(
            f"{_listed(stresses)} scale together without changing any curve: only their ratios "
            "can be fitted; remove one of them from vary"
        )
    if "wall.thickness" in keys and "turgor.pressure" in keys:
        found.append(
            "turgor.pressure and wall.thickness are nearly one number: stresses in a thin wall "
            "depend on their ratio; remove one of them from vary"
        )
    elif "wall.thickness" in keys and _every_stress(problem):
        others = [key for key in stresses if key != "turgor.pressure"]
        found.append(
            f"wall.thickness and {_listed(others)} are nearly one number: only their products "
            "matter in a thin wall; remove one of them from vary"
        )
    if lengths and {"cell.diameter", "wall.thickness"} <= set(keys):
        found.append(
            "cell.diameter and wall.thickness scale together without changing V/V0: only their "
            "ratio can be fitted; remove one of them from vary, or measure volume_um3"
        )
    for key in keys:
        zone, _, name = key.rpartition(".")
        other = f"{zone}.threshold"
        if name == "time" and other in keys and _experiments(problem) == 1:
            found.append(
                f"{other} and {key} are nearly one number to curves of one experiment: a lower "
                f"threshold looks like faster growth; to separate them, add {_TURGOR}"
            )
    return found


def _stresses(problem: FitProblem) -> list[str]:
    """Return the varied keys of stresses."""
    return [each.key for each in problem.varied if _STRESS.fullmatch(each.key)]


def _every_stress(problem: FitProblem) -> bool:
    """Whether the modulus, and every threshold, are varied."""
    stresses = _stresses(problem)
    thresholds = [key for key in stresses if key.endswith("threshold")]
    modulus = any(key in stresses for key in _MODULUS)
    return modulus and len(thresholds) == len(problem.scene.growing)


def _experiments(problem: FitProblem) -> int:
    return len({problem.scene.with_values(curve.set) for curve in problem.curves})


def _turgors(problem: FitProblem) -> int:
    return len({problem.scene.with_values(curve.set).turgor for curve in problem.curves})


def _listed(names: Sequence[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
