"""Whether a state of a run is unstable to perturbations with waves around the axis."""

from collections.abc import Callable, Iterator, Sequence
from math import ceil

from ..mechanics import Shell
from ..scene import LinearWall, Scene
from ..solve import WaveModes
from .falling_mode import falling_mode
from .recorder import Recorder

_UNCHANGED = 0.02  # change of the volume at constant turgor, up to which none is examined again
# Waves that are examined, over those that a wall at rest could have: stretch changes its stiffness.
_BEYOND, _LEAST_MOST = 1.2, 4
_ALL, _RATIO = 16, 1.08  # up to which number all are examined, and the ratio of those beyond


class WaveCheck:
    """Finds the smallest number of waves with a falling direction; a context manager.

    A wall in tension everywhere is not examined: on a membrane under tensions `N1, N2` in
    equilibrium with a pressure, perturbations stretch the surface, and the second variation is
    positive but for its rotation with the surface. Otherwise those numbers of waves are examined
    that its compression can bend. The second variation is compiled when it is first needed.

    A mode with n waves at radius r and any wavelength along the meridian has the bending energy
    `D q²` with `q >= n²/r²`, and a resultant `-N` releases at most `N q`: it may fall only if
    `n < r √(N/D)` somewhere.

    Walls with a free edge, on whose opening pressure has no potential, and those of a user's own
    law, which may not be isotropic, are examined for axisymmetric perturbations only.
    A closed cell under a force is examined from two waves on.
    """

    def __init__(self, scene: Scene, shell: Shell, recorder: Recorder, isotropic: bool) -> None:
        self._shell, self._recorder = shell, recorder
        self._examined = isotropic and "free" not in scene.cell.ends
        self._stiffness = _bending_stiffness(scene)
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
        """Return a number of waves >= 1 of a falling direction in the trial state, the smallest.

        Of many waves some numbers are left out: neighbours fall at almost the same load.
        """
        return next(self._fall(_sparse), None)

    def falling(self, numbers: Sequence[int] | None = None) -> Iterator[int]:
        """Yield those of some numbers of waves >= 1, or of all, that fall in the trial state."""
        return self._fall(lambda every: every if numbers is None else numbers)

    def _fall(self, choose: Callable[[Sequence[int]], Sequence[int]]) -> Iterator[int]:
        """Yield those that fall of the numbers chosen from all that may."""
        compression = self._recorder.measurements.compression() if self._examined else 0.0
        if compression == 0:
            return
        most = ceil(_BEYOND * compression / self._stiffness**0.5)
        every = range(self._least, max(most, _LEAST_MOST) + 1)
        yield from self._compiled().falling(choose(every))

    def keep_mode(self) -> None:
        """Record the mode of the first bifurcation if the trial state is at it."""
        recorder = self._recorder
        if not recorder.bifurcation or recorder.mode is not None:
            return
        row, waves = recorder.bifurcation
        if not recorder.rows[row].stable or len(recorder.rows) - row > 2:
            return
        variation = self._compiled().variation if waves > 0 else None
        recorder.mode = falling_mode(self._shell, variation, waves)

    def _compiled(self) -> WaveModes:
        if self._modes is None:
            self._modes = WaveModes(self._shell)
        return self._modes


def _sparse(numbers: Sequence[int]) -> list[int]:
    """Return all numbers up to 16, and then one in about 8 %."""
    chosen: list[int] = []
    for n in numbers:
        if n <= _ALL or n >= _RATIO * chosen[-1]:
            chosen.append(n)
    return chosen


def _bending_stiffness(scene: Scene) -> float:
    """Return the least `E h³ / (12 (1 - ν²))` of a scene's wall in µN µm."""
    wall = scene.wall
    poisson = wall.poisson_ratio if isinstance(wall, LinearWall) else 0.5
    mu = wall.shear_modulus
    factors = [zone.modulus_factor or (zone.shear_modulus or mu) / mu for zone in wall.zone]
    young = 2 * (1 + poisson) * mu * min([1.0, *factors])
    return young * min(wall.thicknesses) ** 3 / (12 * (1 - poisson**2))
