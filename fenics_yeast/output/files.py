"""Names of the files in an output directory, and how they are written."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import OutputWriteError

SCENE, HISTORY, PROFILES, RUN = "scene.toml", "history.csv", "profiles.npz", "run.json"
CHECKPOINT, MODE = "checkpoint.npz", "mode.npz"
# Made from the others by the figures.
SHAPES, VOLUME, MERIDIAN, BUCKLED = (
    f"figures/{name}.png" for name in ("shapes", "volume", "meridian", "mode")
)
FIGURES = (SHAPES, VOLUME, MERIDIAN, BUCKLED)
ANIMATIONS = GIF, MP4 = "figures/film.gif", "figures/film.mp4"
SERIES, SURFACES, MODE_SURFACE = "surface.pvd", "surface", "mode.vtu"


@contextmanager
def writing(directory: Path) -> Iterator[None]:
    """Turn an error in writing to an output directory into an `OutputWriteError`."""
    advice = "choose another output directory"
    try:
        yield
    except (FileExistsError, NotADirectoryError):
        problem = "must be a directory, but it or a directory above it is a file"
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}"
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            advice = f"free some space there, or {advice}"
    else:
        return
    raise OutputWriteError(f"{directory}: {problem}", advice)


def replace_file(path: Path, content: bytes) -> None:
    """Write a file that replaces an earlier one only once it is complete."""
    temporary = path.with_name(path.name + ".part")
    try:
        with open(temporary, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
