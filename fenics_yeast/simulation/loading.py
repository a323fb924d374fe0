"""The first equilibrium of a wall under large loads: in parts, each towards its limit point."""

from ..scene import Scene
from ..solve import (
    PathCoordinates,
    TimeStepper,
    find_limit_force,
    find_limit_pressure,
)
from .outcome import Outcome, limit_force_exceeded, limit_pressure_exceeded
from .scales import force_scale, length_scale


def force_coordinates(scene: Scene, force: object) -> PathCoordinates:
    """Return the plane of displacement and force of a scene's load."""
    return PathCoordinates(force, length_scale(scene), force_scale(scene))


def load_in_parts(
    scene: Scene, stepper: TimeStepper, tolerance: float
) -> tuple[int, Outcome | None]:
    """Find the equilibrium at time 0: first under pressure, by volume, then under the force.

    So each load that exceeds its limit is named. The force grows by the displacement of its node.

    Returns
    -------
    tuple of int, Outcome
        Newton iterations, and None or how the wall loses its equilibrium.

    Raises
    ------
    EquilibriumError, PathError
        If a part does not converge; the shell is then in the last equilibrium that was found.
    """
    shell, pressure, iterations = stepper.shell, stepper.pressure(0.0), 0
    force = 0.0 if shell.force is None else shell.force.value
    if shell.force is not None:
        shell.force.value = 0.0
    if pressure != 0:
        limit = find_limit_pressure(shell, pressure, tolerance)
        if limit is not None:
            return limit.iterations, limit_pressure_exceeded(limit.pressure)
        iterations += stepper.load()
    if shell.force is None or force == 0:
        return iterations, None
    coordinates = force_coordinates(scene, shell.force)
    shell.pressure.value = pressure
    largest = find_limit_force(shell, coordinates, force, tolerance, scene.cell.closed)
    if largest is not None:
        return iterations, limit_force_exceeded(largest)
    return iterations + stepper.load(), None
