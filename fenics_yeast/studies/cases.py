"""Cases of a sweep: the product of lists of values, or of rows of them; each a validated scene."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import product

from pydantic import BaseModel

from ..scene import Scene, SceneError, parse_value, value_of

_MOST_VALUES = 100_000
_DIGITS = 12  # of a value in a range: 1.1 rather than 1.0999999999999999
_PIECES = re.compile(r"\[[^]]*\]|\{[^}]*\}|\"[^\"]*\"|'[^']*'|.", re.DOTALL)
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(.*)")


@dataclass(frozen=True)
class Variation:
    """Keys of the scene that vary together, such as ``growth.time``, and their values.

    Attributes
    ----------
    keys
        The keys: one for an option `--vary`, those of the columns for a table.
    rows
        Their values, row by row.
    sources
        Where each row was written, for messages; empty if the values themselves say so.
    """

    keys: tuple[str, ...]
    rows: tuple[tuple[object, ...], ...]
    sources: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    """One scene of a sweep.

    Attributes
    ----------
    name
        Name of its directory, made of its values.
    values
        Values of the varied keys: numbers in µm, MPa, min and degrees, otherwise strings.
    scene
        What to run.
    """

    name: str
    values: tuple[float | str, ...]
    scene: Scene


def parse_variation(text: str) -> Variation:
    """Read ``TABLE.KEY=V1,V2,...``; a value ``A:B:N`` stands for N values from A to B.

    Raises
    ------
    SceneError
        If the text cannot be read.
    """
    key, _, listed = (part.strip() for part in text.partition("="))
    entries = _split(listed, ",")
    if not key or not all(entries):
        advice = "write TABLE.KEY=V1,V2,... or TABLE.KEY=A:B:N, e.g. growth.time=30,45,60"
        raise SceneError(f"--vary {text[:80]}: {advice}")
    values: list[object] = []
    for entry in entries:
        ends = _split(entry, ":")
        values += [parse_value(entry)] if len(ends) == 1 else _range(f"{key}={entry}", ends)
    return Variation((key,), tuple((value,) for value in values))


def plan(scene: Scene, variations: Sequence[Variation]) -> list[Case]:
    """Return all unique combinations of the variations' rows, the last one varying fastest.

    Raises
    ------
    SceneError
        If a key is given twice, or a combination is not a valid scene.
    """
    keys = [key for variation in variations for key in variation.keys]
    if twice := [key for key in keys if keys.count(key) > 1]:
        raise SceneError(f"{twice[0]}: given twice; give all its values in one place")
    cases: dict[Scene, Case] = {}
    names: set[str] = set()
    for rows in product(*(range(len(variation.rows)) for variation in variations)):
        changed = _changed(scene, variations, rows)
        if changed in cases:  # "1 MPa" and 1.0
            continue
        held = tuple(_plain(value_of(changed, key)) for key in keys)
        name = _directory(keys, held)
        while name in names:  # long values may differ only at their ends
            name += "+"
        names.add(name)
        cases[changed] = Case(name, held, changed)
    return list(cases.values())


def _changed(scene: Scene, variations: Sequence[Variation], rows: Sequence[int]) -> Scene:
    """Return the scene with the values of a row of each variation."""
    values: dict[str, object] = {}
    sources: list[str] = []
    for variation, row in zip(variations, rows, strict=True):
        values |= zip(variation.keys, variation.rows[row], strict=True)
        sources += variation.sources[row : row + 1]
    try:
        return scene.with_values(values)
    except SceneError as error:
        raise SceneError(": ".join([*sources, str(error)])) from None


def value_label(value: float | str) -> str:
    """Return a parameter's value as a label of at most six digits."""
    return value if isinstance(value, str) else f"{value:.6g}"


def _split(text: str, mark: str) -> list[str]:
    """Split at a mark outside brackets and quotes."""
    parts = [""]
    for piece in _PIECES.findall(text):
        if piece == mark:
            parts.append("")
        else:
            parts[-1] += piece
    return [part.strip() for part in parts]


def _range(text: str, parts: Sequence[str]) -> list[object]:
    """Return the values of ``A:B:N``, equally spaced, with the unit of the ends."""
    ends = [_NUMBER.fullmatch(part) for part in parts[:2]]
    count = parts[2] if len(parts) == 3 else ""
    if None in ends or not count.isdecimal() or not 2 <= int(count) <= _MOST_VALUES:
        advice = f"write a range as A:B:N with N from 2 to {_MOST_VALUES}, e.g. 0.9:1.1:5"
        raise SceneError(f"--vary {text}: {advice}")
    units = {end[2].strip() for end in ends if end} - {""}
    if len(units) > 1:
        raise SceneError(f"--vary {text}: write both ends of the range in one unit")
    start, end = (Decimal(end[1]) for end in ends if end)
    steps = int(count) - 1
    values = [start + (end - start) * i / steps for i in range(steps + 1)]
    if units:
        return [f"{value:.{_DIGITS}g} {min(units)}" for value in values]
    whole = all(value == int(value) for value in values) and "." not in "".join(parts)
    return [int(value) if whole else float(f"{value:.{_DIGITS}g}") for value in values]


def _plain(value: object) -> float | str:
    """Return a value as a number or string."""
    if isinstance(value, float | int) and not isinstance(value, bool):
        return value
    return value if isinstance(value, str) else _text(value)


def _text(value: object) -> str:
    """Return any other value as a string."""
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_none=True)
    if isinstance(value, dict):
        return " ".join(f"{key}={_text(entry)}" for key, entry in value.items())
    if isinstance(value, tuple | list):
        return "[" + " ".join(map(_text, value)) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _directory(keys: Sequence[str], values: Sequence[float | str]) -> str:
    """Return a directory name that shows the values, valid in every file system."""
    parts = (
        f"{key}={value if isinstance(value, str) else format(value, f'.{_DIGITS}g')}"
        for key, value in zip(keys, values, strict=True)
    )
    return re.sub(r"[^\w.=+,-]+", "-", re.sub(r"[][]", "", "_".join(parts)))[:200]
