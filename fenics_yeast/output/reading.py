"""The output folder of a run, read back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile

import numpy as np

from ..scene import Scene
from ..simulation import (
    COLUMNS,
    ErrorBars,
    History,
    Profile,
    Profiles,
    Result,
    Row,
    Status,
    Timings,
)
from .folder import HISTORY, PROFILES, RUN, SCENE, OutputError, column_type


def read_scene(directory: Path) -> Scene:
    """Scene of a run.

    Raises
    ------
    OutputError
        If there is none.
    SceneError
        If it cannot be read.
    """
    if not (directory / SCENE).is_file():
        raise OutputError(f"{directory}: holds no {SCENE}; the output of a run is wanted")
    return Scene.load(directory / SCENE)


def read_history(directory: Path) -> History:
    """History of a run, finished or still going; a line cut at the end is left out.

    Raises
    ------
    OutputError
        If there is none, or it cannot be read.
    """
    path = directory / HISTORY
    try:
        lines = path.read_text(encoding="utf-8").split("\n")[:-1]
    except (OSError, UnicodeDecodeError):
        raise OutputError(
            f"{directory}: holds no {HISTORY}; the output of a run is wanted"
        ) from None
    columns = lines[0].split(",") if lines else []
    if missing := [name for name in COLUMNS if name not in columns]:
        raise OutputError(f"{path}: has no column {missing[0]}; run the scene again")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            values = dict(zip(columns, line.split(","), strict=True))
            numbers = {name: column_type(name)(values[name]) for name in COLUMNS}
            rows.append(Row(**numbers | {"stable": bool(numbers["stable"])}))  # type: ignore[arg-type]
        except ValueError:
            raise OutputError(f"{path}: line {number} is damaged; run the scene again") from None
    return History(rows)


def read_profiles(directory: Path) -> Profiles:
    """Profiles of a run; none where nothing has been saved yet.

    Raises
    ------
    OutputError
        If they cannot be read.
    """
    path = directory / PROFILES
    try:
        with np.load(path) as file:
            arrays = dict(file)
        if not len(arrays["time_min"]):
            return Profiles(())
        fixed = {name: arrays[name] for name in ("S", "S_points", "xi")}
        moving = ("r", "z", "psi", "strain", "stress", "growth_strain")
        return Profiles(
            tuple(
                Profile(time=float(time), **fixed, **{name: arrays[name][i] for name in moving})
                for i, time in enumerate(arrays["time_min"])
            )
        )
    except FileNotFoundError:
        return Profiles(())
    except (OSError, ValueError, KeyError, BadZipFile, EOFError):
        raise OutputError(f"{path}: is damaged; run the scene again") from None


class Ending(NamedTuple):
    """How a run ended: status, that in a sentence, and the seconds that all of it took."""

    status: Status
    message: str
    total_s: float


def read_status(directory: Path) -> Status | None:
    """How a run ended, in a word; None while it is going.

    Raises
    ------
    OutputError
        If that cannot be read.
    """
    ending = read_ending(directory)
    return None if ending is None else ending.status


def read_ending(directory: Path) -> Ending | None:
    """How a run ended; None while it is going.

    Raises
    ------
    OutputError
        If that cannot be read.
    """
    path = directory / RUN
    try:
        summary = json.loads(path.read_bytes())
        seconds = float(summary["timings"]["total_s"])
        return Ending(summary["status"], summary["message"], seconds)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError):
        raise OutputError(f"{path}: is damaged; run the scene again") from None


def read_result(directory: Path) -> Result:
    """Result of a run that has ended.

    Raises
    ------
    OutputError
        If it has not, or if it cannot be read.
    """
    path = directory / RUN
    try:
        summary = json.loads(path.read_bytes())
        return Result(
            history=read_history(directory),
            profiles=read_profiles(directory),
            status=summary["status"],
            message=summary["message"],
            end_time=summary["end_time_min"],
            dofs=summary["dofs"],
            steps=summary["steps"],
            rejected_steps=summary["rejected_steps"],
            newton_iterations=summary["newton_iterations"],
            timings=Timings(**summary["timings"]),
            error_bars=read_error_bars(directory),
        )
    except FileNotFoundError:
        raise OutputError(f"{directory}: holds no {RUN}; the run has not ended") from None
    except (OSError, ValueError, KeyError, TypeError):
        raise OutputError(f"{path}: is damaged; run the scene again") from None


def read_error_bars(directory: Path) -> ErrorBars | None:
    """Error bars of a run; None where it has none.

    Raises
    ------
    OutputError
        If they cannot be read.
    """
    path = directory / RUN
    try:
        found = json.loads(path.read_bytes()).get("error_bars")
        if found is None:
            return None
        del found["total"]  # the sum of the parts
        message = found.pop("message")
        columns = {name: np.array(column, dtype=float) for name, column in found.items()}
        return ErrorBars(**columns, message=message)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise OutputError(f"{path}: is damaged; run the scene again") from None
