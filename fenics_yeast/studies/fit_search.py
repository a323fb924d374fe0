"""Least squares of a fit, from one start or several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..geometry import Array
from ..scene import FitProblem
from .fit_model import Evaluation, FitModel, Unknowns

_MOST = 60  # evaluations from one start
_EXACT = 1e-6  # relative change of unknowns or of chi2 at which a search ends
_SEED = 17


@dataclass(frozen=True)
class Solution:
    """The best evaluation of a search, and the number of runs that it took."""

    best: Evaluation
    runs: int


def guesses(problem: FitProblem) -> list[Array]:
    """Return the first guesses: the start, then points of a Latin hypercube within the limits."""
    unknowns = Unknowns(problem)
    places = [unknowns.start]
    if problem.starts > 1:
        from scipy.stats import qmc

        low, high = unknowns.limits
        cube = qmc.LatinHypercube(len(low), seed=_SEED).random(problem.starts - 1)
        places += list(low + cube * (high - low))
    return places


def search(model: FitModel, start: Array, held: int | None = None) -> Solution:
    """Minimise the squares of the residuals from a start; an unknown may be held at its start.

    Runs that end early have large residuals; a search that only meets such runs ends with an
    evaluation that is not complete.
    """
    from scipy.optimize import least_squares

    before = model.runs
    moving = [i for i in range(len(start)) if i != held]
    low, high = (limit[moving] for limit in model.unknowns.limits)
    seen: dict[bytes, Evaluation] = {}

    def at(moved: Array) -> Evaluation:
        if moved.tobytes() not in seen:
            x = np.array(start, dtype=float)
            x[moving] = moved
            seen[moved.tobytes()] = model.evaluate(x)
        return seen[moved.tobytes()]

    if not moving:
        return Solution(model.evaluate(np.array(start, dtype=float)), model.runs - before)
    inside = 1e-9 * (high - low)
    first = np.clip(start[moving], low + inside, high - inside)
    found = least_squares(
        lambda moved: at(moved).residuals,
        first,
        jac=lambda moved: at(moved).jacobian[:, moving],
        bounds=(low, high),
        x_scale="jac",
        method="trf",
        loss=model.problem.loss,
        xtol=_EXACT,
        ftol=_EXACT,
        max_nfev=_MOST,
    )
    best = at(found.x)
    return Solution(best, model.runs - before)


def best_of(solutions: Sequence[Solution], problem: FitProblem) -> Solution:
    """Return the best of several searches, with the runs of all."""
    order = sorted(solutions, key=lambda one: (not one.best.complete, cost(one.best, problem)))
    return replace(order[0], runs=sum(one.runs for one in solutions))


def cost(evaluation: Evaluation, problem: FitProblem) -> float:
    """Return what a search minimises: chi2, with outliers given less weight if so chosen."""
    z = evaluation.residuals**2
    losses: dict[str, Callable[[Array], Array]] = {
        "linear": lambda z: z,
        "soft_l1": lambda z: 2 * (np.sqrt(1 + z) - 1),
        "huber": lambda z: np.where(z <= 1, z, 2 * np.sqrt(z) - 1),
        "cauchy": np.log1p,
    }
    return float(losses[problem.loss](z).sum())
