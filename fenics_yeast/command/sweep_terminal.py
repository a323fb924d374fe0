"""Screens of a sweep: a line per case and, on a terminal, a progress bar."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

from ..studies import value_label
from .terminal import print_line

if TYPE_CHECKING:
    from ..studies import CaseRow


class SweepLines:
    """A plain line for each case."""

    def __init__(self, keys: Sequence[str]) -> None:
        self._keys, self._cases, self._ended = keys, 0, 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return

    def begun(self, cases: int, skipped: Sequence[CaseRow]) -> None:
        """Show how many cases are finished."""
        self._cases, self._ended = cases, len(skipped)
        if skipped:
            self._print(f"{len(skipped)} of {cases} cases have already ended; skipping them")

    def ended(self, row: CaseRow) -> None:
        """Print the line of a case."""
        self._ended += 1
        place = f"{self._ended:{len(str(self._cases))}}/{self._cases}"
        self._print(f"{place}  {describe(self._keys, row)}")

    def _print(self, line: str) -> None:
        print_line(line)


class SweepBar(SweepLines):
    """The same lines above a progress bar of rich."""

    def __init__(self, keys: Sequence[str]) -> None:
        super().__init__(keys)
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        self._console = Console(highlight=False)
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("elapsed"),
            TimeRemainingColumn(),
            TextColumn("left"),
            console=self._console,
            transient=True,
            speed_estimate_period=600,
        )
        self._task = self._progress.add_task("sweep", total=None)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def begun(self, cases: int, skipped: Sequence[CaseRow]) -> None:
        """Set up the bar for the remaining cases."""
        super().begun(cases, skipped)
        self._progress.update(self._task, total=cases - len(skipped))

    def ended(self, row: CaseRow) -> None:
        """Print the line and move the bar."""
        super().ended(row)
        self._progress.advance(self._task)

    def _print(self, line: str) -> None:
        self._console.print(line, markup=False, soft_wrap=True)


def describe(keys: Sequence[str], row: CaseRow) -> str:
    """Return the result of a case as a line."""
    case = " ".join(
        f"{key}={value_label(value)}" for key, value in zip(keys, row.values, strict=True)
    )
    if row.status == "failed" or row.end_ratio is None or row.end_time is None:
        return f"{case}: {row.status}: {row.message}"
    when = f" at {row.end_time:.4g} min" if row.end_time else ""
    seconds = "" if row.wall_s is None else f"  ({row.wall_s:.1f} s)"
    return f"{case}: {row.status}, V/V0 = {row.end_ratio:.6f}{when}{seconds}"


def tally(rows: Sequence[CaseRow]) -> str:
    """Return the numbers of cases by status."""
    counts = Counter(row.status for row in rows)
    return f"{len(rows)} case{'s' * (len(rows) != 1)}: " + ", ".join(
        f"{n} {status}" for status, n in counts.items()
    )
