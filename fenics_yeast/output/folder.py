"""Write the output directory of a run while it runs."""

from __future__ import annotations

import os
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Self

import numpy as np

from ..scene import Scene
from ..simulation import COLUMNS, Profile, Profiles, Result, Row, Timings
from .errors import OutputError
from .files import (
    CHECKPOINT,
    FIGURES,
    HISTORY,
    PROFILES,
    RUN,
    SCENE,
    SERIES,
    SURFACES,
    replace_file,
    writing,
)
from .summary import Summary

if TYPE_CHECKING:
    from ..simulation import Checkpoint, ResumePoint

_HEADER = ",".join(COLUMNS)

# Rewriting all profiles at each of very many saved times takes at most this part of the time.
_PROFILES_SHARE = 0.1


class OutputFolder:
    """Writer of the output directory of a run: an `Observer`, and a context manager.

    A row is in the history file as soon as its step is accepted; other files are written under a
    temporary name, flushed to disk and renamed. If the directory is removed during the run, it is
    created again with everything that it held. Under MPI, only rank 0 has one.

    Parameters
    ----------
    path
        The directory, created if missing. Files of an earlier run are replaced, others stay.
    scene
        The scene to be run.
    start
        State from which the run in the directory resumes; None for a new run.

    Attributes
    ----------
    complete
        Whether everything but figures has been written.
    can_resume
        Whether there is a checkpoint of this run.

    Raises
    ------
    OutputError
        If the directory cannot be written, or its files of these names are not those of a run.
    """

    def __init__(self, path: Path, scene: Scene, start: ResumePoint | None = None) -> None:
        self.path = path
        self._scene = scene
        self._rows: list[Row] = [] if start is None else list(start.rows)  # in the file
        self._kept: list[Profile] = [] if start is None else list(start.profiles)
        self._profiles_written = 0
        self.complete, self.can_resume = False, start is not None
        self._may_write_at = 0.0
        with writing(self.path):
            if start is None:
                self._claim()
            self._clear()
            self._begin()
        if self._kept:
            self._write_profiles()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._history.close()

    @property
    def rows(self) -> tuple[Row, ...]:
        """Rows so far."""
        return tuple(self._rows)

    @property
    def profiles(self) -> tuple[Profile, ...]:
        """Profiles so far."""
        return tuple(self._kept)

    def accepted(self, row: Row) -> None:
        """Append a row to the history."""
        self._present()
        with writing(self.path):
            self._append(_line(row))
        self._rows.append(row)

    def saved(self, profile: Profile) -> None:
        """Add a profile and rewrite their file, unless that was done a moment ago."""
        self._present()
        self._kept.append(profile)
        began = perf_counter()
        if began >= self._may_write_at:
            self._write_profiles()
            now = perf_counter()
            self._may_write_at = now + (now - began) / _PROFILES_SHARE

    def keep(self, checkpoint: Checkpoint) -> None:
        """Replace the checkpoint, after writing the rows and profiles that it needs."""
        self._present()
        if self._profiles_written != len(self._kept):
            self._write_profiles()
        with writing(self.path):
            os.fsync(self._history.fileno())
            replace_file(self.path / CHECKPOINT, checkpoint.to_bytes())
        self.can_resume = True

    def finish(self, result: Result, timings: Timings) -> None:
        """Complete the directory; may be called again when more is known.

        `timings` are those of the whole command and replace those of the result.
        """
        self._present()
        if self._profiles_written != len(result.profiles):
            self._kept = list(result.profiles)
            self._write_profiles()
        with writing(self.path):
            if len(self._rows) != len(result.history):  # interrupted between step and row
                self._write_history(result.history.rows)
        self.summarise(result, timings)

    def summarise(self, result: Result, timings: Timings) -> None:
        """Write only the summary, which needs little space."""
        with writing(self.path):
            replace_file(self.path / RUN, Summary.of(result, timings).to_json())
        self.complete = True

    def _claim(self) -> None:
        """Create the directory, or remove the files from which an earlier run could resume."""
        ours = [self.path / name for name in (SCENE, HISTORY, PROFILES, RUN)]
        found = [file.name for file in ours if file.exists()]
        if found and (SCENE not in found or len(found) == 1):
            raise OutputError(
                f"{self.path}: its {found[0]} is not from a run; choose another directory"
            )
        self.path.mkdir(parents=True, exist_ok=True)
        for name in (CHECKPOINT, PROFILES):  # the checkpoint first, as it needs the others
            (self.path / name).unlink(missing_ok=True)

    def _clear(self) -> None:
        """Remove the summary and figures of an earlier run."""
        for name in (RUN, *FIGURES, SERIES):
            (self.path / name).unlink(missing_ok=True)
        for surface in (self.path / SURFACES).glob("*.vtu"):
            surface.unlink()

    def _begin(self) -> None:
        """Write the scene, and the history so far."""
        replace_file(self.path / SCENE, self._scene.to_toml().encode())
        self._write_history(self._rows)
        self._history = open(self.path / HISTORY, "ab", buffering=0)  # noqa: SIM115

    def _present(self) -> None:
        """Create the directory again if it has been removed."""
        if (self.path / HISTORY).exists():
            return
        with writing(self.path):
            self._history.close()
            self.path.mkdir(parents=True, exist_ok=True)
            self._begin()
        if self._kept:
            self._write_profiles()

    def _append(self, line: str) -> None:
        """Append a whole line, or nothing if the disk is full."""
        content = (line + "\n").encode()
        whole = os.fstat(self._history.fileno()).st_size
        try:
            while content:
                content = content[self._history.write(content) :]
        except OSError:
            self._history.truncate(whole)
            raise

    def _write_history(self, rows: Iterable[Row]) -> None:
        lines = [_HEADER, *map(_line, rows)]
        replace_file(self.path / HISTORY, "".join(line + "\n" for line in lines).encode())

    def _write_profiles(self) -> None:
        content = BytesIO()
        np.savez(content, **Profiles(tuple(self._kept)).arrays())
        with writing(self.path):
            replace_file(self.path / PROFILES, content.getvalue())
        self._profiles_written = len(self._kept)


def _line(row: Row) -> str:
    """Return a row as text, with all digits of its numbers."""
    return ",".join(repr(column_type(name)(getattr(row, name))) for name in COLUMNS)


def column_type(column: str) -> type[float] | type[int]:
    """Return the type of the numbers of a history column."""
    return int if column in ("newton_iterations", "stable") else float
