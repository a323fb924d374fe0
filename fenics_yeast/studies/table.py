"""The table of a sweep: the result of each case, read from its directory."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from time import perf_counter
from typing import get_args

from ..output import OutputError, read_history, read_scene, read_summary, replace_file, writing
from ..scene import SceneError
from ..simulation import ANSWERS, Status
from .cases import Case

TABLE = "sweep.csv"  # in the directory of the sweep
_RATIO = ("volume_ratio_at_", "_min")
_SHARE = 0.1  # largest part of the time for writing the table again after each case
_LAST = ("end_volume_ratio", "wall_s", "message")


@dataclass(frozen=True)
class CaseRow:
    """Result of a case.

    Attributes
    ----------
    case, values
        Its name and parameter values, as in `Case`.
    status, message
        How it ended: a status word and a sentence.
    end_time, end_ratio
        Time in min and V/V0 of its last accepted state, or None.
    ratios
        Pairs of a saved time in min that it reached and V/V0 there.
    wall_s
        Seconds that it took.
    """

    case: str
    values: tuple[float | str, ...]
    status: Status
    message: str
    end_time: float | None = None
    end_ratio: float | None = None
    ratios: tuple[tuple[float, float], ...] = ()
    wall_s: float | None = None

    @property
    def answered(self) -> bool:
        """Whether the case has a result and need not be rerun."""
        return self.status in ANSWERS


def row_of(directory: Path, case: Case) -> CaseRow | None:
    """Return the result of a case from its directory; None if its scene has not ended there.

    Raises
    ------
    OutputError, SceneError
        If a file of the directory is damaged.
    """
    folder = directory / case.name
    if not folder.exists() or read_scene(folder) != case.scene:
        return None
    summary = read_summary(folder)
    if summary is None:
        return None
    history = read_history(folder)
    last = history.rows[-1] if len(history) else None
    saved = case.scene.run.save if case.scene.run else ()
    reached = [time for time in saved if last and time <= last.time_min]
    return CaseRow(
        case=case.name,
        values=case.values,
        status=summary.status,
        message=summary.message,
        end_time=last.time_min if last else None,
        end_ratio=last.volume_ratio if last else None,
        ratios=tuple((time, history.at(time).volume_ratio) for time in reached),
        wall_s=summary.timings.total_s,
    )


def finished_row(directory: Path, case: Case) -> CaseRow | None:
    """Return the row of a case that need not be rerun; None for any other."""
    try:
        row = row_of(directory, case)
    except (OutputError, SceneError):
        return None  # damaged: rerun
    return row if row is not None and row.answered else None


def is_unfinished(directory: Path, case: Case) -> bool:
    """Return whether the case's directory has an unfinished run of its scene."""
    folder = directory / case.name
    try:
        summary = read_summary(folder)
        return read_scene(folder) == case.scene and (
            summary is None or summary.status not in ANSWERS
        )
    except (OutputError, SceneError):
        return False


def write_table(directory: Path, keys: Sequence[str], rows: Iterable[CaseRow]) -> None:
    """Write the table; it replaces an earlier one as a whole.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    rows = list(rows)
    times = sorted({time for row in rows for time, _ in row.ratios})
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    ratios = [f"{time:.10g}".join(_RATIO) for time in times]
    table.writerow(["case", *keys, "status", "end_time_min", *ratios, *_LAST])
    for row in rows:
        at = dict(row.ratios)
        numbers = [row.end_ratio, row.wall_s and round(row.wall_s, 3)]
        table.writerow(
            [row.case, *row.values, row.status, row.end_time, *map(at.get, times), *numbers,
             row.message]
        )  # fmt: skip
    with writing(directory):
        replace_file(directory / TABLE, text.getvalue().encode())


class GrowingTable:
    """The table of a sweep whose cases end one after the other.

    Parameters
    ----------
    directory, keys, cases
        Directory of the sweep, its varied keys and all its cases.

    Attributes
    ----------
    rows
        Rows of the cases that have ended, by name; at first those finished before.
    """

    def __init__(self, directory: Path, keys: Sequence[str], cases: Sequence[Case]) -> None:
        self._directory, self._keys, self._cases = directory, keys, cases
        known = ((case.name, finished_row(directory, case)) for case in cases)
        self.rows = {name: row for name, row in known if row is not None}
        self._may_write_at = 0.0

    def add(self, row: CaseRow) -> None:
        """Add a row; rewrite the file unless that was done a moment ago."""
        self.rows[row.case] = row
        began = perf_counter()
        if began >= self._may_write_at:
            self.write()
            now = perf_counter()
            self._may_write_at = now + (now - began) / _SHARE

    def write(self) -> list[CaseRow]:
        """Write the file; return all known rows, in the order of the cases."""
        known = [self.rows[case.name] for case in self._cases if case.name in self.rows]
        write_table(self._directory, self._keys, known)
        return known


def read_table(directory: Path) -> tuple[list[str], list[CaseRow]]:
    """Read the parameters' keys and the rows of a sweep's table.

    Raises
    ------
    OutputError
        If there is none, or it is not from a sweep.
    """
    path = directory / TABLE
    try:
        header, *lines = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        split = header.index("status")
        if header[0] != "case" or tuple(header[-3:]) != _LAST:
            raise ValueError
        rows = [_read(dict(zip(header, line, strict=True)), header[1:split]) for line in lines]
    except OSError:
        problem = f"{directory}: no {TABLE}; not the output directory of a sweep"
        raise OutputError(problem) from None
    except (ValueError, KeyError, UnicodeDecodeError):
        problem = f"{path}: not the table of a sweep; choose another directory with --out"
        raise OutputError(problem) from None
    return header[1:split], rows


def _read(cells: dict[str, str], keys: Sequence[str]) -> CaseRow:
    before, after = _RATIO
    ratios = {name.removeprefix(before).removesuffix(after): text for name, text in cells.items()
              if name.startswith(before)}  # fmt: skip
    if cells["status"] not in get_args(Status):
        raise ValueError
    return CaseRow(
        case=cells["case"],
        values=tuple(_value(cells[key]) for key in keys),
        status=cells["status"],  # type: ignore[arg-type]
        message=cells["message"],
        end_time=_number(cells["end_time_min"]),
        end_ratio=_number(cells["end_volume_ratio"]),
        ratios=tuple((float(time), float(text)) for time, text in ratios.items() if text),
        wall_s=_number(cells["wall_s"]),
    )


def _number(text: str) -> float | None:
    return float(text) if text else None


def _value(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
