"""Record the accepted states and saved profiles of a run."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from math import floor, inf, log
from time import perf_counter

from .. import _dolfinx as dx
from ..mechanics import Shell, ShellState
from ..scene import AnyWall, LinearWall
from ..solve import ForwardSensitivities
from .buckling_mode import BucklingMode
from .history import Digest, Row
from .measurements import Measurements
from .profiles import Profile
from .sensitivity_recorder import SensitivityRecorder
from .softening import least_thickness, sharpest_stretch, softest_stretch

_MOVED = 5e-3  # of the volume at constant turgor, after which the wall may touch itself


@dataclass(frozen=True)
class RecorderState:
    """Numbers of rows, profiles, rejected steps and Newton iterations.

    `saved` says whether the last profile is that of the last row, `contact` is the number of the
    first row in which the wall touches itself, `digest` that of all rows; `bifurcation` has the
    number of the last row before the first bifurcation, and the waves of the mode beyond it;
    `mode` is that mode if it is known.
    """

    rows: int
    profiles: int
    saved: bool
    rejected: int
    iterations: int
    contact: int | None
    digest: str
    bifurcation: tuple[int, ...]
    mode: BucklingMode | None


class Recorder:
    """Records accepted states and profiles of a shell; its methods are collective.

    `rows` and `profiles` are complete on rank 0; other ranks have only the rows. `news` has those
    that have not been published yet. `contact`, `bifurcation` and `mode` are as in `RecorderState`.
    `sensitivities` records the derivatives of each row, if they are requested.
    """

    def __init__(self, shell: Shell) -> None:
        self._shell, self.measurements = shell, Measurements(shell)
        self._accepted: tuple[ShellState, float] | None = None
        self._saved = True
        self.rows: list[Row] = []
        self.profiles: list[Profile] = []
        self.news: deque[Row | Profile | None] = deque()
        self.rejected = self.iterations = 0
        self.contact: int | None = None
        self.bifurcation: tuple[int, ...] = ()
        self.mode: BucklingMode | None = None
        self._digest = Digest()
        self.output_s = 0.0
        self.sensitivities: SensitivityRecorder | None = None

    @property
    def follower(self) -> ForwardSensitivities | None:
        """What follows the steps of the shell."""
        return None if self.sensitivities is None else self.sensitivities.follower

    def state(self) -> RecorderState:
        """Return how much has been recorded."""
        counts = len(self.rows), len(self.profiles), self._saved
        return RecorderState(
            *counts, self.rejected, self.iterations, self.contact, self._digest.text,
            self.bifurcation, self.mode,
        )  # fmt: skip

    def restore(
        self, state: RecorderState, rows: Iterable[Row], profiles: Iterable[Profile]
    ) -> None:
        """Continue the records of an earlier run, the shell being in its last accepted state."""
        self.rows, self.profiles = list(rows), list(profiles)
        self.rejected, self.iterations = state.rejected, state.iterations
        self._accepted = (self._shell.state(), float(self._shell.pressure.value))
        self._saved, self.contact = state.saved, state.contact
        self.bifurcation, self.mode = state.bifurcation, state.mode
        self._digest = Digest(self.rows)

    def accept(self, time: float, step: float, iterations: int, unstable: int | None) -> Row:
        """Record the shell's state as accepted, at a time in min after a step of some length.

        `unstable` is the smallest number of waves with a falling direction, if there is one.
        """
        shell, sizes = self._shell, self.measurements.sizes()
        self.iterations += iterations
        volume, pressure = shell.volume(), float(shell.pressure.value)
        row = Row(
            time_min=time,
            pressure_MPa=pressure,
            volume_um3=volume,
            volume_ratio=volume / shell.reference_volume,
            pole_height_um=sizes.pole_height,
            bud_radius_um=sizes.bud_radius,
            neck_radius_um=sizes.neck_radius,
            max_growth_strain=sizes.max_growth_strain,
            dissipation_rate=shell.dissipation_rate(),
            step_min=step,
            newton_iterations=iterations,
            stable=unstable is None,
            force_uN=0.0 if shell.force is None else shell.force.value,
            displacement_um=0.0 if shell.force is None else shell.force.displacement(),
            unstable_waves=unstable,
        )
        self._accepted, self._saved = (shell.state(), pressure), False
        if self.contact is None and self.differs(_MOVED) and self.in_contact():
            self.contact = len(self.rows)
        if unstable is not None:
            self.pass_bifurcation(unstable)
        if self.sensitivities is not None:
            self.sensitivities.record(time)
        self.rows.append(row)
        self._digest.add(row)
        self.news.append(row)
        return row

    def reject(self, iterations: int) -> None:
        """Count a rejected step."""
        self.rejected += 1
        self.iterations += iterations

    def pass_bifurcation(self, waves: int) -> None:
        """Note that beyond the last row a mode with a number of waves falls, if it is the first."""
        if not self.bifurcation:
            self.bifurcation = (max(0, len(self.rows) - 1), waves)

    def differs(self, part: float) -> bool:
        """Whether the trial state is not near the last row: in turgor, or in volume by a part.

        This depends only on the last row, so that a resumed run looks at the same states.
        """
        pressure = float(self._shell.pressure.value)
        if not self.rows or pressure <= 0 or pressure != self.rows[-1].pressure_MPa:
            return True
        volumes = self.rows[-1].volume_um3, self._shell.volume()
        if min(volumes) <= 0:
            return True
        before, now = (floor(log(volume) / log(1 + part)) for volume in volumes)
        return before != now

    def in_contact(self) -> bool:
        """Whether the wall touches itself in the trial state."""
        return self.measurements.in_contact()

    def softest_stretch(self, wall: AnyWall) -> float | None:
        """Return the least stretch, in the trial state, at which the wall has no stiffness."""
        if not isinstance(wall, LinearWall):
            return None
        return self._least(softest_stretch(wall, self.measurements.elastic_strain()))

    def sharpest_stretch(self) -> float | None:
        """Return the least stretch, in the trial state, of a wall that is folded too sharply."""
        if not self._shell.bending:
            return None
        return self._least(sharpest_stretch(self.measurements.strain()))

    def least_thickness(self, wall: AnyWall) -> float | None:
        """Return the thickness ratio, in the trial state, of a wall that has thinned away."""
        if not isinstance(wall, LinearWall) or wall.thickness_change == "none":
            return None
        return self._least(least_thickness(wall, self.measurements.elastic_strain()))

    def _least(self, here: float | None) -> float | None:
        """Return the least value of all ranks that have one."""
        least = self._shell.comm.allreduce(inf if here is None else here, op=dx.MPI.MIN)
        return least if least < inf else None

    def save(self) -> None:
        """Record the profile of the accepted state, unless it is recorded."""
        if self._accepted is None or self._saved:
            return
        began = perf_counter()
        state, pressure = self._accepted
        self._shell.restore(state)
        self._shell.pressure.value = pressure
        self._saved = True
        profile = self.measurements.profile(self.rows[-1].time_min)
        self.output_s += perf_counter() - began
        if profile is not None:
            self.profiles.append(profile)
        self.news.append(profile)
