"""Screens of a run: a progress bar and tables on a terminal, plain lines elsewhere."""

from __future__ import annotations

import os
import sys
from math import isnan
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ..scene import Scene
    from ..simulation import ErrorBars, Profile, Result, Row


class Lines:
    """A plain line for each saved time."""

    def __init__(self, scene: Scene) -> None:
        self._in_time = scene.run is not None
        self._row: Row | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return

    def accepted(self, row: Row) -> None:
        """Keep the row for the line."""
        self._row = row

    def saved(self, profile: Profile) -> None:
        """Print the line."""
        if self._row is not None:
            when = f"{profile.time:g} min: " if self._in_time else ""
            print_line(f"{when}V/V0 = {self._row.volume_ratio:.6f}")

    def resumed(self, row: Row, rows: int) -> None:
        """Print where the run resumes."""
        self.note(_resumed(row, rows))

    def note(self, line: str) -> None:
        """Print a line."""
        print_line(line)

    def refining(self, part: str) -> None:
        """Print nothing."""

    def summary(self, result: Result, place: str) -> None:
        """Print the error bars, how the run ended and its output directory."""
        if result.error_bars is not None:
            for cells in [_HEADINGS, *_rows(result.error_bars)]:
                print_line("  ".join(f"{cell:>16}" for cell in cells))
            if result.error_bars.message:
                print_line(result.error_bars.message)
        print_line(_ending(result, place))
        for warning in result.warnings:
            print_line(f"warning: {warning}")


class ProgressLine:
    """A progress bar with time, volume and time left, and tables at the end, by rich."""

    def __init__(self, scene: Scene) -> None:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress,
            SpinnerColumn,
            TextColumn,
            TimeRemainingColumn,
        )

        self._scene = scene
        self._console = Console(highlight=False)
        self._end = scene.run.end if scene.run else None
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[state]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[left]}"),
            console=self._console,
            transient=True,
            speed_estimate_period=600,
        )
        self._task = self._progress.add_task(scene.name, total=None, state="setting up", left="")

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def accepted(self, row: Row) -> None:
        """Show an accepted state."""
        time, left, state = row.time_min, "", f"V/V0 = {row.volume_ratio:.4f}"
        if self._end is not None:
            left, state = "left", f"{time:.1f} of {self._end:g} min   {state}"
        self._progress.update(self._task, total=self._end, completed=time, state=state, left=left)

    def saved(self, profile: Profile) -> None:
        """Show nothing; the table at the end has it."""

    def resumed(self, row: Row, rows: int) -> None:
        """Print where the run resumes, and start the bar there."""
        self.note(_resumed(row, rows))
        self._progress.update(self._task, total=self._end, completed=row.time_min)

    def note(self, line: str) -> None:
        """Print a line above the bar."""
        self._console.print(line)

    def refining(self, part: str) -> None:
        """Show which part is refined for the error bars."""
        state = f"error bars: {part.replace('_', ' ')} refined"
        self._progress.update(self._task, total=None, state=state, left="")

    def summary(self, result: Result, place: str) -> None:
        """Print a table of the saved times, how the run ended and its output directory."""
        from rich import box
        from rich.table import Table

        table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
        headings = ["time (min)", "V/V0", "height (µm)"]
        if self._scene.growth is not None:
            headings += ["bud radius (µm)", "neck radius (µm)"]
        for heading in headings:
            table.add_column(heading, justify="right")
        for profile in result.profiles:
            row = result.history.at(profile.time)
            lengths = (row.pole_height_um, row.bud_radius_um, row.neck_radius_um)
            cells = [
                f"{profile.time:.4g}",
                f"{row.volume_ratio:.6f}",
                *map("{:.3f}".format, lengths),
            ]
            table.add_row(*cells[: len(headings)])
        self._console.print(table)
        if result.error_bars is not None:
            table = Table(*_HEADINGS, title="errors of V/V0", box=box.SIMPLE_HEAD, pad_edge=False)
            for column in table.columns:
                column.justify = "right"
            for cells in _rows(result.error_bars):
                table.add_row(*cells)
            self._console.print(table)
            if result.error_bars.message:
                self._console.print(result.error_bars.message)
        self._console.print(_ending(result, place))
        for warning in result.warnings:
            self._console.print(f"warning: {warning}")


_HEADINGS = ("time (min)", "time steps", "mesh", "integration points", "shear penalty", "total")


def _ending(result: Result, place: str) -> str:
    """Return how a run ended; the command itself prints the message of one that ended early."""
    message = f": {result.message}" if result.status == "finished" else ""
    return f"{result.status}{message}; see {place}"


def _resumed(row: Row, rows: int) -> str:
    return f"resuming from {row.time_min:.6g} min (history row {rows})"


def _rows(bars: ErrorBars) -> Iterator[list[str]]:
    """Return the error bars as text, a row for each time."""
    for time, *errors in zip(*bars.columns().values(), strict=True):
        yield [f"{time:.4g}", *("unknown" if isnan(e) else f"{e:.1e}" for e in errors)]


def print_line(line: str) -> None:
    """Print at once; a closed pipe does not end the run."""
    try:
        print(line, flush=True)
    except BrokenPipeError:
        # Python would report it again when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
