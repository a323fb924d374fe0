"""Results of a run: history, profiles, status, errors and timings."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, Protocol

from ..geometry import Array
from . import tables
from .buckling_mode import BucklingMode
from .history import History, Row
from .profiles import Profile, Profiles
from .sensitivities import Sensitivities

Status = Literal["finished", "no-equilibrium", "unbounded", "failed", "interrupted"]

EXIT_STATUS: dict[Status, int] = {
    "finished": 0,
    "no-equilibrium": 3,
    "unbounded": 3,
    "failed": 4,
    "interrupted": 130,
}
"""Exit status of a process, by how its run ended."""

ANSWERS: tuple[Status, ...] = ("finished", "no-equilibrium", "unbounded")
"""Statuses of a run that has its answer, and would give the same one again."""


@dataclass(frozen=True)
class Timings:
    """Seconds spent; `loop_s` is time stepping only, without output."""

    import_s: float = 0.0
    setup_s: float = 0.0
    compile_s: float = 0.0
    loop_s: float = 0.0
    output_s: float = 0.0
    total_s: float = 0.0

    def __add__(self, other: Timings) -> Timings:
        """Return the sums, for a run in several parts."""
        names = [field.name for field in fields(self)]
        return Timings(*(getattr(self, name) + getattr(other, name) for name in names))


@dataclass(frozen=True)
class ErrorBars:
    """Estimated errors of V/V0 at the saved times that a run has reached.

    Attributes
    ----------
    time_min
        The times in min, shape ``(n,)``.
    time_steps, mesh, thickness_points, shear_penalty
        Parts of the error, at least 0, shape ``(n,)``; not a number where the refined run did
        not reach the time.
    message
        Which refined runs ended early, and why; empty if none did.
    """

    time_min: Array
    time_steps: Array
    mesh: Array
    thickness_points: Array
    shear_penalty: Array
    message: str = ""

    @property
    def total(self) -> Array:
        """Sum of the parts, shape ``(n,)``."""
        return self.time_steps + self.mesh + self.thickness_points + self.shear_penalty

    def columns(self) -> dict[str, Array]:
        """Return times, parts and total by name."""
        names = [field.name for field in fields(self) if field.name != "message"]
        return {**{name: getattr(self, name) for name in names}, "total": self.total}


@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated relative error of V/V0: the largest of the saved times.

    Attributes
    ----------
    steps
        By the time steps, from the estimates of each.
    mesh, thickness_points, shear_penalty
        Bounds of what was measured on growing buds.
    """

    steps: float
    mesh: float
    thickness_points: float
    shear_penalty: float

    @property
    def total(self) -> float:
        """Sum of the parts."""
        return self.steps + self.mesh + self.thickness_points + self.shear_penalty


@dataclass(frozen=True)
class Bifurcation:
    """The first equilibrium beyond which a mode falls: the last stable row.

    Attributes
    ----------
    waves
        Number of waves of the mode around the axis; 0 if it is axisymmetric.
    step
        Number of the row in the history, from 0.
    time_min, pressure_MPa, volume_ratio, force_uN, displacement_um
        Its values there.
    control, control_value
        What is prescribed from row to row, and its value: "time", or the control of a path.
    """

    waves: int
    step: int
    time_min: float
    pressure_MPa: float
    volume_ratio: float
    force_uN: float
    displacement_um: float
    control: str
    control_value: float | None

    @classmethod
    def at(cls, row: Row, step: int, waves: int, control: str = "time") -> Bifurcation:
        """Return the bifurcation after a row of a run, with a control of `[path]` or time."""
        values = {
            "time": row.time_min,
            "pressure": row.pressure_MPa,
            "volume": row.volume_ratio,
            "force": row.force_uN,
            "displacement": row.displacement_um,
        }
        loads = row.pressure_MPa, row.volume_ratio, row.force_uN, row.displacement_um
        return cls(waves, step, row.time_min, *loads, control, values.get(control))


@dataclass(frozen=True)
class UnloadedShape:
    """How well the unloaded shape fits that was found for the outline of a turgid cell.

    Attributes
    ----------
    residual_distance_um
        Largest distance between the inflated shape and the outline.
    largest_displacement_um
        Largest distance between points of the outline and their unloaded places.
    """

    residual_distance_um: float
    largest_displacement_um: float


@dataclass(frozen=True)
class Result:
    """What a simulation found.

    Attributes
    ----------
    history, profiles
        Accepted states and profiles at the saved times; after an early end also the profile of
        the last accepted state.
    status, message
        How it ended: a status word and a sentence.
    end_time
        Time in min of the last accepted state or, without bound, at which V becomes infinite.
    dofs, steps, rejected_steps, newton_iterations
        Number of DOFs, of accepted and rejected steps, and of Newton iterations of all steps.
    timings
        Where the time went.
    error_estimate
        Estimated error of V/V0; None if the run broke off outside of its steps.
    warnings
        What must be known about a run even if it ended well.
    error_bars
        Errors of V/V0 by refined runs, if they were requested.
    bifurcation
        Where the first equilibrium is unstable; None if all are stable.
    mode
        The mode that falls there; None if it is unknown.
    sensitivities
        Derivatives of the history by parameters, if they were requested.
    unloaded
        How well the unloaded shape of a turgid outline fits; None for any other cell.
    """

    history: History
    profiles: Profiles
    status: Status
    message: str
    end_time: float
    dofs: int
    steps: int
    rejected_steps: int
    newton_iterations: int
    timings: Timings
    error_estimate: ErrorEstimate | None = None
    warnings: tuple[str, ...] = ()
    error_bars: ErrorBars | None = None
    bifurcation: Bifurcation | None = None
    mode: BucklingMode | None = None
    sensitivities: Sensitivities | None = None
    unloaded: UnloadedShape | None = None

    def __repr__(self) -> str:
        return (
            f"Result({self.status}: {self.message}; {self.steps} steps, "
            f"{self.newton_iterations} Newton iterations, {self.timings.loop_s:.2g} s)"
        )

    def _repr_html_(self) -> str | None:
        rows = self.history.rows
        times = {profile.time for profile in self.profiles}
        saved = [row for row in rows if row.time_min in times] if len(times) > 1 else rows
        return tables.html(History(saved), repr(self))


class Observer(Protocol):
    """Interface notified of run events, on rank 0 only."""

    def accepted(self, row: Row) -> None:
        """Receive the row of an accepted state."""

    def saved(self, profile: Profile) -> None:
        """Receive the profile of a saved time."""
