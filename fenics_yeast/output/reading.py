"""Read the output directory of a run."""

from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from ..scene import Scene
from ..simulation import (
    COLUMNS,
    BucklingMode,
    History,
    Profile,
    Profiles,
    Result,
    Row,
    discretise,
    kinks,
)
from .errors import OutputError
from .files import HISTORY, MODE, PROFILES, RUN, SCENE
from .folder import read_value
from .summary import read_summary


def _no(directory: Path, name: str) -> OutputError:
    """Return the error about a missing file of a run."""
    if not directory.exists():
        return OutputError(f"{directory}: no such directory")
    return OutputError(f"{directory}: no {name}; not the output directory of a run")


def read_scene(directory: Path) -> Scene:
    """Read the scene of a run.

    Raises
    ------
    OutputError
        If there is none.
    SceneError
        If it cannot be read.
    """
    if not (directory / SCENE).is_file():
        raise _no(directory, SCENE)
    return Scene.load(directory / SCENE)


def read_history(directory: Path) -> History:
    """Read the history of a run, finished or in progress; skip an incomplete last line.

    Raises
    ------
    OutputError
        If there is none, or it cannot be read.
    """
    path = directory / HISTORY
    try:
        lines = path.read_text(encoding="utf-8").split("\n")[:-1]
    except FileNotFoundError:
        raise _no(directory, HISTORY) from None
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise OutputError(f"{path}: damaged; rerun the scene") from None
    columns = lines[0].split(",") if lines else []
    if missing := [name for name in COLUMNS if name not in columns]:
        raise OutputError(f"{path}: column {missing[0]} is missing; rerun the scene")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            values = dict(zip(columns, line.split(","), strict=True))
            numbers = {name: read_value(name, values[name]) for name in COLUMNS}
            rows.append(Row(**numbers | {"stable": bool(numbers["stable"])}))  # type: ignore[arg-type]
        except ValueError:
            raise OutputError(f"{path}: line {number} is damaged; rerun the scene") from None
    places = kinks(read_scene(directory)) if (directory / SCENE).is_file() else ()
    return History(rows, places)


def read_profiles(directory: Path) -> Profiles:
    """Read the profiles of a run; none if nothing has been saved yet.

    Raises
    ------
    OutputError, SceneError
        If they or the scene cannot be read.
    """
    path = directory / PROFILES
    try:
        with np.load(path) as file:
            arrays = dict(file)
        if not len(arrays["time_min"]):
            return Profiles(())
        fixed = {name: arrays[name] for name in ("S", "S_points", "xi")}
        moving = ("r", "z", "psi", "strain", "stress", "growth_strain")
        profiles = tuple(
            Profile(time=float(time), **fixed, **{name: arrays[name][i] for name in moving})
            for i, time in enumerate(arrays["time_min"])
        )
    except FileNotFoundError:
        return Profiles(())
    except (OSError, ValueError, KeyError, BadZipFile, EOFError):
        raise OutputError(f"{path}: damaged; rerun the scene") from None
    return Profiles(profiles, discretise(read_scene(directory)).zones)


def read_mode(directory: Path) -> BucklingMode | None:
    """Read the mode of the first bifurcation of a run that has ended; None if it has none.

    Raises
    ------
    OutputError
        If it cannot be read.
    """
    path = directory / MODE
    try:
        with np.load(path) as file:
            values = dict(file)
        scalars = int(values.pop("waves")), float(values.pop("pressure"))
        return BucklingMode(*scalars, **values)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, BadZipFile, EOFError):
        raise OutputError(f"{path}: damaged; rerun the scene") from None


def read_result(directory: Path) -> Result:
    """Read the result of a run that has ended.

    Raises
    ------
    OutputError
        If the run has not ended, or a file is damaged.
    """
    summary = read_summary(directory)
    if summary is None:
        raise OutputError(f"{directory}: no {RUN}; the run has not ended")
    values = dict(vars(summary))
    end_time = values.pop("end_time_min")
    del values["versions"]
    parts = read_history(directory), read_profiles(directory)
    return Result(*parts, end_time=end_time, mode=read_mode(directory), **values)
