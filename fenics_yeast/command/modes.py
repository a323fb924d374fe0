"""The work of `fenics-yeast modes`: linear buckling of a wall, its table and its pictures."""

from __future__ import annotations

import csv
import re
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from ..output import DolfinxMissing, FolderLock, replace_file, writing
from ..scene import Scene, SceneError

if TYPE_CHECKING:
    from ..simulation import BucklingMode

TABLE, FIGURE, MODE = "modes.csv", "modes.png", "mode.vtu"
_RANGE = re.compile(r"(\d{1,4}):(\d{1,4})")
_MOST = 1000


def parse_waves(text: str) -> list[int]:
    """Read numbers of waves: ``A:B`` (from A to B) or ``A,B,...``.

    Raises
    ------
    SceneError
        If the text is neither.
    """
    if match := _RANGE.fullmatch(text.strip()):
        numbers = list(range(int(match[1]), int(match[2]) + 1))
    else:
        parts = [part.strip() for part in text.split(",")]
        numbers = [int(part) for part in parts] if all(map(str.isdecimal, parts)) else []
    if not numbers or max(numbers) > _MOST:
        must = f"expected A:B or A,B,... with numbers from 0 to {_MOST}, e.g. 0:12"
        raise SceneError(f"--waves {text[:40]}: {must}")
    return numbers


def find_modes(scene: Scene, waves: list[int], directory: Path) -> list[BucklingMode]:
    """Find the modes of a scene's unloaded wall; write their table and pictures.

    Raises
    ------
    SceneError
        If the wall cannot buckle in this way.
    OutputError
        If the directory cannot be written.
    DolfinxMissing
        If there is no compiler.
    EquilibriumError
        If the wall has no equilibrium under a very small pressure.
    """
    from .._form_cache import CompilerError
    from ..figures import draw_modes, first_mode, write_mode
    from ..simulation import buckling_modes

    if "free" in scene.cell.ends or not scene.wall.bending:
        raise SceneError("buckling needs a wall with bending stiffness and without a free edge")
    try:
        modes = list(buckling_modes(scene, waves))
    except CompilerError as error:
        raise DolfinxMissing(str(error)) from None
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["waves", "critical_pressure_MPa"])
    table.writerows((mode.waves, mode.pressure) for mode in modes)
    known = [mode for mode in modes if mode.pressure is not None]
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        with FolderLock(directory):
            for name in (FIGURE, MODE):
                (directory / name).unlink(missing_ok=True)
            replace_file(directory / TABLE, text.getvalue().encode())
            if known:
                draw_modes(modes, scene.title, directory / FIGURE)
                write_mode(first_mode(known), directory / MODE)
    return modes
