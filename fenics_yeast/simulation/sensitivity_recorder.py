"""Record the derivatives of a run's history by parameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry import Array
from ..mechanics import Shell
from ..solve import ForwardSensitivities
from .directions import Model, direction
from .history import History
from .measurements import Measurements
from .sensitivities import COLUMNS, Sensitivities


class SensitivityRecorder:
    """Derivatives of the history's rows by parameters; a context manager.

    Parameters
    ----------
    model, shell
        The scene with its laws, and its wall in its initial state.
    keys
        The parameters.
    measurements
        Of the shell.

    Attributes
    ----------
    follower
        Follows the steps of the shell.

    Raises
    ------
    SceneError
        If the run cannot be differentiated by one of the parameters.
    """

    def __init__(
        self, model: Model, shell: Shell, keys: Sequence[str], measurements: Measurements
    ) -> None:
        self._shell, self._measurements = shell, measurements
        self._keys = tuple(keys)
        self._values = tuple(model.value(key) for key in keys)
        self._directions = [direction(model, shell, key) for key in keys]
        self.follower = ForwardSensitivities(shell, self._directions)
        self._rows: list[Array] = []

    def __enter__(self) -> SensitivityRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.follower.destroy()

    def record(self, time: float) -> None:
        """Record the derivatives of the accepted state at a time in min; collective."""
        shell, w = self._shell, self.follower.w
        pressure = [each.pressure(time) for each in self._directions]
        volume = shell.volume_changes(w)
        sizes = self._measurements.size_changes(w)
        row = [pressure, volume, volume / shell.reference_volume, *sizes]
        self._rows.append(np.array(row))

    def result(self, history: History) -> Sensitivities:
        """Return what was recorded, beside its history."""
        rows = np.array(self._rows).reshape(len(self._rows), len(COLUMNS), len(self._keys))
        columns = dict(zip(COLUMNS, rows.swapaxes(0, 1), strict=True))
        return Sensitivities.of_columns(self._keys, self._values, history, columns.__getitem__)
