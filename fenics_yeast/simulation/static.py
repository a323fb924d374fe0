"""Runs of scenes with a table `[path]`: follow the path and report how it ends."""

from collections.abc import Generator
from contextlib import ExitStack
from typing import Any, Self

from ..mechanics import Shell
from ..scene import PressureTable, Scene, StaticPath
from ..solve import (
    Equilibrium,
    EquilibriumError,
    PathCoordinates,
    PathError,
    PathTarget,
    Stability,
    find_limit_pressure,
    follow_path,
)
from .bifurcation import FallingModes, point_before
from .error_estimate import estimate_error
from .history import Row
from .loading import force_coordinates
from .outcome import (
    Outcome,
    limit_force_exceeded,
    limit_pressure_exceeded,
    stopped_at_bifurcation,
    stopped_at_contact,
    wall_folded,
    wall_softened,
    wall_thinned,
)
from .recorder import Recorder
from .result import ErrorEstimate
from .scales import pressure_scale
from .waves import WaveCheck

_AHEAD = 1.2  # pressure up to which a limit is looked for, over the last one


class Static:
    """A run of a scene along its equilibrium path; a context manager.

    `tolerance` is the norm of the residual in µN that counts as zero, `isotropic` says that the law
    is the scene's.
    """

    checkpoint = None  # a path is not resumed

    def __init__(
        self,
        scene: Scene,
        path: StaticPath,
        shell: Shell,
        recorder: Recorder,
        tolerance: float,
        isotropic: bool,
    ) -> None:
        self._scene, self._path, self._shell = scene, path, shell
        self._recorder, self._tolerance = recorder, tolerance
        self._resources = ExitStack()
        self._stability = self._resources.enter_context(Stability(shell))
        self._waves = self._resources.enter_context(WaveCheck(scene, shell, recorder, isotropic))
        self._load: Any = None
        self._last = (shell.state(), 0.0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._resources.close()

    def run(self) -> Generator[Row, None, Outcome]:
        """Follow the path from the unloaded wall; yield the row of each point."""
        path, shell = self._path, self._shell
        coordinates, target = self._coordinates()
        self._load = coordinates.load
        if (lost := self._preload(coordinates)) is not None:
            return lost
        yield self._accept(0, self._falling_waves())
        closed = self._scene.cell.closed
        points = follow_path(
            shell, coordinates, path.control, target, path.steps, self._tolerance, closed
        )
        try:
            for iterations in points:
                waves = self._falling_waves()
                if (before := self._stop_at_bifurcation(waves)) is not None:
                    yield before
                if path.stop_at_bifurcation and self._recorder.bifurcation:
                    self._recorder.save()
                    return stopped_at_bifurcation(self._recorder.bifurcation[1])
                yield (row := self._accept(iterations, waves))
                if (thin := self._recorder.least_thickness(self._scene.wall)) is not None:
                    self._recorder.save()
                    return wall_thinned(thin, f"at {self._describe(row)}")
                if path.stop_at_contact and self._recorder.contact is not None:
                    self._recorder.save()
                    return stopped_at_contact(row)
        except PathError as error:
            return self._ended(error)
        self._recorder.save()
        extreme, last = self._extreme(), self._recorder.rows[-1]
        limit = "" if extreme is None else f", past a limit point at {self._describe(extreme)}"
        return Outcome("finished", f"reached {self._describe(last)}{limit}")

    def _accept(self, iterations: int, waves: int | None) -> Row:
        row = self._recorder.accept(0.0, 0.0, iterations, waves)
        self._waves.keep_mode()
        self._last = (self._shell.state(), float(self._load.value))
        return row

    def _falling_waves(self) -> int | None:
        """Return the smallest number of waves of a falling direction; None if stable."""
        return self._waves.first() if self._stability.negative_modes() == 0 else 0

    def _stop_at_bifurcation(self, waves: int | None) -> Row | None:
        """Record the point just before the first bifurcation, if the trial state has passed it."""
        recorder, shell, load = self._recorder, self._shell, self._load
        if waves is None or recorder.bifurcation or not recorder.rows[-1].stable:
            return None
        here, row = (shell.state(), float(load.value)), None
        falling = FallingModes(self._waves, lambda: self._stability.negative_modes() > 0)
        iterations, found = point_before(
            shell, self._coordinates()[0], falling, self._last, self._tolerance
        )
        recorder.iterations += iterations
        if found:
            row = self._accept(0, None)
        recorder.pass_bifurcation(falling.waves)
        self._waves.keep_mode()
        shell.restore(here[0])
        load.value = here[1]
        return row

    def _coordinates(self) -> tuple[PathCoordinates, PathTarget]:
        """Return load and conjugate amount of the path with their scales, and its target."""
        until, scene, shell = self._path.until, self._scene, self._shell
        if until.of_load:
            of_force = force_coordinates(scene, shell.force)
            if until.displacement is not None:
                return of_force, PathTarget(0, until.displacement / of_force.conjugate_unit)
            return of_force, PathTarget(1, (until.force or 0.0) / of_force.load_unit)
        volume_0, unit = shell.reference_volume, pressure_scale(scene)
        of_pressure = PathCoordinates(shell.pressure, volume_0, unit)
        if until.volume_ratio is not None:
            return of_pressure, PathTarget(0, until.volume_ratio)
        return of_pressure, PathTarget(1, (until.pressure or 0.0) / of_pressure.load_unit)

    def _preload(self, coordinates: PathCoordinates) -> Outcome | None:
        """Find the equilibrium under the load that is constant along the path."""
        shell, scene = self._shell, self._scene
        if coordinates.load is shell.pressure:
            if shell.force is None or scene.axial_load is None or scene.axial_load.force == 0:
                return None
            shell.force.value = scene.axial_load.force
        else:
            assert shell.force is not None and not isinstance(scene.turgor.pressure, PressureTable)
            shell.force.value = 0.0
            if scene.turgor.pressure == 0:
                return None
            shell.pressure.value = scene.turgor.pressure
        try:
            with Equilibrium(shell, self._tolerance) as equilibrium:
                equilibrium.solve()
        except EquilibriumError as error:
            return Outcome("failed", f"no convergence under the constant load: {error}")
        if coordinates.load is not shell.pressure:
            shell.force.begin()
        return None

    def estimate_error(self) -> ErrorEstimate:
        """Return the estimated error of V/V0 along the path."""
        return estimate_error(self._scene, 0.0, 0.0)

    # --- ends -----------------------------------------------------------------------------

    def _ended(self, error: PathError) -> Outcome:
        """Distinguish a limit point of the controlled load from a lost path."""
        path, rows, extreme = self._path, self._recorder.rows, self._extreme()
        if extreme is not None:  # a limit is one on the way to the target
            pressure, force = path.until.pressure, path.until.force
            if pressure is not None and pressure * extreme.pressure_MPa > 0:
                return limit_pressure_exceeded(extreme.pressure_MPa)
            if force is not None and force * extreme.force_uN > 0:
                return limit_force_exceeded(extreme.force_uN)
        if path.control == "pressure":
            # Steps become ever shorter towards a limit point, which is not far ahead then.
            sought = path.until.pressure or _AHEAD * rows[-1].pressure_MPa
            try:
                limit = find_limit_pressure(self._shell, sought, self._tolerance)
            except PathError:
                limit = None
            if limit is not None:
                self._accept(limit.iterations, self._waves.first())
                return limit_pressure_exceeded(limit.pressure)
        where, stretch = self._describe(rows[-1]), self._recorder.softest_stretch(self._scene.wall)
        if stretch is not None:
            return wall_softened(stretch, where)
        if (folded := self._recorder.sharpest_stretch()) is not None:
            return wall_folded(folded, where)
        touched = self._recorder.contact is not None
        through = "; the wall has touched itself before" if touched else ""
        return Outcome("failed", f"the path could not be followed beyond {where}: {error}{through}")

    def _extreme(self) -> Row | None:
        """Return the point of largest absolute load, if the path continued beyond it."""
        rows = self._recorder.rows
        of_load = self._path.until.of_load
        extreme = max(rows, key=lambda row: abs(row.force_uN if of_load else row.pressure_MPa))
        return None if extreme is rows[-1] else extreme

    def _describe(self, row: Row) -> str:
        if self._path.until.of_load:
            return f"{row.force_uN:.6g} µN at {row.displacement_um:.6g} µm"
        return f"{row.pressure_MPa:.6g} MPa at V/V0 = {row.volume_ratio:.6g}"
