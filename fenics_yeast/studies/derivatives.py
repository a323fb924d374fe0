"""Derivatives of a run by any number of its scene: exact ones, and central differences."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Self

import numpy as np

from ..scene import Scene, SceneError, value_of
from ..simulation import (
    History,
    Replay,
    Result,
    Sensitivities,
    ShellPool,
    has_exact_sensitivity,
    kinks,
    simulate,
)

_CHANGE = 2e-4  # relative, of a parameter: curvature and Newton's tolerance then matter alike


def simulate_with_derivatives(
    scene: Scene, keys: Sequence[str], *, shells: ShellPool | None = None, comm: Any = None
) -> Result:
    """Run a scene; differentiate its history by numbers of the scene.

    Moduli, exponents, thickness, turgor, thresholds and growth times have exact derivatives, all of
    which cost less than a run. Every other number, such as the angle of a zone or the size of the
    cell, costs two runs: see `differences`.

    Parameters
    ----------
    scene
        What to simulate.
    keys
        Dotted keys of numbers, such as ``growth.threshold``.
    shells, comm
        As in `simulate`; with a pool, further runs of a kind compile nothing.

    Returns
    -------
    Result
        Its `sensitivities` are by the keys, in their order.

    Raises
    ------
    SceneError
        If a key is not that of a number, or moves a time at which growth or pressure change.
    KeyboardInterrupt
        If a run for differences is interrupted; an interrupted run itself is returned.
    """
    exact = [key for key in keys if has_exact_sensitivity(scene, key)]
    others = [key for key in keys if key not in exact]
    for key in others:
        Sides.of(scene, key)  # which refuses some, before the run
    result = simulate(scene, shells=shells, comm=comm, sensitivities=exact)
    if result.status == "interrupted":
        return result
    parts = [] if result.sensitivities is None else [result.sensitivities]
    with ShellPool() as own:
        pool = own if shells is None else shells
        for key in others:
            parts.append(differences(scene, key, result.history, shells=pool, comm=comm))
    return replace(result, sensitivities=Sensitivities.joined(parts, keys)) if parts else result


def differences(
    scene: Scene, key: str, history: History, *, shells: ShellPool | None = None, comm: Any = None
) -> Sensitivities:
    """Differentiate the history of a scene by one of its numbers, by central differences.

    Two runs, with the number changed by some 1e-4 of it, repeat the accepted steps and the mesh of
    the history. Nodes move with the shape. Rows that one of the two does not reach are not numbers.

    Raises
    ------
    SceneError
        If the key is not that of a number, or moves a time at which growth or pressure change.
    KeyboardInterrupt
        If a run is interrupted.
    """
    sides = Sides.of(scene, key)
    with ShellPool() as own:
        ended = sides.run(Replay.of(scene, history), own if shells is None else shells, comm)
    above, below = (result.history for result in ended)
    # Both have the rows of the history, up to the first step that one of them cannot take.
    count = min(_shared(history, side) for side in (above, below))

    def slope(column: str) -> Any:
        found = np.full((len(history), 1), np.nan)
        difference = getattr(above, column)[:count] - getattr(below, column)[:count]
        found[:count, 0] = difference / (2 * sides.change)
        return found

    return Sensitivities.of_columns((key,), (sides.value,), history, slope)


class Sides(NamedTuple):
    """A scene with a number changed up and down by `change`, for central differences."""

    value: float
    change: float
    scenes: tuple[Scene, Scene]

    @classmethod
    def of(cls, scene: Scene, key: str) -> Self:
        """Return both sides of a scene.

        Raises
        ------
        SceneError
            If a key is not that of a number, or moves a time at which growth or pressure change.
        """
        value = _value(scene, key)
        change = _CHANGE * (abs(value) or 1.0)
        higher, lower = (scene.with_values({key: value + by}) for by in (change, -change))
        if kinks(higher) != kinks(scene) or higher.run != scene.run:
            raise SceneError(
                f"{key} moves times at which growth or pressure change; steps cannot be held"
            )
        return cls(value, change, (higher, lower))

    def run(self, replay: Replay, shells: ShellPool, comm: Any) -> tuple[Result, Result]:
        """Run both with the steps and the mesh of another run.

        Raises
        ------
        KeyboardInterrupt
            If a run is interrupted.
        """
        ended = []
        for side in self.scenes:
            ended.append(simulate(side, replay=replay, shells=shells, comm=comm))
            if ended[-1].status == "interrupted":
                raise KeyboardInterrupt
        return ended[0], ended[1]


def _shared(history: History, other: History) -> int:
    """Return the number of first rows with the same times."""
    count = min(len(history), len(other))
    differ = np.flatnonzero(history.time_min[:count] != other.time_min[:count])
    return int(differ[0]) if len(differ) else count


def _value(scene: Scene, key: str) -> float:
    """Return the number at a key."""
    try:
        value = value_of(scene, key)
    except KeyError:
        raise SceneError(f"{key}: the scene has no such key") from None
    if not isinstance(value, float):
        raise SceneError(f"{key}: expected the key of a number that can vary continuously")
    return value
