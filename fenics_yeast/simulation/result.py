"""What a run leaves behind: rows of the history, profiles at the saved times, the outcome."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Status = Literal["finished", "no-equilibrium", "failed", "interrupted"]


@dataclass(frozen=True)
class Row:
    """One accepted state of the history; the names carry the units.

    Where nothing grows, the radii of bud and neck are 0. A state is `stable` if no small
    axisymmetric perturbation at its growth and loads would move it away. Force and displacement
    are those of the table `[load]`, 0 without it.
    """

    time_min: float
    pressure_MPa: float
    volume_um3: float
    volume_ratio: float
    pole_height_um: float
    bud_radius_um: float
    neck_radius_um: float
    max_growth_strain: float
    dissipation_rate: float
    step_min: float
    newton_iterations: int
    stable: bool
    force_uN: float = 0.0
    displacement_um: float = 0.0


COLUMNS = tuple(field.name for field in fields(Row))


class History:
    """The accepted states of a run, a NumPy array for each column of `Row`.

    ``history.volume_ratio`` is the array of all rows; ``history.at(90)`` is the row at 90 min.
    """

    time_min: Array
    pressure_MPa: Array
    volume_um3: Array
    volume_ratio: Array
    pole_height_um: Array
    bud_radius_um: Array
    neck_radius_um: Array
    max_growth_strain: Array
    dissipation_rate: Array
    step_min: Array
    newton_iterations: NDArray[np.int64]
    stable: NDArray[np.bool_]
    force_uN: Array
    displacement_um: Array

    def __init__(self, rows: Iterable[Row]) -> None:
        self.rows: Sequence[Row] = tuple(rows)
        for name in COLUMNS:
            setattr(self, name, np.array([getattr(row, name) for row in self.rows]))

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        if not self.rows:
            return "History(empty)"
        last = self.rows[-1]
        return (
            f"History({len(self)} rows, t = {self.rows[0].time_min:g} to {last.time_min:g} min, "
            f"V/V0 = {last.volume_ratio:.6f} at the end)"
        )

    def _repr_html_(self) -> str:
        from . import notebook

        return notebook.history(self)

    def to_frame(self) -> Any:
        """The rows as a pandas `DataFrame`, a column for each of `Row`.

        Raises
        ------
        ImportError
            If there is no pandas, which nothing else here needs.
        """
        try:
            from pandas import DataFrame
        except ImportError:
            raise ImportError("to_frame needs pandas; run: pip install pandas") from None
        return DataFrame({name: getattr(self, name) for name in COLUMNS})

    def at(self, time: float) -> Row:
        """Row at a time in min that the run hit exactly, such as a saved time.

        Raises
        ------
        KeyError
            If no row is at that time.
        """
        for row in reversed(self.rows):
            if abs(row.time_min - time) <= 1e-9 * max(1.0, abs(time)):
                return row
        raise KeyError(f"no accepted step at {time:g} min; add it to run.save")


@dataclass(frozen=True)
class Profile:
    """The wall at one time; µm, MPa, radians.

    Attributes
    ----------
    time
        Time in min.
    S, r, z, psi
        Reference arc length, current radius and height and director angle at the nodes, bottom
        to top, shape ``(nodes,)``.
    S_points, xi
        Arc length of the quadrature points, shape ``(points,)``, and distance from the
        mid-surface of the thickness points, outward positive, shape ``(n,)``.
    strain, stress, growth_strain
        Logarithmic strains, Cauchy stresses and growth strains, meridional and hoop, shape
        ``(points, n, 2)``.
    """

    time: float
    S: Array
    r: Array
    z: Array
    psi: Array
    S_points: Array
    xi: Array
    strain: Array
    stress: Array
    growth_strain: Array


@dataclass(frozen=True)
class Profiles:
    """Profiles of the saved times, in order of time; ``profiles.at(90)`` picks one."""

    all: tuple[Profile, ...]

    def __len__(self) -> int:
        return len(self.all)

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(self.all)

    def __repr__(self) -> str:
        times = ", ".join(f"{profile.time:g}" for profile in self.all)
        return f"Profiles(t = {times} min)" if self.all else "Profiles(empty)"

    def _repr_html_(self) -> str:
        from . import notebook

        return notebook.profiles(self)

    def at(self, time: float) -> Profile:
        """Profile at a saved time in min.

        Raises
        ------
        KeyError
            If that time was not saved.
        """
        for profile in self.all:
            if abs(profile.time - time) <= 1e-9 * max(1.0, abs(time)):
                return profile
        raise KeyError(f"no profile at {time:g} min; add it to run.save")

    def arrays(self) -> dict[str, Array]:
        """Arrays by name, as in ``profiles.npz``; what changes in time has time as first axis."""
        if not self.all:
            return {"time_min": np.zeros(0)}
        first = self.all[0]
        stacked = {
            name: np.stack([getattr(profile, name) for profile in self.all])
            for name in ("r", "z", "psi", "strain", "stress", "growth_strain")
        }
        times = np.array([profile.time for profile in self.all])
        return {"time_min": times, "S": first.S, "S_points": first.S_points, "xi": first.xi,
                **stacked}  # fmt: skip


@dataclass(frozen=True)
class Timings:
    """Seconds spent; `loop_s` is the time stepping alone, without output."""

    import_s: float = 0.0
    setup_s: float = 0.0
    compile_s: float = 0.0
    loop_s: float = 0.0
    output_s: float = 0.0
    total_s: float = 0.0

    def __add__(self, other: Timings) -> Timings:
        """Sum of each of them, for a run in parts."""
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
        Parts of the error, at least 0, shape ``(n,)``; not a number where the refined run has
        not come that far.
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
        """Times, parts and total by name."""
        names = [field.name for field in fields(self) if field.name != "message"]
        return {**{name: getattr(self, name) for name in names}, "total": self.total}


@dataclass(frozen=True)
class Result:
    """What a simulation found.

    Attributes
    ----------
    history, profiles
        Accepted states and profiles at the saved times; after an early end also the profile of
        the last accepted state.
    status, message
        How it ended, and that in a sentence.
    end_time
        Time of the last accepted state in min.
    dofs, steps, rejected_steps, newton_iterations
        Unknowns of the wall; accepted and rejected steps; Newton iterations of all of them.
    timings
        Where the time went.
    error_bars
        Estimated errors of V/V0, where they were asked for.
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
    error_bars: ErrorBars | None = None

    def __repr__(self) -> str:
        return (
            f"Result({self.status}: {self.message}; {self.steps} steps, "
            f"{self.newton_iterations} Newton iterations, {self.timings.loop_s:.2g} s)"
        )

    def _repr_html_(self) -> str:
        from . import notebook

        return notebook.result(self)


class Observer(Protocol):
    """Somebody who is told of a run as it goes, on rank 0 alone."""

    def accepted(self, row: Row) -> None:
        """Take note of an accepted state."""

    def saved(self, profile: Profile) -> None:
        """Take note of the profile of a saved time."""
