"""Derivatives of a run's history by parameters of its scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Array
from . import tables
from .history import History
from .interpolation import interpolate, times_within


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of columns of the history by parameters, with steps, mesh and points held.

    Those of a state that no step in time led to are not numbers.

    Attributes
    ----------
    parameters, values
        Dotted keys of the scene, and their values in µm, MPa and min.
    time_min
        Times of the rows of the history in min, shape ``(rows,)``.
    kinks
        Times in min at which slopes jump, with pressure or growth.
    pressure_MPa, volume_um3, volume_ratio, pole_height_um, bud_radius_um, neck_radius_um
        Derivatives of these columns per unit of each parameter, shape ``(rows, parameters)``.
    """

    parameters: tuple[str, ...]
    values: tuple[float, ...]
    time_min: Array
    kinks: tuple[float, ...]
    pressure_MPa: Array
    volume_um3: Array
    volume_ratio: Array
    pole_height_um: Array
    bud_radius_um: Array
    neck_radius_um: Array

    @classmethod
    def of_columns(
        cls,
        parameters: tuple[str, ...],
        values: tuple[float, ...],
        history: History,
        derivatives: Callable[[str], Array],
    ) -> Sensitivities:
        """Return those of a history, from a function that returns the derivatives of a column."""
        columns = {name: derivatives(name) for name in COLUMNS}
        return cls(parameters, values, history.time_min, history.kinks, **columns)

    @classmethod
    def joined(cls, parts: Iterable[Sensitivities], parameters: Sequence[str]) -> Sensitivities:
        """Join derivatives of one history by different parameters, in the order of some of them."""
        every = list(parts)
        names = [name for part in every for name in part.parameters]
        values = [value for part in every for value in part.values]
        places = [names.index(name) for name in parameters]
        columns = {
            name: np.concatenate([part.of(name) for part in every], axis=1)[:, places]
            for name in COLUMNS
        }
        held = tuple(values[place] for place in places)
        return cls(tuple(parameters), held, every[0].time_min, every[0].kinks, **columns)

    def of(self, column: str) -> Array:
        """Return the derivatives of a column, shape ``(rows, parameters)``.

        Raises
        ------
        ValueError
            If the column has no derivatives.
        """
        if column not in COLUMNS:
            names = ", ".join(COLUMNS)
            raise ValueError(f"no derivatives of {column}; choose one of {names}")
        found: Array = getattr(self, column)
        return found

    def interpolate(self, column: str, times: ArrayLike) -> Array:
        """Return the derivatives of `History.interpolate`, shape ``(times, parameters)``.

        They are not numbers beyond the first row that has none.

        Raises
        ------
        ValueError
            If the column has no derivatives, or a time lies outside the run.
        """
        values, wanted = self.of(column), times_within(self.time_min, times)
        known = np.isfinite(values).all(axis=1)
        if known.all():
            return interpolate(self.time_min, values, self.kinks, wanted)
        count, found = int(known.argmin()), np.full((len(wanted), values.shape[1]), np.nan)
        if count > 1:
            time = self.time_min[:count]
            early = wanted <= time[-1]
            found[early] = interpolate(time, values[:count], self.kinks, wanted[early])
        return found

    def to_frame(self, column: str) -> Any:
        """Return the derivatives of a column as a pandas `DataFrame`, a column per parameter.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        derivatives = dict(zip(self.parameters, self.of(column).T, strict=True))
        return tables.frame({"time_min": self.time_min, **derivatives})


COLUMNS = tuple(field.name for field in fields(Sensitivities))[4:]
