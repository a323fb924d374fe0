"""What a run has found so far, noted as it goes and told to its observers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from time import perf_counter

from ..mechanics import Shell, ShellState
from .measurements import Measurements
from .result import Observer, Profile, Row


class ObserverError(RuntimeError):
    """An observer raised what is this error's cause on rank 0; none is told anything more.

    Raised on all ranks at once.
    """


@dataclass(frozen=True)
class RecorderState:
    """How much has been noted.

    Attributes
    ----------
    rows, profiles
        Number of accepted states and of profiles.
    saved
        Whether the last profile is that of the last row.
    rejected, iterations
        Number of rejected steps; Newton iterations of all steps.
    """

    rows: int
    profiles: int
    saved: bool
    rejected: int
    iterations: int


class Recorder:
    """Accepted states and saved profiles of a run, and what they took.

    Parameters
    ----------
    shell
        The wall, unloaded.
    observers
        Are told of every accepted state and every saved profile, on rank 0 alone.

    Attributes
    ----------
    rows, profiles
        What was accepted and saved so far; profiles on rank 0 alone.
    rejected, iterations
        Number of rejected steps; Newton iterations of all steps.
    output_s
        Seconds spent on profiles and by the observers.
    """

    def __init__(self, shell: Shell, observers: Iterable[Observer] = ()) -> None:
        self._shell, self._measurements = shell, Measurements(shell)
        self._observers = tuple(observers) if shell.comm.rank == 0 else ()
        self._volume_0 = shell.reference_volume
        self._accepted: tuple[ShellState, float] | None = None
        self._saved = True
        self.rows: list[Row] = []
        self.profiles: list[Profile] = []
        self.rejected = self.iterations = 0
        self.output_s = 0.0

    @property
    def volume_0(self) -> float:
        """Volume in µm³ that ratios refer to, that of the unloaded cell."""
        return self._volume_0

    def state(self) -> RecorderState:
        """How much has been noted."""
        counts = len(self.rows), len(self.profiles), self._saved
        return RecorderState(*counts, self.rejected, self.iterations)

    def restore(
        self, state: RecorderState, rows: Iterable[Row], profiles: Iterable[Profile]
    ) -> None:
        """Go on with the notes of an earlier run, the shell being in its last accepted state."""
        self.rows, self.profiles = list(rows), list(profiles)
        self.rejected, self.iterations = state.rejected, state.iterations
        self._accepted = (self._shell.state(), float(self._shell.pressure.value))
        self._saved = state.saved

    def accept(self, time: float, step: float, iterations: int, stable: bool) -> Row:
        """Note the shell's state as accepted, at a time in min after a step of some length."""
        shell, sizes = self._shell, self._measurements.sizes()
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
        self._accepted, self._saved = (shell.state(), pressure), False
        self.rows.append(row)
        self._tell(lambda observer: observer.accepted(row))
        return row

    def reject(self, iterations: int) -> None:
        """Note a rejected step."""
        self.rejected += 1
        self.iterations += iterations

    def count_iterations(self, iterations: int) -> None:
        """Note iterations that were neither an accepted nor a rejected step's."""
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
        profile = self._measurements.profile(self.rows[-1].time_min)
        self.output_s += perf_counter() - began
        if profile is not None:
            self.profiles.append(profile)
        self._tell(lambda observer: observer.saved(self.profiles[-1]))

    def _tell(self, tell: Callable[[Observer], None]) -> None:
        """Tell every observer."""

        def tell_all() -> None:
            for observer in self._observers:
                tell(observer)

        self.on_root(tell_all)

    def on_root(self, act: Callable[[], None]) -> None:
        """Act on rank 0, which counts as output; what it raises there ends the run on all ranks.

        Raises
        ------
        ObserverError
            If it raised an error; the observers are told nothing more.
        KeyboardInterrupt
            If it raised that.
        """
        began = perf_counter()
        problem: BaseException | None = None
        try:
            if self._shell.comm.rank == 0:
                act()
        except KeyboardInterrupt as interrupt:
            problem = interrupt
        except Exception as error:
            self._observers, problem = (), error
        self.output_s += perf_counter() - began
        name, words = (type(problem).__name__, str(problem)) if problem else ("", "")
        if self._shell.comm.size > 1:
            name, words = self._shell.comm.bcast((name, words))
        if name == KeyboardInterrupt.__name__:
            raise KeyboardInterrupt from problem
        if name:
            raise ObserverError(f"{name}: {words}") from problem
