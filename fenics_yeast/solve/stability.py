"""Stability of an equilibrium: the inertia of the tangent at given growth and pressure."""

from __future__ import annotations

from dataclasses import dataclass

from ..mechanics import Shell
from .inertia import Inertia

_SAME = 2e-3  # relative change of the volume within which a count remains valid


@dataclass(frozen=True)
class StabilityState:
    """The last count of negative modes, and the volume in µm³ and pressure in MPa of its state."""

    negative_modes: int = 0
    volume: float = 0.0
    pressure: float = 0.0


class Stability:
    """Counts the axisymmetric negative modes of a shell; a context manager."""

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        self._last = StabilityState()
        serial = shell.comm.size == 1
        self._inertia = Inertia(
            shell.forms.tangent, shell.space, shell.comm, "petsc" if serial else "mumps"
        )

    def __enter__(self) -> Stability:
        return self

    def __exit__(self, *_: object) -> None:
        self._inertia.destroy()

    def state(self) -> StabilityState:
        """Return the last count."""
        return self._last

    def restore(self, state: StabilityState) -> None:
        """Continue from a count."""
        self._last = state

    def negative_modes(self) -> int:
        """Return the number of negative modes; 0 if the trial state is stable.

        They are counted again if the volume has changed since the last count, or the pressure:
        towards a limit point of an inflated wall the volume changes ever faster.
        """
        shell, last = self._shell, self._last
        volume, pressure = shell.volume(), float(shell.pressure.value)
        near = abs(volume - last.volume) < _SAME * last.volume and pressure == last.pressure
        # A force or external pressure may buckle the wall at the same volume.
        if not near or pressure <= 0 or shell.force is not None:
            self._last = StabilityState(self._count(), volume, pressure)
        return self._last.negative_modes

    def _count(self) -> int:
        return self._inertia.negative_modes(self._shell.conditions)
