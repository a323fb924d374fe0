"""The output directory of a fit: ``fit.json``, ``fit.csv`` and ``runs.csv``."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from io import StringIO
from math import isfinite
from pathlib import Path

from ..output import OutputError, replace_file, writing
from .fit_model import Evaluation, Unknowns
from .fit_result import Estimate, FitResult
from .fit_search import cost

RESULT, TABLE, RUNS = "fit.json", "fit.csv", "runs.csv"
_LAST = ("chi2", "cost", "complete", "message")


class RunsTable:
    """What a fit has tried, written after each evaluation; `earlier` rows come first."""

    def __init__(self, directory: Path, unknowns: Unknowns, earlier: Iterable[Sequence[str]] = ()):
        self._path, self._unknowns = directory / RUNS, unknowns
        self._rows: list[Sequence[object]] = [(*unknowns.names, *_LAST), *earlier]

    def add(self, evaluation: Evaluation) -> None:
        """Add an evaluation, and write the table."""
        values = self._unknowns.values(evaluation.x).tolist()
        complete = str(evaluation.complete).lower()
        sums = evaluation.chi2, cost(evaluation, self._unknowns.problem)
        self._rows.append((*values, *sums, complete, evaluation.message))
        with writing(self._path.parent):
            _write(self._path, self._rows)


def read_runs(directory: Path, unknowns: Unknowns) -> list[list[str]]:
    """Return the rows of what a fit has tried; none if it has not begun.

    Raises
    ------
    OutputError
        If the table is not that of this fit.
    """
    path = directory / RUNS
    try:
        header, *rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    except FileNotFoundError:
        return []
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read: {error}; choose another --out") from None
    if tuple(header) != (*unknowns.names, *_LAST):
        raise OutputError(f"{path}: from another fit; choose another directory with --out")
    return rows


def read_best(directory: Path, unknowns: Unknowns) -> list[float] | None:
    """Return the best values that a fit has tried; None if there are none.

    Raises
    ------
    OutputError
        If the table is not that of this fit.
    """
    count = len(unknowns.names)
    whole = [row for row in read_runs(directory, unknowns) if row[count + 2] == "true"]
    if not whole:
        return None
    best = min(whole, key=lambda row: float(row[count + 1]))
    return [float(cell) for cell in best[:count]]


def write_fit(directory: Path, result: FitResult) -> None:
    """Write ``fit.json`` and ``fit.csv``.

    Raises
    ------
    OutputError
        If they cannot be written.
    """
    names = [estimate.key for estimate in result.parameters]
    content = {
        "parameters": {estimate.key: _estimate(estimate) for estimate in result.parameters},
        "intervals": result.intervals,
        "correlation": {
            name: dict(zip(names, row, strict=True))
            for name, row in zip(names, result.correlation.tolist(), strict=True)
        },
        "chi2": result.chi2,
        "degrees_of_freedom": result.degrees_of_freedom,
        "warnings": list(result.warnings),
        "runs": result.runs,
        "seconds": round(result.seconds, 3),
    }
    if result.profiles:
        content["profiles"] = {
            profile.key: {"value": profile.values, "chi2_rise": profile.rise}
            for profile in result.profiles
        }
    if result.bootstrap is not None:
        content["bootstrap"] = {
            name: column.tolist() for name, column in zip(names, result.bootstrap.T, strict=True)
        }
    rows: list[Sequence[object]] = [
        ("curve", "quantity", "time_min", "measured", "error", "model", "standardised_residual")
    ]
    for curve in result.curves:
        columns = (curve.time_min, curve.measured, curve.errors, curve.model, curve.residuals)
        for cells in zip(*(column.tolist() for column in columns), strict=True):
            rows.append((curve.name, curve.quantity, *cells))
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
        replace_file(directory / RESULT, (text + "\n").encode())
        _write(directory / TABLE, rows)


def _estimate(estimate: Estimate) -> dict[str, object]:
    numbers = {name: getattr(estimate, name) for name in ("value", "low", "high")}
    known = {name: x if isfinite(x) else None for name, x in numbers.items()}
    return {**known, "unit": estimate.unit, "at_limit": estimate.at_limit}


def _write(path: Path, rows: Iterable[Sequence[object]]) -> None:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    replace_file(path, text.getvalue().encode())
