"""What a run has found so far, noted as it goes and told to an observer."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import TypeVar

from .probe import Probe
from .record import Observer, Profile, Row
from .shell import Shell, Snapshot

T = TypeVar("T")


class ObserverError(Exception):
    """The observer raised what is this error's cause; it is told nothing more."""


class Journal:
    """Accepted states and saved profiles of a run, and what they took.

    Parameters
    ----------
    shell
        The wall, unloaded.
    observer
        Is told of every accepted state and every saved profile, on rank 0 alone.

    Attributes
    ----------
    rows, profiles
        What was accepted and saved so far.
    rejected, iterations
        Number of rejected steps; Newton iterations of all steps.
    output_s
        Seconds spent on profiles and by the observer.
    """

    def __init__(self, shell: Shell, observer: Observer | None) -> None:
        self._shell, self._probe = shell, Probe(shell)
        self._observer = observer if shell.comm.rank == 0 else None
        self._volume_0 = shell.reference_volume
        self._accepted: tuple[Snapshot, float] | None = None
        self._saved = True
        self.rows: list[Row] = []
        self.profiles: list[Profile] = []
        self.rejected = self.iterations = 0
        self.output_s = 0.0

    @property
    def volume_0(self) -> float:
        """Volume in µm³ that ratios refer to, that of the unloaded cell."""
        return self._volume_0

    def accept(self, time: float, step: float, iterations: int, stable: bool) -> None:
        """Note the shell's state as accepted, at a time in min after a step of some length."""
        shell, sizes = self._shell, self._probe.sizes()
        self.iterations += iterations
        volume, pressure = shell.volume(), float(shell.pressure.value)
        row = Row(
            time_min=time,
            pressure_MPa=pressure,
            volume_um3=volume,
            volume_ratio=volume / self._volume_0,
            pole_height_um=sizes.pole_height,
            bud_radius_um=sizes.bud_radius,
            neck_radius_um=sizes.neck_radius,
            max_growth_strain=sizes.max_growth_strain,
            dissipation_rate=shell.dissipation_rate(),
            step_min=step,
            newton_iterations=iterations,
            stable=stable,
            force_uN=0.0 if shell.force is None else shell.force.value,
            displacement_um=0.0 if shell.force is None else shell.force.displacement(),
        )
        self._accepted, self._saved = (shell.snapshot(), pressure), False
        self.rows.append(row)
        if self._observer is not None:
            self._tell(self._observer.accepted, row)

    def reject(self, iterations: int) -> None:
        """Note a rejected step."""
        self.rejected += 1
        self.iterations += iterations

    def save(self) -> None:
        """Keep the profile of the accepted state, unless that was done."""
        if self._accepted is None or self._saved:
            return
        began = perf_counter()
        state, pressure = self._accepted
        self._shell.restore(state)
        self._shell.pressure.value = pressure
        self._saved = True
        profile = self._probe.profile(self.rows[-1].time_min)
        self.output_s += perf_counter() - began
        if profile is not None:
            self.profiles.append(profile)
            if self._observer is not None:
                self._tell(self._observer.saved, profile)

    def _tell(self, listener: Callable[[T], None], news: T) -> None:
        began = perf_counter()
        try:
            listener(news)
        except Exception as error:
            self._observer = None
            raise ObserverError from error
        finally:
            self.output_s += perf_counter() - began
