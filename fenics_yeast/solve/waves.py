"""Stability against perturbations with waves around the axis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from .. import _dolfinx as dx
from ..mechanics import Shell
from .inertia import Inertia

_SAMPLES = (0, 3, 6)  # numbers of waves, of which the second variation is a polynomial of degree 2


class WaveModes:
    """Counts the negative modes of a shell for each number of waves; a context manager.

    `variation` is the compiled second variation.
    """

    def __init__(self, shell: Shell) -> None:
        self.variation = variation = shell.second_variation
        self._inertia = Inertia(variation.form, variation.space, shell.comm)
        self._samples: list[Any] = []

    def __enter__(self) -> WaveModes:
        return self

    def __exit__(self, *_: object) -> None:
        self._inertia.destroy()
        for sample in self._samples:
            sample.destroy()

    def negative_modes(self, waves: int) -> int:
        """Return the number of negative modes with `waves >= 1` waves in the trial state."""
        self.variation.waves.value = waves
        return self._inertia.negative_modes(self.variation.conditions(waves))

    def falling(self, numbers: Sequence[int]) -> Iterator[int]:
        """Yield those of some numbers of waves that have a negative mode in the trial state.

        The trial state must not change meanwhile. Many numbers take three assemblies.
        """
        if len(numbers) <= len(_SAMPLES):
            yield from (n for n in numbers if self.negative_modes(n) > 0)
            return
        self._sample()
        matrix = self._inertia.matrix
        for n in numbers:
            matrix.zeroEntries()
            for sample, weight in zip(self._samples, _weights(n), strict=True):
                matrix.axpy(weight, sample, structure=dx.PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
            dx.constrain(matrix, self.variation.conditions(n))
            if self._inertia.count() > 0:
                yield n

    def _sample(self) -> None:
        """Assemble the second variation at some numbers of waves, without conditions."""
        form = self.variation.form
        if not self._samples:
            self._samples = [dx.create_matrix(form) for _ in _SAMPLES]
            dx.assemble_matrix(self._inertia.matrix, form, [])  # which fixes its pattern
        for n, sample in zip(_SAMPLES, self._samples, strict=True):
            self.variation.waves.value = n
            dx.assemble_matrix(sample, form, [])


def _weights(n: int) -> list[float]:
    """Return the weights of the samples in the polynomial of degree 2 through them, at n."""
    a, b, c = _SAMPLES
    return [
        (n - b) * (n - c) / ((a - b) * (a - c)),
        (n - a) * (n - c) / ((b - a) * (b - c)),
        (n - a) * (n - b) / ((c - a) * (c - b)),
    ]
