"""What a run shows while it goes and when it ends: on a terminal, and elsewhere."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from .record import Profile, Result, Row
    from .scene import Scene


class Lines:
    """A plain line for each saved time."""

    def __init__(self) -> None:
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
            _print(f"{profile.time:8.4g} min   V/V0 = {self._row.volume_ratio:.6f}")

    def summary(self, result: Result, place: str) -> None:
        """Say how the run ended and where its files are."""
        _print(_ending(result, place))


class ProgressLine:
    """A line with bar, time, volume and time left, and a table at the end, by rich."""

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
        )
        self._task = self._progress.add_task(scene.name, total=None, state="setting up", left="")

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def accepted(self, row: Row) -> None:
        """Bring the line up to an accepted state."""
        left, state = "", f"V/V0 = {row.volume_ratio:.4f}"
        if self._end is not None:
            left = "left"
            state = f"{row.time_min:.1f} of {self._end:g} min   {state}"
        self._progress.update(
            self._task, total=self._end, completed=row.time_min, state=state, left=left
        )

    def saved(self, profile: Profile) -> None:
        """Nothing: the table at the end has it."""

    def summary(self, result: Result, place: str) -> None:
        """Show the volumes at the saved times, how the run ended and where its files are."""
        from rich import box
        from rich.table import Table

        table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
        for heading in ("time (min)", "V/V0", "bud radius (µm)", "neck radius (µm)"):
            table.add_column(heading, justify="right")
        for profile in result.profiles:
            row = result.history.at(profile.time)
            radii = [f"{r:.3f}" if r else "-" for r in (row.bud_radius_um, row.neck_radius_um)]
            table.add_row(f"{profile.time:.4g}", f"{row.volume_ratio:.6f}", *radii)
        self._console.print(table)
        self._console.print(_ending(result, place))


def _ending(result: Result, place: str) -> str:
    return f"{result.status} at {result.end_time:.4g} min, see {place}"


def _print(line: str) -> None:
    """Print at once; a reader that has gone away does not end the run."""
    try:
        print(line, flush=True)
    except BrokenPipeError:
        # Python would complain once more when it flushes at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
