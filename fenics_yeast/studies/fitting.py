"""Fit numbers of a scene to measured curves, by least squares in logarithms.

Each run of the search is differentiated exactly, so that its choice of steps does not disturb it.
Searches from several starts, profiles and made data share the processes of this machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry import Array
from ..scene import FitProblem, MeasuredCurve, Scene
from . import fit_statistics as statistics
from .fit_model import Evaluation, FitModel, Unknowns
from .fit_result import Estimate, FitResult, FittedCurve, NoFit
from .fit_search import best_of, guesses
from .fit_tasks import Task, Team
from .fit_uncertainty import bootstrap as made_fits
from .fit_uncertainty import ends, profiles

if TYPE_CHECKING:
    from ..simulation import ShellPool

_FINE = 121  # points of a drawn curve
_NEAR = 1e-4  # of an unknown to its limit, in logarithms or min
_UNLIKELY = 1e-3  # probability below which chi2 contradicts the noise


def fit(
    scene: Scene,
    curves: Iterable[MeasuredCurve],
    *,
    vary: Sequence[str] | Mapping[str, Mapping[str, object]],
    **options: Any,
) -> FitResult:
    """Fit numbers of a scene to measured curves.

    Parameters
    ----------
    scene
        A scene in time. Its run is lengthened or shortened to the measured times.
    curves
        Measured curves, see `MeasuredCurve`.
    vary
        Keys of positive numbers of the scene, or a mapping from keys to limits and first values,
        such as ``{"growth.time": {"from": "20 min", "to": 90, "start": 45}}``. By default, the
        scene has the first value, and limits are a thirtieth and thirty times of it.
    options
        `loss` and `starts` as in `FitProblem`; `profile`, `bootstrap` and `jobs` as in
        `fit_problem`.

    Returns
    -------
    FitResult
        Values, intervals and warnings.

    Raises
    ------
    SceneError
        If these do not make a fit.
    NoFit
        If no run reaches the last measured time.
    """
    own = {name: options.pop(name) for name in ("loss", "starts") if name in options}
    return fit_problem(FitProblem.of(scene, curves, vary, **own), **options)


def fit_problem(
    problem: FitProblem,
    *,
    profile: bool = False,
    bootstrap: int = 0,
    jobs: int = 1,
    start: Sequence[float] | None = None,
    tried: Callable[[Evaluation], None] | None = None,
    shells: ShellPool | None = None,
) -> FitResult:
    """Fit what a file describes.

    Parameters
    ----------
    problem
        The fit, such as `FitProblem.load` reads it.
    profile
        Whether to find the intervals from the least chi2 with each number held.
    bootstrap
        Number of fits to made data, with the noise of the measured ones.
    jobs
        Number of processes; with more than one, call it below ``if __name__ == "__main__"``.
    start
        First values of the unknowns, instead of those of the problem.
    tried
        Called with each evaluation, in the order in which they become known.
    shells
        Shells kept from one fit to the next, so that only the first one compiles.

    Raises
    ------
    SceneError
        If a scene is not valid at the first values.
    NoFit
        If no run reaches the last measured time.
    """
    from ..simulation import ShellPool

    began = perf_counter()
    unknowns = Unknowns(problem)
    with ShellPool() as own:
        model = FitModel(problem, own if shells is None else shells, tried)
        first, *others = guesses(problem)
        if start is not None:
            first = unknowns.place(np.asarray(start, dtype=float))
        model.check(first)
        team = Team(model, jobs)
        searches = team.run([Task(problem, guess) for guess in (first, *others)])
        solution = best_of(searches, problem)
        best = solution.best
        if not best.complete:
            raise NoFit(
                "no fit found: no run tried reaches the last measured time "
                f"({best.message or 'all ended early'}); start nearer, or set starts = 10"
            )
        result = _result(model, best)
        if profile:
            found = profiles(problem, best, result, team)
            result = replace(
                result, profiles=found, parameters=ends(result.parameters, found),
                intervals="95 %, from the profile of chi2, for the given noise",
            )  # fmt: skip
        if bootstrap:
            result = replace(result, bootstrap=made_fits(problem, best, result, bootstrap, team))
        return replace(result, runs=model.runs + team.runs, seconds=perf_counter() - began)


def expected(problem: FitProblem) -> FitResult:
    """Return the intervals to expect at the first values, for the times and noise of the curves.

    Measured values are not used, except that their noise is relative.
    """
    from ..simulation import ShellPool

    began = perf_counter()
    with ShellPool() as shells:
        model = FitModel(problem, shells)
        model.check(model.unknowns.start)
        at = model.evaluate(model.unknowns.start)
        if not at.complete:
            raise NoFit(f"the run ends before the last time: {at.message}")
        result = _result(model, at, judged=False)
        return replace(result, runs=model.runs, seconds=perf_counter() - began)


def _result(model: FitModel, best: Evaluation, judged: bool = True) -> FitResult:
    """Return the result at the best evaluation; `judged` if its data are measured ones."""
    problem, unknowns = model.problem, model.unknowns
    C = statistics.covariance(best.jacobian)
    widths, values, logs = statistics.half_widths(C), unknowns.values(best.x), len(problem.varied)
    limits = unknowns.limits
    stopped = [bool(np.min(np.abs(np.array(limits)[:, i] - best.x[i])) < _NEAR)
               for i in range(len(values))]  # fmt: skip
    low, high = unknowns.values(best.x - widths), unknowns.values(best.x + widths)
    parameters = tuple(
        Estimate(*each)
        for each in zip(unknowns.names, values.tolist(), low.tolist(), high.tolist(),
                        unknowns.units, stopped, strict=True)
    )  # fmt: skip
    freedom = len(best.residuals) - len(values)
    warnings = statistics.structural_warnings(problem)
    warnings += statistics.data_warnings(problem, unknowns.names, C)
    if judged:
        warnings += [f"{each.key} is at a limit, {each.value:.6g} {each.unit}; widen its limits"
                     for each in parameters[:logs] if each.at_limit]  # fmt: skip
        warnings += _judgement(problem, best.chi2, freedom)
    return FitResult(
        parameters, statistics.correlations(C), best.chi2, freedom, _curves(model, best, C),
        tuple(warnings), 0, 0.0, "95 %, normal in the logarithms, for the given noise",
    )  # fmt: skip


def _judgement(problem: FitProblem, chi2: float, freedom: int) -> list[str]:
    """Return a warning if residuals are larger than the noise explains."""
    from scipy.stats import chi2 as distribution

    if problem.loss != "linear" or freedom < 1 or distribution.sf(chi2, freedom) > _UNLIKELY:
        return []
    ratio = np.sqrt(chi2 / freedom)
    return [
        f"residuals are {ratio:.2g} times the noise: the model does not describe the data, or the "
        "noise is larger; intervals are then too narrow"
    ]


def _curves(model: FitModel, best: Evaluation, C: Array) -> tuple[FittedCurve, ...]:
    """Return measured and fitted curves, with bands of the prediction."""
    curves, offsets = model.problem.curves, model.unknowns.offsets(best.x)
    starts = [min(curve.time_min[0], offset) for curve, offset in zip(curves, offsets, strict=True)]
    fine = [np.linspace(start, curve.time_min[-1], _FINE)
            for start, curve in zip(starts, curves, strict=True)]  # fmt: skip
    at = model.predict(best.x, [np.asarray(curve.time_min) for curve in curves])
    between = model.predict(best.x, fine)
    found = []
    for curve, times, point, line in zip(curves, fine, at, between, strict=True):
        measured = np.asarray(curve.values, dtype=float)
        errors = measured * curve.relative_errors
        variance = np.einsum("ti,ij,tj->t", line.slopes, C, line.slopes)
        band = statistics.NORMAL * np.sqrt(np.maximum(variance, 0.0))
        found.append(
            FittedCurve(
                curve.name, curve.quantity, np.asarray(curve.time_min, dtype=float), measured,
                errors, point.values, (measured - point.values) / errors, times, line.values, band,
            )
        )  # fmt: skip
    return tuple(found)
