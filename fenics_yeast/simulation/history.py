"""The history of a run: a row for each accepted state."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry import Array
from . import tables
from .interpolation import interpolate


@dataclass(frozen=True)
class Row:
    """One accepted state of the history; the names carry the units.

    A new column is added here, as the last field, and filled in `recorder.Recorder.accept`.

    Attributes
    ----------
    time_min
        Time; 0 for all points of an equilibrium path.
    pressure_MPa
        Turgor pressure, negative if external.
    volume_um3, volume_ratio
        Volume enclosed by the mid-surface, and its ratio to that of the unloaded cell.
    pole_height_um
        Height of the upper end of the meridian above the lower end.
    bud_radius_um, neck_radius_um
        Largest radius of the growing zones and of their edges; 0 where nothing grows.
    max_growth_strain
        Largest growth strain.
    dissipation_rate
        Dissipation of growth (12), µm³ MPa/min.
    step_min
        Length of the step that led here.
    newton_iterations
        Newton iterations of that step.
    stable
        Whether no small perturbation at given growth and loads moves the state away.
    force_uN, displacement_um
        Force of the table `[load]` and its displacement; 0 without it.
    unstable_waves
        Smallest number of waves around the axis of a perturbation that moves the state away, 0 if
        that is axisymmetric; None while the state is stable.
    """

    time_min: float
    pressure_MPa: float
    volume_um3: float
    volume_ratio: float
    pole_height_um: float
    bud_radius_um: float
    neck_radius_um: float
    max_growth_strain: float
    dissipation_rate: float
    step_min: float
    newton_iterations: int
    stable: bool
    force_uN: float = 0.0
    displacement_um: float = 0.0
    unstable_waves: int | None = None


COLUMNS = tuple(field.name for field in fields(Row))
_values = attrgetter(*COLUMNS)


class Digest:
    """A hash of rows, by which a changed history is recognised."""

    def __init__(self, rows: Iterable[Row] = ()) -> None:
        self._hash = hashlib.sha256()
        for row in rows:
            self.add(row)

    def add(self, row: Row) -> None:
        """Add a row."""
        values = [None if value is None else float(value) for value in _values(row)]
        self._hash.update(repr(values).encode())

    @property
    def text(self) -> str:
        """The hash of all rows so far."""
        return self._hash.hexdigest()


class History:
    """The accepted states of a run, a NumPy array for each column of `Row`.

    ``history.volume_ratio`` is the array of all rows; ``history.at(90)`` is the row at 90 min. In
    ``unstable_waves``, stable rows have "not a number".

    Attributes
    ----------
    rows
        The rows, in order of time or along the path.
    kinks
        Times in min at which slopes jump, with pressure or growth.
    """

    time_min: Array
    pressure_MPa: Array
    volume_um3: Array
    volume_ratio: Array
    pole_height_um: Array
    bud_radius_um: Array
    neck_radius_um: Array
    max_growth_strain: Array
    dissipation_rate: Array
    step_min: Array
    newton_iterations: NDArray[np.int64]
    stable: NDArray[np.bool_]
    force_uN: Array
    displacement_um: Array
    unstable_waves: Array

    def __init__(self, rows: Iterable[Row], kinks: Iterable[float] = ()) -> None:
        self.rows: Sequence[Row] = tuple(rows)
        self.kinks = tuple(kinks)
        for name in COLUMNS:
            values = [getattr(row, name) for row in self.rows]
            setattr(self, name, np.array([np.nan if v is None else v for v in values]))

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        if not self.rows:
            return "History(empty)"
        last = self.rows[-1]
        return (
            f"History({len(self)} rows, t = {self.rows[0].time_min:g} to {last.time_min:g} min, "
            f"V/V0 = {last.volume_ratio:.6f} at the end)"
        )

    def _repr_html_(self) -> str | None:
        return tables.html(self)

    def to_frame(self) -> Any:
        """Return the rows as a pandas `DataFrame`, a column for each field of `Row`.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return tables.frame({name: getattr(self, name) for name in COLUMNS})

    def at(self, time: float) -> Row:
        """Return the row at a time in min that the run hit exactly, such as a saved time.

        Raises
        ------
        KeyError
            If no row is at that time.
        """
        for row in reversed(self.rows):
            if abs(row.time_min - time) <= 1e-9 * max(1.0, abs(time)):
                return row
        raise KeyError(f"no accepted step at {time:g} min; add it to run.save")

    def interpolate(self, column: str, times: ArrayLike) -> Array:
        """Return a column at any times in min of a run, such as those of a measurement.

        The error falls with the fourth power of the step size; kinks of the pressure and switches
        of growth remain sharp.

        Raises
        ------
        ValueError
            If the column is unknown, or a time lies outside the run.
        """
        if column not in COLUMNS:
            raise ValueError(f"no column {column}; choose one of {', '.join(COLUMNS)}")
        values = np.asarray(getattr(self, column), dtype=float)
        return interpolate(self.time_min, values, self.kinks, times)
