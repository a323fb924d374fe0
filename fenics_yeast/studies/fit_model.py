"""What a fit compares: curves of runs at the measured times, and their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..geometry import Array
from ..scene import FitProblem, MeasuredCurve, SceneError
from ..simulation import History, Result, Sensitivities, UnloadedShapeError, interpolate
from .derivatives import simulate_with_derivatives

if TYPE_CHECKING:
    from ..simulation import ShellPool

_RISE = 5.0  # slope of a curve beyond the end of its run, in largest values per time span
_LOST = 1e4  # residual of values that no run reached
_MOMENT = 1e-3  # min, half of the difference that gives a slope in time


@dataclass(frozen=True)
class Unknowns:
    """The numbers that a fit varies: logarithms of varied keys, then free offsets in min."""

    problem: FitProblem

    @property
    def names(self) -> tuple[str, ...]:
        """Keys of the scene, and ``offset of CURVE``."""
        keys = [varied.key for varied in self.problem.varied]
        free = [f"offset of {curve.name}" for curve in self.problem.curves if _free(curve)]
        return (*keys, *free)

    @property
    def start(self) -> Array:
        """The first guess."""
        logs = [np.log(varied.start) for varied in self.problem.varied]
        return np.array(logs + [0.0 for curve in self.problem.curves if _free(curve)])

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits; of an offset, those that leave half of the values."""
        low = [np.log(varied.low) for varied in self.problem.varied]
        high = [np.log(varied.high) for varied in self.problem.varied]
        for curve in filter(_free, self.problem.curves):
            times = curve.time_min
            low.append(times[0] - (times[-1] - times[0]) - 1.0)
            high.append(float(np.median(times)) + 1e-6)
        return np.array(low), np.array(high)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the values."""
        units = [varied.unit for varied in self.problem.varied]
        return (*units, *("min" for curve in self.problem.curves if _free(curve)))

    def values(self, x: Array) -> Array:
        """Return the values of unknowns: of the keys, and offsets in min."""
        count = len(self.problem.varied)
        return np.append(np.exp(x[:count]), x[count:])

    def place(self, values: Array) -> Array:
        """Return the unknowns of values, within the limits."""
        count = len(self.problem.varied)
        return np.clip(np.append(np.log(values[:count]), values[count:]), *self.limits)

    def offsets(self, x: Array) -> list[float]:
        """Return the offset of each curve in min."""
        free = iter(x[len(self.problem.varied) :].tolist())
        return [
            next(free) if curve.offset == "free" else curve.offset for curve in self.problem.curves
        ]


def _free(curve: MeasuredCurve) -> bool:
    return curve.offset == "free"


@dataclass(frozen=True)
class Prediction:
    """Values of a curve at some times, and their derivatives by the unknowns of a fit."""

    values: Array
    slopes: Array
    complete: bool


@dataclass(frozen=True)
class Evaluation:
    """Residuals in units of the noise, their derivatives, and whether all runs reached the end."""

    x: Array
    residuals: Array
    jacobian: Array
    complete: bool
    message: str = ""

    @property
    def chi2(self) -> float:
        """Sum of the squares of the residuals."""
        return float(self.residuals @ self.residuals)


class FitModel:
    """Runs a scene for the curves of a fit; curves of one experiment share a run.

    Parameters
    ----------
    problem
        What to fit.
    shells
        Shells kept over the runs, so that only the first of a kind compiles.
    tried
        Called with each evaluation.
    """

    def __init__(
        self,
        problem: FitProblem,
        shells: ShellPool,
        tried: Callable[[Evaluation], None] | None = None,
    ) -> None:
        self.problem, self.unknowns, self.runs = problem, Unknowns(problem), 0
        self._shells, self._tried = shells, tried
        self._keys = [varied.key for varied in problem.varied]
        # Experiments that are one scene share a run.
        scenes = [problem.scene.with_values(curve.set) for curve in problem.curves]
        self._experiment = [scenes.index(scene) for scene in scenes]
        self._kept: dict[bytes, list[Result]] = {}

    def check(self, x: Array) -> None:
        """Run the scenes, which are kept for the next evaluation.

        Raises
        ------
        SceneError
            If a scene is not valid.
        KeyboardInterrupt
            If a run is interrupted.
        """
        self._results(x)

    def evaluate(self, x: Array) -> Evaluation:
        """Return residuals and derivatives; of a scene that is not valid, large residuals.

        Raises
        ------
        KeyboardInterrupt
            If a run is interrupted.
        """
        times = [np.asarray(curve.time_min, dtype=float) for curve in self.problem.curves]
        try:
            predictions = self.predict(x, times)
        except SceneError as error:
            count = sum(map(len, times))
            lost = np.full(count, _LOST), np.zeros((count, len(x)))
            evaluation = Evaluation(x, *lost, False, str(error))
        else:
            evaluation = self._compare(x, predictions)
        self.report(evaluation)
        return evaluation

    def report(self, evaluation: Evaluation) -> None:
        """Pass an evaluation on to who asked for them."""
        if self._tried is not None:
            self._tried(evaluation)

    def for_problem(self, problem: FitProblem) -> FitModel:
        """Return a model of another problem with the same shells; this one for its own."""
        return self if problem is self.problem else FitModel(problem, self._shells)

    def _compare(self, x: Array, predictions: list[Prediction]) -> Evaluation:
        residuals, slopes = [], []
        for curve, prediction in zip(self.problem.curves, predictions, strict=True):
            measured = np.asarray(curve.values, dtype=float)
            errors = measured * curve.relative_errors
            residuals.append((prediction.values - measured) / errors)
            slopes.append(prediction.slopes / errors[:, None])
        complete = all(prediction.complete for prediction in predictions)
        last = next((r.message for r in self._kept[x.tobytes()] if r.status != "finished"), "")
        return Evaluation(x, np.concatenate(residuals), np.concatenate(slopes), complete, last)

    def predict(self, x: Array, times: list[Array]) -> list[Prediction]:
        """Return the values of each curve at times of that curve.

        A curve whose run ends early follows its tangent from where it became steep:
        residuals there are large, but smooth, and lead back.
        """
        results = self._results(x)
        offsets = self.unknowns.offsets(x)
        free = iter(range(len(self._keys), len(x)))
        found = []
        for number, curve in enumerate(self.problem.curves):
            place = next(free) if _free(curve) else None
            at = np.asarray(times[number], dtype=float) - offsets[number]
            result = results[self._experiment[number]]
            found.append(self._curve(result, curve, at, x, place))
        return found

    def _results(self, x: Array) -> list[Result]:
        """Return the result of the experiment of each curve; curves of one share theirs."""
        if (kept := self._kept.get(x.tobytes())) is not None:
            return kept
        curves, offsets = self.problem.curves, self.unknowns.offsets(x)
        values = dict(zip(self._keys, self.unknowns.values(x).tolist(), strict=False))
        done: dict[int, Result] = {}
        for number in sorted(set(self._experiment)):
            shared = [i for i, other in enumerate(self._experiment) if other == number]
            end = max(curves[i].time_min[-1] - offsets[i] for i in shared)
            run = {"run.end": end, "run.save": [end]}
            scene = self.problem.scene.with_values({**run, **curves[number].set, **values})
            self.runs += 1
            try:
                done[number] = simulate_with_derivatives(scene, self._keys, shells=self._shells)
            except UnloadedShapeError as error:  # of these values, as if they were not valid
                raise SceneError(str(error)) from None
            if done[number].status == "interrupted":
                raise KeyboardInterrupt
        results = [done[number] for number in self._experiment]
        self._kept = {**dict(list(self._kept.items())[-2:]), x.tobytes(): results}
        return results

    def _curve(
        self, result: Result, curve: MeasuredCurve, times: Array, x: Array, place: int | None
    ) -> Prediction:
        history, found, column = result.history, result.sensitivities, curve.column
        slopes = np.zeros((len(times), len(x)))
        rows = _in_time(history, found)
        if found is None or len(rows) < 2:
            return Prediction(np.full(len(times), _LOST), slopes, False)
        first, last = history.time_min[rows[0]], history.time_min[rows[-1]]
        # Before the turgor has risen, a cell is measured with its turgor, too.
        first = min(max(first, *history.kinks[:1]), last)
        complete = float(times.max()) <= last + 1e-9 * max(1.0, last)
        steepest = _RISE * max(curve.values) / max(curve.time_min[-1] - curve.time_min[0], 1.0)
        if not complete:
            last = _steep(history, column, rows, first, steepest)
        inside = np.clip(times, first, last)
        values = history.interpolate(column, inside)
        theta = self.unknowns.values(x)[: len(self._keys)]
        # Steeper rows, in which derivatives grow without bound, would make the spline swing.
        used = rows[: np.searchsorted(history.time_min[rows], last - 1e-9) + 1]
        derivatives = interpolate(
            history.time_min[used], found.of(column)[used], history.kinks, inside
        )
        slopes[:, : len(theta)] = derivatives * theta
        rise = _rise(history, column, inside, first, last)
        late = times - last
        beyond = late > 1e-9 * max(1.0, last)
        if place is not None:
            slopes[:, place] = np.where(times > first, -rise, 0.0)
            slopes[beyond, place] = -steepest
        if beyond.any():
            values[beyond] += steepest * late[beyond]
            # Curves that end before they are steep shift along the time with their end.
            if 0 < rise[beyond][0] < 0.5 * steepest:
                slopes[beyond, : len(theta)] *= steepest / rise[beyond][0]
        return Prediction(values, slopes, complete)


def _rise(history: History, column: str, times: Array, first: float, last: float) -> Array:
    """Return the slopes of a column in time, within a part of the run."""
    after, before = np.minimum(times + _MOMENT, last), np.maximum(times - _MOMENT, first)
    change = history.interpolate(column, after) - history.interpolate(column, before)
    slope: Array = change / np.maximum(after - before, 1e-300)
    return slope


def _steep(
    history: History, column: str, rows: NDArray[np.intp], first: float, steepest: float
) -> float:
    """Return the time from which a run that ends early is steeper than some slope, or its end."""
    from scipy.optimize import brentq

    time, values = history.time_min[rows], getattr(history, column)[rows]
    end = float(time[-1])
    gentle = np.flatnonzero((np.diff(values) < steepest * np.diff(time)) & (time[:-1] >= first))
    if not len(gentle) or gentle[-1] == len(time) - 2:
        return end if len(gentle) else first + 0.5 * (end - first)

    def excess(at: float) -> float:
        return float(_rise(history, column, np.array([at]), first, end)[0]) - steepest

    low, high = float(time[gentle[-1]]), float(time[gentle[-1] + 2])
    if excess(low) * excess(high) >= 0:
        return float(time[gentle[-1] + 1])
    return float(brentq(excess, low, high))


def _in_time(history: History, found: Sensitivities | None) -> NDArray[np.intp]:
    """Return the numbers of the rows at increasing times that have derivatives."""
    if found is None or not len(history):
        return np.array([], dtype=np.intp)
    known = np.isfinite(found.volume_um3).all(axis=1)
    known &= np.diff(history.time_min, prepend=-np.inf) > 1e-12 * np.abs(history.time_min)
    return np.flatnonzero(known)
