"""Screens of a run: a progress bar and tables on a terminal, plain lines elsewhere."""

from __future__ import annotations

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
        self._printed: Row | None = None

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
            self._print(self._row)

    def _print(self, row: Row) -> None:
        when = f"{row.time_min:g} min: " if self._in_time else ""
        print_line(f"{when}V/V0 = {row.volume_ratio:.6f}")
        self._printed = row

    def resumed(self, row: Row, rows: int) -> None:
        """Print where the run resumes."""
        self.note(_resumed(row, rows))

    def note(self, line: str) -> None:
        """Print a line."""
        print_line(line)

    def refining(self, part: str) -> None:
        """Print nothing."""

    def summary(self, result: Result, place: str) -> None:
        """Print the last row unless it has been, error bars, how the run ended and where it is."""
        if len(result.history) and result.history.rows[-1] != self._printed:
            self._print(result.history.rows[-1])
        if result.error_bars is not None:
            rows = [*_rows(result.error_bars)]
            for cells in [_HEADINGS, *rows] if rows else ():
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
        self._narrow = self._console.width < _NARROW
        columns = [SpinnerColumn(), TextColumn("{task.fields[state]}")]
        if not self._narrow:
            columns[1:1] = [TextColumn("{task.description}"), BarColumn(bar_width=24)]
            columns += [TimeRemainingColumn(), TextColumn("{task.fields[left]}")]
        self._progress = Progress(
            *columns,
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
        time, end, left, state = row.time_min, self._end, "", f"V/V0 = {row.volume_ratio:.4f}"
        if end is not None:
            left, state = "left", f"{time:.1f} of {end:g} min   {state}"
        self._progress.update(self._task, total=end, completed=time, state=state, left=left)
        if end is not None and time >= end:
            self._wait(state, "drawing figures")

    def saved(self, profile: Profile) -> None:
        """Show nothing; the table at the end has it."""

    def resumed(self, row: Row, rows: int) -> None:
        """Print where the run resumes, and start the bar there."""
        self.note(_resumed(row, rows))
        self._progress.update(self._task, total=self._end, completed=row.time_min)

    def note(self, line: str) -> None:
        """Print a line above the bar."""
        self._console.print(line, markup=False, soft_wrap=True)

    def refining(self, part: str) -> None:
        """Show which part is refined for the error bars."""
        self._wait(f"error bars: {part.replace('_', ' ')} refined")

    def _wait(self, state: str, left: str = "") -> None:
        """Show what is done in an unknown time."""
        self._progress.update(self._task, state=state, left=left)
        self._progress.tasks[0].total = None  # `update` would keep it

    def summary(self, result: Result, place: str) -> None:
        """Print a table of the saved times, how the run ended and its output directory."""
        from rich import box
        from rich.table import Table

        table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1))
        headings = ["time (min)", "V/V0", "height (µm)"]
        if self._scene.growth is not None:
            headings += ["bud radius (µm)", "neck radius (µm)"]
        if self._narrow:
            headings = ["min", "V/V0"]
        for heading in headings:
            table.add_column(heading, justify="right", no_wrap=self._narrow)
        shown = [result.history.at(profile.time) for profile in result.profiles]
        if len(result.history) and result.history.rows[-1] not in shown:
            shown.append(result.history.rows[-1])
        for row in shown:
            lengths = (row.pole_height_um, row.bud_radius_um, row.neck_radius_um)
            cells = [
                f"{row.time_min:.4g}",
                f"{row.volume_ratio:.6f}",
                *map("{:.3f}".format, lengths),
            ]
            table.add_row(*cells[: len(headings)])
        self._console.print(table)
        if result.error_bars is not None:
            places = (0, -1) if self._narrow else range(len(_HEADINGS))
            table = Table(title="errors of V/V0", box=box.SIMPLE_HEAD, pad_edge=False)
            for i in places:
                table.add_column(_HEADINGS[i], justify="right")
            for cells in _rows(result.error_bars):
                table.add_row(*(cells[i] for i in places))
            if table.rows:
                self._console.print(table)
            if result.error_bars.message:
                self._console.print(result.error_bars.message)
        for line in (_ending(result, place), *map("warning: {}".format, result.warnings)):
            self._console.print(line, markup=False, soft_wrap=True)


_NARROW = 72  # columns of a terminal that fewer columns of a table fit
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
    """Print at once."""
    print(line, flush=True)
