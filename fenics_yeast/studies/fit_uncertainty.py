"""Uncertainty of a fit beyond its Jacobian: profiles of chi2, and fits to made data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..geometry import Array
from ..scene import FitProblem
from .fit_model import Evaluation, Unknowns
from .fit_result import Estimate, FitResult, Profile
from .fit_search import cost
from .fit_statistics import CHI2
from .fit_tasks import Task, Team

_PLACES = np.array([-2.2, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.2])  # of a profile, in half intervals
_WIDEST = 1.2  # largest half interval that a profile follows, in logarithms
_SEED = 23


def profiles(
    problem: FitProblem, best: Evaluation, result: FitResult, team: Team
) -> tuple[Profile, ...]:
    """Return the profile of each varied number: the others are fitted again beside its values."""
    unknowns = Unknowns(problem)
    low, high = unknowns.limits
    tasks, places = [], []
    for i in range(len(problem.varied)):
        estimate = result.parameters[i]
        width = min(np.log(estimate.high / estimate.low) / 2, _WIDEST)
        for place in np.clip(best.x[i] + _PLACES * width, low[i], high[i]).tolist():
            start = np.clip(_along(best, i, place), low, high)
            tasks.append(Task(problem, start, i))
            places.append((i, place))
    solutions = team.run(tasks)
    least, found = cost(best, problem), []
    for i, varied in enumerate(problem.varied):
        points = [(best.x[i], 0.0)]
        for (number, place), solution in zip(places, solutions, strict=True):
            if number == i and solution.best.complete:
                points.append((place, cost(solution.best, problem) - least))
        points.sort()
        values = tuple(float(np.exp(place)) for place, _ in points)
        found.append(Profile(varied.key, values, tuple(rise for _, rise in points)))
    return tuple(found)


def _along(best: Evaluation, held: int, place: float) -> Array:
    """Return the linear prediction of the best unknowns with one of them held at a place."""
    x = best.x.copy()
    x[held] = place
    others = [i for i in range(len(x)) if i != held]
    if others:
        J, change = best.jacobian, place - best.x[held]
        x[others] -= np.linalg.lstsq(J[:, others], J[:, held] * change, rcond=1e-8)[0]
    return x


def ends(estimates: Sequence[Estimate], found: Sequence[Profile]) -> tuple[Estimate, ...]:
    """Return estimates with the intervals of their profiles; open ones keep their own ends."""
    new = list(estimates)
    for i, profile in enumerate(found):
        x, root = np.log(profile.values), np.sqrt(np.maximum(profile.rise, 0.0))
        middle = int(np.argmin(root))
        sides = {"low": slice(middle, None, -1), "high": slice(middle, None)}
        for name, side in sides.items():
            rises = root[side]
            if len(rises) > 1 and rises[-1] >= CHI2**0.5 and (np.diff(rises) > 0).all():
                end = float(np.exp(np.interp(CHI2**0.5, rises, x[side])))
                new[i] = replace(new[i], **{name: end})  # type: ignore[arg-type]
    return tuple(new)


def bootstrap(
    problem: FitProblem, best: Evaluation, result: FitResult, number: int, team: Team
) -> Array:
    """Return the values fitted to made data: the best curves with noise as it was given."""
    random, tasks = np.random.default_rng(_SEED), []
    for _ in range(number):
        curves = tuple(
            replace(
                curve,
                values=np.maximum(
                    fitted.model + fitted.errors * random.standard_normal(len(fitted.model)),
                    1e-3 * fitted.model,
                ).tolist(),
                # of the measured values, as in the fit
                noise=(fitted.errors / fitted.model).tolist(),
            )
            for curve, fitted in zip(problem.curves, result.curves, strict=True)
        )
        tasks.append(Task(replace(problem, curves=curves), best.x))
    unknowns = Unknowns(problem)
    solutions = team.run(tasks)
    return np.array([unknowns.values(one.best.x) for one in solutions if one.best.complete])
