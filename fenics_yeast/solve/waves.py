"""Stability against perturbations with waves around the axis."""

from __future__ import annotations

from ..mechanics import Shell
from .inertia import Inertia


class WaveModes:
    """Counts the negative modes of a shell for each number of waves; a context manager.

    `variation` is the compiled second variation.
    """

    def __init__(self, shell: Shell) -> None:
        self.variation = variation = shell.second_variation()
        self._inertia = Inertia(variation.form, variation.space, shell.comm)

    def __enter__(self) -> WaveModes:
        return self

    def __exit__(self, *_: object) -> None:
        self._inertia.destroy()

    def negative_modes(self, waves: int) -> int:
        """Return the number of negative modes with `waves >= 1` waves in the trial state."""
        self.variation.waves.value = waves
        return self._inertia.negative_modes(self.variation.conditions(waves))
