"""The output folder of a run, written as the run goes."""

from __future__ import annotations

import errno
import json
import os
import platform
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Self

import numpy as np

from ..scene import Scene
from ..simulation import COLUMNS, ErrorBars, Profile, Profiles, Result, Row, Timings

if TYPE_CHECKING:
    from ..simulation import Checkpoint, ResumePoint

SCENE, HISTORY, PROFILES, RUN = "scene.toml", "history.csv", "profiles.npz", "run.json"
CHECKPOINT = "checkpoint.npz"
# Within the folder, made of the others by other modules.
SHAPES, VOLUME, MERIDIAN = (f"figures/{name}.png" for name in ("shapes", "volume", "meridian"))
FIGURES = (SHAPES, VOLUME, MERIDIAN)
SERIES, SURFACES = "surface.pvd", "surface"
_HEADER = ",".join(COLUMNS)

# Rewriting all profiles at each of very many saved times takes at most this part of the time.
_PROFILES_SHARE = 0.1


class OutputError(Exception):
    """An output folder that cannot be written or read; the message is one line."""


class OutputWriteError(OutputError):
    """A folder that cannot be written: `problem` is the message without what to do about it."""

    def __init__(self, problem: str, advice: str) -> None:
        super().__init__(f"{problem}; {advice}")
        self.problem = problem


@contextmanager
def writing(directory: Path) -> Iterator[None]:
    """Turn what goes wrong in writing to an output folder into an `OutputWriteError`."""
    advice = "choose another output folder"
    try:
        yield
    except (FileExistsError, NotADirectoryError):
        problem = "is a file, or lies below one"
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}"
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            advice = f"make room there, or {advice}"
    else:
        return
    raise OutputWriteError(f"{directory}: {problem}", advice)


def replace_file(path: Path, content: bytes) -> None:
    """Write a file that takes the place of an earlier one only once it is complete."""
    temporary = path.with_name(path.name + ".part")
    try:
        with open(temporary, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


class OutputFolder:
    """Folder that takes in a run while it goes: an `Observer`, and a context manager.

    A row of the history is in its file as soon as the step is accepted; every other file is
    written under a temporary name, flushed to the disk and renamed. If the folder is removed while
    the run goes, it is made again with all there was in it. Under MPI rank 0 alone has one.

    Parameters
    ----------
    path
        The folder, made where missing. Files of an earlier run in it are replaced, others stay.
    scene
        The scene to be run.
    start
        Where the run is taken up that the folder holds; None for a new run.

    Attributes
    ----------
    complete
        Whether there is a summary of this run, and all but figures.
    can_go_on
        Whether there is a checkpoint of it.

    Raises
    ------
    OutputError
        If the folder cannot be written, or holds files under our names that no run has left.
    """

    def __init__(self, path: Path, scene: Scene, start: ResumePoint | None = None) -> None:
        self.path = path
        self._scene = scene
        self._rows: list[Row] = [] if start is None else list(start.rows)  # in the file
        self._kept: list[Profile] = [] if start is None else list(start.profiles)
        self._profiles_written = 0
        self.complete, self.can_go_on = False, start is not None
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
        """Rows of the history so far."""
        return tuple(self._rows)

    @property
    def profiles(self) -> tuple[Profile, ...]:
        """Profiles of the saved times so far."""
        return tuple(self._kept)

    def accepted(self, row: Row) -> None:
        """Append a row to the history."""
        self._present()
        with writing(self.path):
            self._append(_line(row))
        self._rows.append(row)

    def saved(self, profile: Profile) -> None:
        """Write the profiles anew with one more, unless that was done a moment ago."""
        self._present()
        self._kept.append(profile)
        began = perf_counter()
        if began >= self._may_write_at:
            self._write_profiles()
            now = perf_counter()
            self._may_write_at = now + (now - began) / _PROFILES_SHARE

    def keep(self, checkpoint: Checkpoint) -> None:
        """Write a checkpoint in the place of the last one, once all that it counts is there."""
        self._present()
        if self._profiles_written != len(self._kept):
            self._write_profiles()
        with writing(self.path):
            os.fsync(self._history.fileno())
            self._replace(CHECKPOINT, checkpoint.to_bytes())
        self.can_go_on = True

    def finish(self, result: Result, timings: Timings) -> None:
        """Complete the folder with what is known at the end; again, where more is known.

        Parameters
        ----------
        result
            Outcome of the run.
        timings
            Those of the whole command, in place of the result's own.
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
        """Write the summary alone, as far as there may be room."""
        summary: dict[str, object] = {
            "status": result.status,
            "end_time_min": float(result.end_time),
            "message": result.message,
            "versions": _versions(),
            "dofs": int(result.dofs),
            "steps": int(result.steps),
            "rejected_steps": int(result.rejected_steps),
            "newton_iterations": int(result.newton_iterations),
            "timings": asdict(timings),
        }
        if result.error_bars is not None:
            summary["error_bars"] = _error_bars(result.error_bars)
        with writing(self.path):
            self._replace(RUN, (json.dumps(summary, indent=2) + "\n").encode())
        self.complete = True

    def _claim(self) -> None:
        """Make the folder, or clear it of what an earlier run would go on from."""
        ours = [self.path / name for name in (SCENE, HISTORY, PROFILES, RUN)]
        found = [file.name for file in ours if file.exists()]
        if found and (SCENE not in found or len(found) == 1):
            raise OutputError(
                f"{self.path}: holds a {found[0]} that no run has left; choose another folder"
            )
        self.path.mkdir(parents=True, exist_ok=True)
        for name in (CHECKPOINT, PROFILES):  # the checkpoint first: it needs the others
            (self.path / name).unlink(missing_ok=True)

    def _clear(self) -> None:
        """Remove what tells of the end of an earlier run."""
        for name in (RUN, *FIGURES, SERIES):
            (self.path / name).unlink(missing_ok=True)
        for surface in (self.path / SURFACES).glob("*.vtu"):
            surface.unlink()

    def _begin(self) -> None:
        """Write the scene, and the history as far as it is known."""
        self._replace(SCENE, self._scene.to_toml().encode())
        self._write_history(self._rows)
        self._history = open(self.path / HISTORY, "ab", buffering=0)  # noqa: SIM115

    def _present(self) -> None:
        """Make the folder again if it has been removed."""
        if (self.path / HISTORY).exists():
            return
        with writing(self.path):
            self._history.close()
            self.path.mkdir(parents=True, exist_ok=True)
            self._begin()
        if self._kept:
            self._write_profiles()

    def _append(self, line: str) -> None:
        """Add a whole line, or none where the disk is full."""
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
        self._replace(HISTORY, "".join(line + "\n" for line in lines).encode())

    def _write_profiles(self) -> None:
        content = BytesIO()
        np.savez(content, **Profiles(tuple(self._kept)).arrays())
        with writing(self.path):
            self._replace(PROFILES, content.getvalue())
        self._profiles_written = len(self._kept)

    def _replace(self, name: str, content: bytes) -> None:
        """Write a file that takes the place of an earlier one only once it is complete."""
        replace_file(self.path / name, content)


def _line(row: Row) -> str:
    """Values of a row as Python's own numbers, which print with all their digits."""
    return ",".join(repr(column_type(name)(getattr(row, name))) for name in COLUMNS)


def column_type(column: str) -> type[float] | type[int]:
    """What the numbers of a column of the history are."""
    return int if column in ("newton_iterations", "stable") else float


def _error_bars(bars: ErrorBars) -> dict[str, object]:
    """Error bars for JSON, which has null in place of "not a number"."""
    columns = {
        name: [None if np.isnan(value) else float(value) for value in column]
        for name, column in bars.columns().items()
    }
    return {**columns, "message": bars.message}


def _versions() -> dict[str, str]:
    import dolfinx
    from petsc4py import PETSc

    from .. import __version__

    return {
        "fenics_yeast": __version__,
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
