"""Error bars of V/V0: a scene is run again with one thing refined at a time.

The difference that a refinement makes is scaled to the whole error of what was refined: an error
that falls as `n^-p` is `1 / (1 - (n / m)^p)` times the difference between n and m. The parts are
added by their size, so that they cannot cancel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, isinf
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..scene import Scene
from ..simulation import ErrorBars, Observer, Result, simulate
from ..solve import TABLEAUX

Array = NDArray[np.float64]
Part = Literal["time_steps", "mesh", "thickness_points", "shear_penalty"]

_FINER_MESH, _FINER_WALL = 1.5, 1.6
_MOST_ELEMENTS, _MOST_POINTS = 100_000, 16  # that a scene may have
_UNREACHED = "no error bars: the run has reached none of its saved times"
_PATH = "no error bars: a path has no times to be compared at"
_WALL_ORDER = 2  # measured: the growth rate has a kink where stress passes the threshold


@dataclass(frozen=True)
class Refinement:
    """A change of the numerics, and what its difference says about the error.

    Attributes
    ----------
    part
        What is refined.
    changes
        Values for `Scene.with_values`.
    scale
        Error of the scene's own run over the difference of the two runs.
    """

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
    """Run a scene again, refined in one thing at a time, and compare V/V0 at the saved times.

    Every rank of the communicator calls this and gets the bars.

    Parameters
    ----------
    scene
        What was run.
    result
        What came out.
    announce
        Is told of each part before its run.
    observer
        Is told of the steps of all these runs, and may interrupt them.
    comm
        MPI communicator whose ranks share the wall; all ranks of the world if left out.

    Raises
    ------
    KeyboardInterrupt
        If a refined run is interrupted.
    """
    times = _reached(scene, result)
    own = _volumes(result, times)
    parts = {part: np.zeros(len(times)) for part in get_args(Part)}
    remarks = [] if times else [_UNREACHED if scene.path is None else _PATH]
    for refinement in refinements(scene) if times else ():
        if announce is not None:
            announce(refinement.part)
        finer_scene = _until(scene, times).with_values(refinement.changes)
        finer = simulate(finer_scene, observer=observer, comm=comm)
        if finer.status == "interrupted":
            raise KeyboardInterrupt
        if finer.status != "finished":
            remarks.append(f"{refinement.part.replace('_', ' ')} refined: {finer.message}")
        parts[refinement.part] = refinement.scale * np.abs(_volumes(finer, times) - own)
    return ErrorBars(np.array(times), **parts, message="; ".join(remarks))


def refinements(scene: Scene) -> list[Refinement]:
    """What to refine in a scene, one thing at a time; nothing that has no error."""
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
    """Half the step; or a tenth of the tolerance, on the same cells."""
    numerics = scene.numerics
    tableau = TABLEAUX[numerics.integrator]
    if numerics.step is not None:
        changes: dict[str, object] = {"numerics.step": numerics.step / 2}
        return Refinement("time_steps", changes, _scale(1, 2, tableau.order))
    # The estimate that is held to the tolerance falls with another power than the error.
    changes = {
        "numerics.tolerance": numerics.tolerance / 10,
        "numerics.elements": numerics.elements,
    }
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
    return Refinement("thickness_points", {"numerics.thickness_points": points}, scale)


def _refined(n: int, ratio: float, most: int) -> int:
    """A larger number by about a ratio; where that is too many, a smaller one tells as much."""
    more = max(n + 2, ceil(ratio * n))
    return more if more <= most else round(n / ratio)


def _scale(n: float, m: float, order: float = 1) -> float:
    """Error at n over the difference between n and m, for an error that falls as ``n^-order``."""
    return 1 / abs(1 - (n / m) ** order)


def _reached(scene: Scene, result: Result) -> list[float]:
    """Saved times that a run has reached."""
    if scene.path is not None:
        return []
    wanted = (0.0,) if scene.run is None else scene.run.save
    reached = result.end_time if len(result.history) else -1.0
    return [time for time in wanted if time <= reached]


def _until(scene: Scene, times: Sequence[float]) -> Scene:
    """The scene, no longer than to the last of some saved times."""
    if scene.run is None:
        return scene
    end = max(times) or scene.run.end
    return scene.with_values({"run.end": end, "run.save": list(times)})


def _volumes(result: Result, times: Sequence[float]) -> Array:
    """V/V0 at some times; not a number at those that the run has not reached."""
    reached = [time for time in times if len(result.history) and time <= result.end_time]
    values = [result.history.at(time).volume_ratio for time in reached]
    return np.array(values + [np.nan] * (len(times) - len(reached)))
