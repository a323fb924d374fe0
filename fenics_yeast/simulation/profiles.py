"""Profiles of the wall along its meridian at the saved times of a run."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..geometry import Array, Intervals
from . import tables


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
        mid-surface of the through-thickness integration points, outward positive, shape ``(n,)``.
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
    """Profiles of the saved times, in order of time; ``profiles.at(90)`` picks one.

    Attributes
    ----------
    all
        The profiles.
    zones
        Parts of the meridian of each growing zone, by reference arc length in µm.
    """

    all: tuple[Profile, ...]
    zones: tuple[Intervals, ...] = ()

    def __len__(self) -> int:
        return len(self.all)

    def __iter__(self) -> Iterator[Profile]:
        return iter(self.all)

    def __repr__(self) -> str:
        times = ", ".join(f"{profile.time:g}" for profile in self.all)
        return f"Profiles(t = {times} min)" if self.all else "Profiles(empty)"

    def _repr_html_(self) -> str | None:
        return tables.html(self)

    def to_frame(self) -> Any:
        """Return a pandas `DataFrame` with the extremes of each profile.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return tables.frame(
            {
                "time_min": [wall.time for wall in self.all],
                "height_um": [wall.z[-1] - wall.z[0] for wall in self.all],
                "max_radius_um": [wall.r.max() for wall in self.all],
                "max_stress_MPa": [wall.stress.max() for wall in self.all],
                "max_growth_strain": [wall.growth_strain.max() for wall in self.all],
            }
        )

    def at(self, time: float) -> Profile:
        """Return the profile at a saved time in min.

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
        """Return arrays by name, as in ``profiles.npz``; those that change have time first."""
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
