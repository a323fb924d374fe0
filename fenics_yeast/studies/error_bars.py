"""Error bars of V/V0 by reruns with one part of the numerics refined at a time.

The difference between two runs is extrapolated to the whole error (Richardson): an error that falls
as `n^-p` is `1 / (1 - (n / m)^p)` times the difference between n and m. Absolute values of the
parts are added, so that they cannot cancel.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, isinf
from typing import Any, Literal, get_args

import numpy as np

from ..geometry import Array
from ..scene import Scene
from ..simulation import ErrorBars, Observer, Result, ShellPool, simulate
from ..solve import TABLEAUX

Part = Literal["time_steps", "mesh", "thickness_points", "shear_penalty"]

_FINER_MESH, _FINER_WALL = 1.5, 1.6
_MOST_ELEMENTS, _MOST_POINTS = 100_000, 24  # that a scene may have
_UNREACHED = "no error bars: the run reached none of its saved times"
_PATH = "no error bars: an equilibrium path has no saved times"
_WALL_ORDER = 2  # measured: the growth rate has a kink where stress passes the threshold


@dataclass(frozen=True)
class Refinement:
    """A refined part, its values for `Scene.with_values`, and error over difference of runs."""

    part: Part
    changes: Mapping[str, object]
    scale: float


def estimate_error_bars(
    scene: Scene,
    result: Result,
    *,
    announce: Callable[[Part], None] | None = None,
    observer: Observer | None = None,
    comm: Any = None,
) -> ErrorBars:
    """Estimate the errors of V/V0 at the saved times by refined reruns; collective.

    Parameters
    ----------
    scene
        What was run.
    result
        Its result.
    announce
        Called with each part before its run.
    observer
        Observer of all reruns, which may interrupt them.
    comm
        MPI communicator whose ranks share the wall; by default all ranks of the world.

    Raises
    ------
    KeyboardInterrupt
        If a refined run is interrupted.
    """
    times = _reached(scene, result)
    own = _volumes(result, times)
    parts = {part: np.zeros(len(times)) for part in get_args(Part)}
    remarks = [] if times else [_UNREACHED if scene.path is None else _PATH]
    with ShellPool() as shells:
        for refinement in refinements(scene) if times else ():
            if announce is not None:
                announce(refinement.part)
            finer_scene = _until(scene, times).with_values(refinement.changes)
            finer = simulate(finer_scene, observer=observer, comm=comm, shells=shells)
            if finer.status == "interrupted":
                raise KeyboardInterrupt
            if finer.status != "finished":
                remarks.append(f"{refinement.part.replace('_', ' ')} refined: {finer.message}")
            parts[refinement.part] = refinement.scale * np.abs(_volumes(finer, times) - own)
    return ErrorBars(np.array(times), **parts, message="; ".join(remarks))


def refinements(scene: Scene) -> list[Refinement]:
    """Return the refinements of a scene, for each part that has an error."""
    numerics = scene.numerics
    finer = [_finer_mesh(scene), _finer_wall(scene)]
    if scene.growth is not None:
        finer.insert(0, _finer_time(scene))
    if not isinf(numerics.shear_penalty):
        penalty = 10 * numerics.shear_penalty
        changes = {"numerics.shear_penalty": penalty}
        finer.append(Refinement("shear_penalty", changes, _scale(numerics.shear_penalty, penalty)))
    return finer


def _finer_time(scene: Scene) -> Refinement:
    """Halve the step, or take a tenth of the tolerance for the steps only."""
    numerics = scene.numerics
    tableau = TABLEAUX[numerics.integrator]
    if numerics.step is not None:
        changes: dict[str, object] = {"numerics.step": numerics.step / 2}
        return Refinement("time_steps", changes, _scale(1, 2, tableau.order))
    # The estimate, which the tolerance bounds, falls with another power than the error.
    changes = {"numerics.tolerance": numerics.tolerance / 10}
    chosen = ("elements", "thickness_points", "thickness_rule", "shear_penalty")  # by the tolerance
    changes |= {f"numerics.{key}": getattr(numerics, key) for key in chosen}
    return Refinement("time_steps", changes, _scale(1, 10, tableau.order / tableau.estimate_order))


def _finer_mesh(scene: Scene) -> Refinement:
    numerics = scene.numerics
    elements = _refined(numerics.elements, _FINER_MESH, _MOST_ELEMENTS)
    order = 2 if numerics.geometry == "conical" else 2 * numerics.order
    scale = _scale(numerics.elements, elements, order)
    return Refinement("mesh", {"numerics.elements": elements}, scale)


def _finer_wall(scene: Scene) -> Refinement:
    numerics = scene.numerics
    points = _refined(numerics.thickness_points, _FINER_WALL, _MOST_POINTS)
    scale = _scale(numerics.thickness_points, points, _WALL_ORDER)
    changes = {
        "numerics.thickness_points": points,
        "numerics.thickness_rule": numerics.thickness_rule,
    }
    return Refinement("thickness_points", changes, scale)


def _refined(n: int, ratio: float, most: int) -> int:
    """Return a number larger by about a ratio or, beyond the most allowed, smaller by it."""
    more = max(n + 2, ceil(ratio * n))
    return more if more <= most else round(n / ratio)


def _scale(n: float, m: float, order: float = 1) -> float:
    """Return error at n over difference between n and m, for an error ``~ n^-order``."""
    return 1 / abs(1 - (n / m) ** order)


def _reached(scene: Scene, result: Result) -> list[float]:
    """Return the saved times that a run reached."""
    if scene.path is not None:
        return []
    saved = (0.0,) if scene.run is None else scene.run.save
    reached = result.end_time if len(result.history) else -1.0
    return [time for time in saved if time <= reached]


def _until(scene: Scene, times: Sequence[float]) -> Scene:
    """Return the scene with its run ending at the last of some saved times."""
    if scene.run is None:
        return scene
    end = max(times) or scene.run.end
    return scene.with_values({"run.end": end, "run.save": list(times)})


def _volumes(result: Result, times: Sequence[float]) -> Array:
    """Return V/V0 at some times; not a number where the run did not reach them."""
    reached = [time for time in times if len(result.history) and time <= result.end_time]
    values = [result.history.at(time).volume_ratio for time in reached]
    return np.array(values + [np.nan] * (len(times) - len(reached)))
