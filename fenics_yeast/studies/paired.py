"""Values of a sweep that belong together: the rows of a table, whose headings are scene keys."""

import csv
from pathlib import Path

from ..scene import SceneError, parse_value, read_text
from .cases import Variation

_MARKS = ",;\t"  # between columns
_EXPECTED = "expected scene keys as headings, e.g. turgor.pressure,growth.time"


def read_paired(path: Path) -> Variation:
    """Read a table with a column per scene key, and a row per case.

    Values are written as after `--set`: numbers, or with a unit as ``30 min``. Columns are
    separated by commas, semicolons or tabs; lines that begin with ``#`` are skipped.

    Raises
    ------
    SceneError
        If the file cannot be read, a value is missing, or it is no such table.
    """
    text = read_text(path, "a table of cases")
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise SceneError(f"{path}: empty; {_EXPECTED}")
    mark = next((mark for mark in _MARKS if mark in lines[0][1]), ",")
    keys = tuple(cell.strip() for cell in _cells(lines[0][1], mark))
    if not all(keys):
        raise SceneError(f"{path}: column {keys.index('') + 1} has no heading; {_EXPECTED}")
    if len(lines) == 1:
        raise SceneError(f"{path}: no values below its headings; write a line for each case")
    rows, sources = [], []
    for number, line in lines[1:]:
        source = f"{path}: line {number}"
        cells = [cell.strip() for cell in _cells(line, mark)]
        if len(cells) > len(keys):
            raise SceneError(f"{source}: {len(cells)} values for {len(keys)} columns")
        cells += [""] * (len(keys) - len(cells))
        if "" in cells:
            raise SceneError(
                f"{source}: no value for {keys[cells.index('')]}; fill it in, or remove the line"
            )
        rows.append(tuple(parse_value(cell) for cell in cells))
        sources.append(source)
    return Variation(keys, tuple(rows), tuple(sources))


def _cells(line: str, mark: str) -> list[str]:
    return next(csv.reader([line], delimiter=mark, skipinitialspace=True))
