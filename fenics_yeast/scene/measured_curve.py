"""A measured curve: values of a cell over time, read from a CSV file, and how it was measured."""

from __future__ import annotations

import csv
import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Literal

from .errors import SceneError, value_text
from .text_file import read_text

# Columns of a file, and those of the history that they are compared with.
COLUMNS = {
    "volume_um3": "volume_um3",
    "volume_ratio": "volume_ratio",
    "length_um": "pole_height_um",
    "pole_height_um": "pole_height_um",
    "radius_um": "bud_radius_um",
}
_TIME, _ERROR, _BUD = "time_min", "error", "bud_volume_um3"
_LARGEST_NOISE = 1.0


@dataclass(frozen=True)
class MeasuredCurve:
    """Measured values of one experiment.

    Attributes
    ----------
    name
        Name in tables and figures.
    quantity
        What was measured: ``volume_um3``, ``volume_ratio`` (V/V0 with the unloaded V0),
        ``length_um`` or ``pole_height_um`` (distance of the poles), ``radius_um`` (largest radius
        of the growing zones).
    time_min
        Times in min, in order.
    values
        Values, positive, in the unit of the quantity.
    noise
        Standard deviations relative to the values: one for each, or one for all.
    offset
        Time in min in this curve at which the run begins, or "free" if it is to be fitted.
    set
        How this experiment differed: values by dotted keys of the scene.
    """

    name: str
    quantity: str
    time_min: Sequence[float]
    values: Sequence[float]
    noise: Sequence[float] | float
    offset: float | Literal["free"] = 0.0
    set: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        problem = _problem(self)
        if problem:
            raise SceneError(f"{self.name}: {problem}")

    @property
    def column(self) -> str:
        """Column of the history that the values are compared with."""
        return COLUMNS[self.quantity]

    @property
    def relative_errors(self) -> list[float]:
        """Standard deviation of each value, relative to it."""
        noise = self.noise
        return [noise] * len(self.values) if isinstance(noise, float | int) else list(noise)

    @classmethod
    def read(
        cls,
        path: str | Path,
        *,
        noise: float | None = None,
        offset: float | Literal["free"] = 0.0,
        set: Mapping[str, object] | None = None,
    ) -> MeasuredCurve:
        """Read a CSV file with the column ``time_min`` and one of the quantities.

        A column ``error`` has standard deviations relative to the values, and replaces `noise`.

        Raises
        ------
        SceneError
            If the file cannot be read, or has not these columns.
        """
        quantity, table = _read(Path(path))
        errors = table.get(_ERROR)
        if errors is None and noise is None:
            raise SceneError(
                f"{path}: no noise; set noise, e.g. 0.01, or add a column error, both relative"
            )
        return cls(
            str(path), quantity, table[_TIME], table[quantity],
            errors if errors is not None else noise or 0.0, offset, set or {},
        )  # fmt: skip


def _problem(curve: MeasuredCurve) -> str:
    """Return what is wrong with a curve, "" if nothing."""
    if curve.quantity not in COLUMNS:
        return f"quantity = {value_text(curve.quantity)}: expected one of {', '.join(COLUMNS)}"
    times, values, noise = curve.time_min, curve.values, curve.relative_errors
    if not len(times):
        return "no values"
    if not len(times) == len(values) == len(noise):
        return (
            f"{len(times)} times, {len(values)} values and {len(noise)} errors; expected one each"
        )
    if any(not before < after for before, after in pairwise(times)):
        return "expected increasing times"
    if any(not (isfinite(value) and value > 0) for value in values):
        return f"{curve.quantity}: expected numbers > 0"
    if any(not 0 < error < _LARGEST_NOISE for error in noise):
        return "noise and the column error are relative to the values: expected numbers > 0 and < 1"
    if curve.offset == 0 and times[0] < 0:
        return f"time_min = {times[0]:g}: negative; set offset, the time at which growth began"
    if curve.offset != "free" and times[-1] <= curve.offset:
        return f"offset = {curve.offset:g}: expected less than the last time, {times[-1]:g} min"
    return ""


def _read(path: Path) -> tuple[str, dict[str, list[float]]]:
    """Return the measured quantity of a file, and its columns of numbers."""
    text = read_text(path, "a table of measured values")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    header = [name.strip() for name in lines[0].split(",")] if lines else []
    quantity = _quantity(path, header)
    columns: dict[str, list[float]] = {name: [] for name in header}
    for number, cells in enumerate(csv.reader(lines[1:]), 2):
        if len(cells) != len(header):
            raise SceneError(f"{path}, row {number}: {len(cells)} cells; expected {len(header)}")
        for name, cell in zip(header, cells, strict=True):
            if name not in (_TIME, quantity, _ERROR):
                continue
            try:
                columns[name].append(float(cell))
            except ValueError:
                where = f"{path}, row {number}: {name} = {value_text(cell)}"
                raise SceneError(f"{where}: expected a number") from None
    return quantity, {name: columns[name] for name in (_TIME, quantity, _ERROR) if name in columns}


def _quantity(path: Path, header: Sequence[str]) -> str:
    """Return the measured quantity among the columns of a file."""
    found = [name for name in header if name in COLUMNS]
    choice = f"columns time_min and one of {', '.join(COLUMNS)}"
    if len(set(header)) != len(header):
        raise SceneError(f"{path}: two columns have the same name")
    if _TIME in header and len(found) == 1:
        return found[0]
    if len(found) > 1:
        raise SceneError(f"{path}: {' and '.join(found)}: expected one; split it into two files")
    if _TIME in header and _BUD in header:
        raise SceneError(
            f"{path}: {_BUD} is not a result of a run; convert it to volume_um3 of the whole cell, "
            "or measure length_um or radius_um"
        )
    missing = [_TIME] if _TIME not in header else list(COLUMNS)
    for name in header:
        if near := difflib.get_close_matches(name, missing, n=1, cutoff=0.6):
            raise SceneError(f"{path}: unknown column {name[:40]}; did you mean {near[0]}?")
    raise SceneError(f"{path}: expected the {choice}")
