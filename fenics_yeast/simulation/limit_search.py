"""How a wall loses its equilibrium in time: by growth, or under a changing pressure."""

from collections.abc import Callable, Generator

from ..scene import SHARES, Scene
from ..solve import (
    Equilibrium,
    PathError,
    TimeStepper,
    approach_limit_point,
    find_limit_pressure,
)
from .blow_up import blow_up_time
from .history import Row
from .outcome import (
    Outcome,
    growth_limit_reached,
    growth_unbounded,
    limit_pressure_exceeded,
    wall_thinned,
)
from .recorder import Recorder

_JUMP, _JUMP_RATIO = 0.1, 5.0  # change of the volume, and its ratio to that of the last step


class LimitSearch:
    """Looks for a limit point between the accepted state and a time that no step reaches.

    Parameters
    ----------
    scene, stepper, equilibrium, recorder
        The scene, the wall in time, its solver, and the rows so far.
    tolerance
        Norm of the residual in µN that counts as zero.
    record
        Records an accepted state, from Newton iterations and the length of its step in min.
    """

    def __init__(
        self,
        scene: Scene,
        stepper: TimeStepper,
        equilibrium: Equilibrium,
        recorder: Recorder,
        tolerance: float,
        record: Callable[[int, float], Row],
    ) -> None:
        self._scene, self._stepper, self._equilibrium = scene, stepper, equilibrium
        self._recorder, self._tolerance, self._record = recorder, tolerance, record

    @property
    def _time(self) -> float:
        return self._stepper.accepted.time

    def thinned(self) -> Outcome | None:
        """Return the end of a run at a wall that has almost no thickness left."""
        ratio = self._recorder.least_thickness(self._scene.wall)
        where = f"at {self._time:g} min" if self._time else "under the initial loads"
        return None if ratio is None else wall_thinned(ratio, where)

    def jumped(self) -> bool:
        """Whether the trial has a much larger change of volume than its change of pressure.

        Such a state lies beyond a limit point, on another part of the equilibrium path.
        """
        rows, shell = self._recorder.rows, self._stepper.shell
        last, before = rows[-1], rows[max(0, len(rows) - 2)]
        slope = last.pressure_MPa - before.pressure_MPa
        change = shell.volume() - last.volume_um3
        if slope == 0 or abs(change) < _JUMP * shell.reference_volume:
            return False
        part = (float(shell.pressure.value) - last.pressure_MPa) / slope
        expected = part * (last.volume_um3 - before.volume_um3)
        return part > 0 and abs(change) > _JUMP_RATIO * abs(expected)

    def find(self, end: float) -> Generator[Row, None, Outcome | None]:
        """Return how the wall loses its equilibrium on the way to a time; None if it does not."""
        search = self._find(end)
        while True:
            try:
                yield next(search)
            except StopIteration as stop:
                found: Outcome | None = stop.value
                return found
            lost, infinite = self.thinned(), blow_up_time(self._recorder.rows)
            if lost is None and infinite is not None and infinite < end:
                lost = growth_unbounded(infinite, self._recorder.rows[-1])
            if lost is not None:
                search.close()
                return lost

    def _find(self, end: float) -> Generator[Row, None, Outcome | None]:
        """Return the same, however thin the wall becomes."""
        if self._stepper.shell.growth is not None and (yield from self._meets_growth_limit(end)):
            rows = self._recorder.rows
            infinite = blow_up_time(rows, broken_off=True)
            return self._lost(end) if infinite is None else growth_unbounded(infinite, rows[-1])
        start, pressure = self._time, self._stepper.pressure
        if abs(pressure(end)) <= abs(pressure(start)) and pressure(end) * pressure(start) > 0:
            return None  # a load that does not rise exceeds no limit
        try:
            limit = find_limit_pressure(self._stepper.shell, pressure(end), self._tolerance)
        except PathError:
            limit = None
        if limit is None:
            self._stepper.reject()
            return None
        part = (limit.pressure - pressure(start)) / (pressure(end) - pressure(start))
        if part < 0:  # that of another part of the path
            self._stepper.reject()
            return None
        time = start + part * (end - start)
        if time > start:
            self._stepper.accept(time)
            yield self._record(limit.iterations, time - start)
        else:
            self._stepper.reject()
        return limit_pressure_exceeded(limit.pressure, time)

    def _meets_growth_limit(self, end: float) -> Generator[Row, None, bool]:
        """Whether a growing wall loses its equilibrium on the way to a time, followed by volume."""
        rate = self._volume_rate(end)
        if rate == 0:
            return False
        found, iterations = yield from approach_limit_point(
            self._stepper,
            self._tolerance,
            SHARES.steps * self._scene.numerics.tolerance,
            rate,
            end,
            self._record,
        )
        self._stepper.reset_predictor()
        self._recorder.iterations += iterations
        return found

    def _volume_rate(self, end: float) -> float:
        """Rate of the volume in µm³/min: that of the last step, and what the pressure changes."""
        rows = self._recorder.rows
        last, before = rows[-1], rows[max(0, len(rows) - 2)]
        rate, slope = 0.0, self._slope(end)
        if last.step_min > 0:
            rate = (last.volume_um3 - before.volume_um3) / last.step_min
            slope -= (last.pressure_MPa - before.pressure_MPa) / last.step_min
        return rate + self._equilibrium.compliance() * slope if slope else rate

    def _slope(self, end: float) -> float:
        """Rate of the pressure in MPa/min from now to a time before the next kink."""
        pressure = self._stepper.pressure
        return (pressure(end) - pressure(self._time)) / (end - self._time)

    def _lost(self, end: float) -> Outcome:
        """Which of growth and pressure has brought a growing wall to its limit point."""
        last, growth_time = self._recorder.rows[-1], self._scene.growth_time
        if growth_time is not None and self._slope(end) * growth_time / last.pressure_MPa > 1:
            return limit_pressure_exceeded(last.pressure_MPa, last.time_min)
        return growth_limit_reached(last, self._scene.wall.energy_per == "reference")
