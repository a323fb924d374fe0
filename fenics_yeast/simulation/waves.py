"""Whether a state of a run is unstable to perturbations with waves around the axis."""

from collections.abc import Iterator, Sequence
from math import ceil

import numpy as np

from ..mechanics import Shell
from ..scene import LinearWall, Scene
from ..solve import WaveModes
from .falling_mode import falling_mode
from .recorder import Recorder

_UNCHANGED = 0.02  # change of the volume at constant turgor, up to which none is examined again
_BEYOND = 1.2  # waves that are looked at, over those of the shortest buckles


class WaveCheck:
    """Finds the smallest number of waves with a falling direction; a context manager.

    A wall in tension everywhere is not examined: on a membrane under tensions `N1, N2` in
    equilibrium with a pressure, perturbations stretch the surface, and the second variation is
    positive but for its rotation with the surface. Otherwise all numbers of waves are examined up
    to that of the shortest buckles. The second variation is compiled when it is first needed.

    Walls with a free edge, on whose opening pressure has no potential, and those of a user's own
    law, which may not be isotropic, are examined for axisymmetric perturbations only.
    A closed cell under a force is examined from two waves on.
    """

    def __init__(self, scene: Scene, shell: Shell, recorder: Recorder, isotropic: bool) -> None:
        self._shell, self._recorder = shell, recorder
        self._most = most_waves(scene) if isotropic and "free" not in scene.cell.ends else 0
        # A force on a closed cell would tilt it about the point on which it rests.
        self._least = 2 if scene.axial_load is not None and scene.cell.closed else 1
        self._modes: WaveModes | None = None

    def __enter__(self) -> "WaveCheck":
        return self

    def __exit__(self, *error: object) -> None:
        if self._modes is not None:
            self._modes.__exit__(*error)

    def due(self) -> bool:
        """Whether to examine the trial state: at constant turgor, every 2 % of the volume."""
        return self._recorder.differs(_UNCHANGED) or bool(self._recorder.bifurcation)

    def first(self) -> int | None:
        """Return the smallest number of waves >= 1 of a falling direction in the trial state."""
        return next(self.falling(), None)

    def falling(self, numbers: Sequence[int] | None = None) -> Iterator[int]:
        """Yield those of some numbers of waves >= 1, or of all, that fall in the trial state."""
        if self._most == 0 or self._recorder.measurements.in_tension():
            return
        every = range(self._least, self._most + 1)
        yield from self._compiled().falling(every if numbers is None else numbers)

    def keep_mode(self) -> None:
        """Record the mode of the first bifurcation if the trial state is at it."""
        recorder = self._recorder
        if not recorder.bifurcation or recorder.mode is not None:
            return
        row, waves = recorder.bifurcation
        if waves > 0 and len(recorder.rows) - row <= 2:
            recorder.mode = falling_mode(self._shell, self._compiled().variation, waves)

    def _compiled(self) -> WaveModes:
        if self._modes is None:
            self._modes = WaveModes(self._shell)
        return self._modes


def most_waves(scene: Scene) -> int:
    """Return the number of waves beyond which no wall of a scene buckles first.

    The shortest buckles of a cylinder under axial load and of a sphere under external pressure have
    the wavelength `2π √(R h) / (12 (1 - ν²))^¼` (Timoshenko and Gere, Theory of Elastic Stability,
    1961, chapter 11), of which `r / √(R h) (12 (1 - ν²))^¼` fit around the largest circle, of
    radius r.
    """
    wall = scene.wall
    poisson = wall.poisson_ratio if isinstance(wall, LinearWall) else 0.5
    curve = scene.cell.curve
    largest = float(curve.radius(np.linspace(0, curve.length, 101)).max())
    length = (scene.cell.radius * min(wall.thicknesses)) ** 0.5
    return ceil(_BEYOND * largest / length * (12 * (1 - poisson**2)) ** 0.25)
