"""A scene with a path: its points one by one, and what ends them."""

from __future__ import annotations

from collections.abc import Generator

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
from .outcome import Outcome, limit_force_reached, limit_pressure_reached
from .recorder import Recorder
from .result import Row


def run_path(
    scene: Scene,
    path: StaticPath,
    shell: Shell,
    stability: Stability,
    recorder: Recorder,
    tolerance: float,
) -> Generator[Row, None, Outcome]:
    """Follow the path of a scene from its unloaded wall; yields a row for each point, at time 0.

    Parameters
    ----------
    scene, path
        What is run, and its path.
    shell, stability
        Its unloaded wall, and the solver that tells which points are stable.
    journal
        Takes note of all points.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    """
    coordinates, target = _plane(scene, path, shell)
    if (lost := _preload(shell, coordinates, scene, tolerance)) is not None:
        return lost
    yield recorder.accept(0.0, 0.0, 0, stability.negative_modes() == 0)
    try:
        for iterations in follow_path(
            shell, coordinates, path.control, target, path.steps, tolerance
        ):
            yield recorder.accept(0.0, 0.0, iterations, stability.negative_modes() == 0)
    except PathError as error:
        return _ended(path, shell, recorder, tolerance, error)
    recorder.save()
    extreme = _extreme(path, recorder.rows)
    limit = "" if extreme is None else f", past a limit point at {_tell(path, extreme)}"
    return Outcome("finished", f"reached {_tell(path, recorder.rows[-1])}{limit}")


def _plane(scene: Scene, path: StaticPath, shell: Shell) -> tuple[PathCoordinates, PathTarget]:
    """The load of a path with the sizes of what it does, and the path's end."""
    until, h, radius = path.until, scene.wall.thickness, scene.cell.radius
    if until.of_load:
        length = (radius * h) ** 0.5
        unit = 8 * scene.wall.shear_modulus * h**2 / radius * length  # about that of a sphere
        coordinates = PathCoordinates(shell.force, length, unit)
        given: tuple[float | None, float | None] = (until.displacement, until.force)
    else:
        unit = scene.wall.shear_modulus * h / radius
        coordinates = PathCoordinates(shell.pressure, shell.reference_volume, unit)
        given = (until.volume_ratio, until.pressure)
        if given[0] is not None:
            return coordinates, PathTarget(0, given[0])
    if given[0] is not None:
        return coordinates, PathTarget(0, given[0] / coordinates.amount_unit)
    return coordinates, PathTarget(1, (given[1] or 0.0) / coordinates.load_unit)


def _preload(
    shell: Shell, coordinates: PathCoordinates, scene: Scene, tolerance: float
) -> Outcome | None:
    """Equilibrium under the load that is held while the other one grows from nothing."""
    if coordinates.load is shell.pressure:
        held, size = shell.force, 0.0 if scene.axial_load is None else scene.axial_load.force
    else:
        assert shell.force is not None and not isinstance(scene.turgor.pressure, PressureTable)
        held, size = shell.pressure, scene.turgor.pressure
        shell.force.value = 0.0
    if held is None or size == 0:
        return None
    held.value = size
    try:
        with Equilibrium(shell, tolerance) as equilibrium:
            equilibrium.solve()
    except EquilibriumError as error:
        return Outcome("failed", f"no equilibrium under the load that is held: {error}")
    if held is shell.pressure and shell.force is not None:
        shell.force.begin()
    return None


def _ended(
    path: StaticPath, shell: Shell, recorder: Recorder, tolerance: float, error: PathError
) -> Outcome:
    """Tell a path that has no further point under its control from one that was lost."""
    rows = recorder.rows
    extreme = _extreme(path, rows)
    if extreme is not None and path.until.pressure is not None:
        return limit_pressure_reached(extreme.pressure_MPa)
    if extreme is not None and path.until.force is not None:
        return limit_force_reached(extreme.force_uN)
    if path.control == "pressure":
        ahead = 2 * rows[-1].pressure_MPa - rows[max(0, len(rows) - 2)].pressure_MPa
        try:
            limit = find_limit_pressure(shell, ahead, tolerance)
        except PathError:
            limit = None
        if limit is not None:
            recorder.accept(0.0, 0.0, limit.iterations, True)
            return limit_pressure_reached(limit.pressure)
    return Outcome("failed", f"the path was lost at {_tell(path, rows[-1])}: {error}")


def _load(path: StaticPath, row: Row) -> float:
    return row.force_uN if path.until.of_load else row.pressure_MPa


def _tell(path: StaticPath, row: Row) -> str:
    """A point of the path in words."""
    if path.until.of_load:
        return f"{row.force_uN:.6g} µN at {row.displacement_um:.6g} µm"
    return f"{row.pressure_MPa:.6g} MPa at V/V0 = {row.volume_ratio:.6g}"


def _extreme(path: StaticPath, rows: list[Row]) -> Row | None:
    """Point of the largest load, of either sign, if the path came back from it."""
    extreme = max(rows, key=lambda row: abs(_load(path, row)))
    return None if extreme is rows[-1] else extreme
