"""Write the output directory of a run while it runs."""

from __future__ import annotations

import os
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Self

import numpy as np

from ..scene import Scene
from ..simulation import COLUMNS, Profile, Profiles, Result, Row, Timings
from .errors import OutputError
from .files import (
    ANIMATIONS,
    CHECKPOINT,
    FIGURES,
    HISTORY,
    MODE,
    MODE_SURFACE,
    PROFILES,
    RUN,
    SCENE,
    SERIES,
    SURFACES,
    replace_file,
    writing,
)
from .lock import FolderLock
from .summary import Summary

if TYPE_CHECKING:
    from ..simulation import Checkpoint, ResumePoint

# Largest part of the time for writing all profiles again at each of very many saved times.
_PROFILES_SHARE = 0.1


class OutputFolder:
    """Writer of the output directory of a run: an `Observer` and a context manager.

    A row is in the history file as soon as its step is accepted; every other file is written under
    a temporary name, flushed to the disk and renamed. A directory that is removed during the run
    is made again with its content. Under MPI only rank 0 has a writer.

    Parameters
    ----------
    path
        The directory, made if missing. Files of an earlier run are replaced, others stay.
    scene
        The scene to be run.
    start
        State from which the run in the directory is resumed; None for a new run.

    Attributes
    ----------
    rows, profiles
        What the directory has so far.
    complete
        Whether the directory has the summary of this run, hence all but figures.
    can_resume
        Whether it has a checkpoint of this run.

    Raises
    ------
    OutputError
        If the directory cannot be written, or has files with our names that are not from a run.
    """

    def __init__(self, path: Path, scene: Scene, start: ResumePoint | None = None) -> None:
        self.path = path
        self._scene = scene
        self.rows: list[Row] = [] if start is None else list(start.rows)  # in the file
        self.profiles: list[Profile] = [] if start is None else list(start.profiles)
        self._profiles_written = 0
        self.complete, self.can_resume = False, start is not None
        self._may_write_at = 0.0
        with writing(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
            self._lock = FolderLock(self.path)
            try:
                if start is None:
                    self._claim()
                self._remove_end()
                self._begin()
            except BaseException:
                self._lock.release()
                raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._history.close()
        self._lock.release()

    def accepted(self, row: Row) -> None:
        """Append a row to the history."""
        with writing(self.path):
            self._ensure_present()
            self._append(_line(row))
        self.rows.append(row)

    def saved(self, profile: Profile) -> None:
        """Add a profile; rewrite the file unless that was done a moment ago."""
        with writing(self.path):
            self._ensure_present()
            self.profiles.append(profile)
            began = perf_counter()
            if began >= self._may_write_at:
                self._write_profiles()
                now = perf_counter()
                self._may_write_at = now + (now - began) / _PROFILES_SHARE

    def keep(self, checkpoint: Checkpoint) -> None:
        """Replace the checkpoint, once all rows and profiles that it counts are on the disk."""
        with writing(self.path):
            self._ensure_present()
            if self._profiles_written != len(self.profiles):
                self._write_profiles()
            os.fsync(self._history.fileno())
            replace_file(self.path / CHECKPOINT, checkpoint.to_bytes())
        self.can_resume = True

    def finish(self, result: Result, timings: Timings) -> None:
        """Complete the directory at the end of the run; again when more is known.

        Parameters
        ----------
        result
            Outcome of the run.
        timings
            Seconds spent in the whole command, in place of those of the result.
        """
        with writing(self.path):
            self._ensure_present()
            if self._profiles_written != len(result.profiles):
                self.profiles = list(result.profiles)
                self._write_profiles()
            if len(self.rows) != len(result.history):  # interrupted between step and row
                self.rows = list(result.history.rows)
                self._write_history()
            if result.mode is not None:
                content = BytesIO()
                np.savez(content, **vars(result.mode))
                replace_file(self.path / MODE, content.getvalue())
        self.summarise(result, timings)

    def summarise(self, result: Result, timings: Timings) -> None:
        """Write only the summary, for which even a full disk may have room."""
        with writing(self.path):
            replace_file(self.path / RUN, Summary.of(result, timings).to_json())
        self.complete = True

    def _claim(self) -> None:
        """Remove that from which an earlier run could be resumed."""
        found = [name for name in (SCENE, HISTORY, PROFILES, RUN) if (self.path / name).exists()]
        if found and (SCENE not in found or len(found) == 1):
            raise OutputError(
                f"{self.path}: contains a {found[0]} that is not from a run; "
                "choose another directory with --out"
            )
        for name in (CHECKPOINT, PROFILES):  # the checkpoint first: it requires the others
            (self.path / name).unlink(missing_ok=True)

    def _remove_end(self) -> None:
        """Remove what was written at the end of an earlier run, and drawn of it since."""
        for name in (RUN, SERIES, MODE, MODE_SURFACE, *FIGURES, *ANIMATIONS):
            (self.path / name).unlink(missing_ok=True)
        for figure in FIGURES:
            (self.path / figure).with_suffix(".pdf").unlink(missing_ok=True)
        for surface in (self.path / SURFACES).glob("*.vtu"):
            surface.unlink()

    def _ensure_present(self) -> None:
        """Make the directory again if it has been removed."""
        if not (self.path / HISTORY).exists():
            self._history.close()
            self._lock.release()
            self.path.mkdir(parents=True, exist_ok=True)
            self._lock = FolderLock(self.path)
            self._begin()

    def _begin(self) -> None:
        """Write the scene, and history and profiles as far as they are known."""
        replace_file(self.path / SCENE, self._scene.to_toml().encode())
        self._write_history()
        self._history = open(self.path / HISTORY, "ab", buffering=0)  # noqa: SIM115
        if self.profiles:
            self._write_profiles()

    def _append(self, line: str) -> None:
        """Add a whole line, or none where the disk is full."""
        content = line.encode()
        whole = os.fstat(self._history.fileno()).st_size
        try:
            while content:
                content = content[self._history.write(content) :]
        except OSError:
            self._history.truncate(whole)
            raise

    def _write_history(self) -> None:
        lines = [",".join(COLUMNS) + "\n", *map(_line, self.rows)]
        replace_file(self.path / HISTORY, "".join(lines).encode())

    def _write_profiles(self) -> None:
        content = BytesIO()
        np.savez(content, **Profiles(tuple(self.profiles)).arrays())
        replace_file(self.path / PROFILES, content.getvalue())
        self._profiles_written = len(self.profiles)


def _line(row: Row) -> str:
    """Values of a row as Python numbers, which print all their digits."""
    values = ((_type(name), getattr(row, name)) for name in COLUMNS)
    return ",".join("" if v is None else repr(kind(v)) for kind, v in values) + "\n"


def read_value(column: str, text: str) -> float | int | None:
    """Return a value of a column of the history; None where it is empty.

    Raises
    ------
    ValueError
        If it is no number, or missing where it must not be.
    """
    return None if column == "unstable_waves" and not text else _type(column)(text)


def _type(column: str) -> type[float] | type[int]:
    return int if column in ("newton_iterations", "stable", "unstable_waves") else float
