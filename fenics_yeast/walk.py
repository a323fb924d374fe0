"""A scene with a path: its points one by one, and what ends them."""

from __future__ import annotations

from .journal import Journal
from .outcome import Outcome, overloaded
from .record import Row
from .scene import Scene, StaticPath
from .shell import Shell
from .stability import Stability
from .static_path import Goal, PathError, follow, limit_point


def walk(
    scene: Scene,
    path: StaticPath,
    shell: Shell,
    stability: Stability,
    journal: Journal,
    tolerance: float,
) -> Outcome:
    """Follow the path of a scene from its unloaded wall; a row for each point, at time 0.

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
    goal = Goal(path.until.volume_ratio, path.until.pressure)
    unit = scene.wall.shear_modulus * scene.wall.thickness / scene.cell.radius
    journal.accept(0.0, 0.0, 0, stability.falling() == 0)
    try:
        for iterations in follow(shell, path.control, goal, path.steps, unit, tolerance):
            journal.accept(0.0, 0.0, iterations, stability.falling() == 0)
    except PathError as error:
        return _ended(path, shell, journal, tolerance, error)
    journal.save()
    last, extreme = journal.rows[-1], _extreme(journal.rows)
    limit = ""
    if extreme is not None:
        at = f"{extreme.pressure_MPa:.6g} MPa at V/V0 = {extreme.volume_ratio:.5g}"
        limit = f", past a limit point at {at}"
    reached = f"reached V/V0 = {last.volume_ratio:.6g} at {last.pressure_MPa:.6g} MPa"
    return Outcome("finished", reached + limit)


def _ended(
    path: StaticPath, shell: Shell, journal: Journal, tolerance: float, error: PathError
) -> Outcome:
    """Tell a path that has no further point under its control from one that was lost."""
    extreme = _extreme(journal.rows)
    if extreme is not None and path.until.pressure is not None:
        return overloaded(extreme.pressure_MPa)
    if path.control == "pressure":
        rows = journal.rows
        ahead = 2 * rows[-1].pressure_MPa - rows[max(0, len(rows) - 2)].pressure_MPa
        try:
            limit = limit_point(shell, ahead, tolerance)
        except PathError:
            limit = None
        if limit is not None:
            journal.accept(0.0, 0.0, limit.iterations, True)
            return overloaded(limit.pressure)
    last = journal.rows[-1]
    at = f"V/V0 = {last.volume_ratio:.6g} and {last.pressure_MPa:.6g} MPa"
    return Outcome("failed", f"the path was lost at {at}: {error}")


def _extreme(rows: list[Row]) -> Row | None:
    """Point of the largest pressure, of either sign, if the path came back from it."""
    extreme = max(rows, key=lambda row: abs(row.pressure_MPa))
    return None if extreme is rows[-1] else extreme
