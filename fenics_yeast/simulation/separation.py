"""Separation of a cell into two by a septum.

The septum is a rigid disc welded to the wall. After separation it fixes radius and rotation of the
wall at its edge, on both sides, and moves freely along the axis with its cell. Turgor acts on it
as on the wall, and the septum transmits this load to the edge. Nothing moves at separation: the
septum then exerts the forces that the other cell exerted before.
"""

from math import inf
from typing import Any

import numpy as np

from ..scene import PressureTable, Scene


def pieces(scene: Scene, time: float) -> tuple[Scene, Scene]:
    """Split a cell at its septum; return lower and upper scenes.

    Their time counts from the separation. They start from the wall at that time::

        whole = simulate(scene)
        lower, upper = pieces(scene, 85)
        daughter = simulate(upper, state=whole.profiles.at(85))

    Parameters
    ----------
    scene
        The whole cell, with a table `[septum]` and a run that ends after the separation.
    time
        Time of the separation in min.

    Raises
    ------
    ValueError
        If the scene has no septum, or its run ends before the separation.
    """
    if scene.septum is None or scene.septum.piece is not None:
        raise ValueError("expected a scene of a whole cell with a table [septum]")
    if scene.run is None or scene.run.end <= time:
        raise ValueError(f"run.end must be later than the separation at {time:g} min")
    later = tuple(saved - time for saved in scene.run.save if saved > time)
    end = scene.run.end - time
    changes: dict[str, Any] = {"run": {"end": end, "save": later or (end,)}, "turgor.ramp": 0.0}
    pressure = scene.turgor.pressure
    if isinstance(pressure, PressureTable):
        times = np.array(pressure.time)
        now = float(np.interp(time, times, pressure.value))
        after = [(t - time, p) for t, p in zip(times, pressure.value, strict=True) if t > time]
        shifted, values = zip((0.0, now), *after, strict=True)
        changes["turgor.pressure"] = {"time": shifted, "value": values}
    key = "growth.{}" if isinstance(scene.growth, tuple) else "growth"
    for i, growth in enumerate(scene.growing):
        begins, ends = growth.span
        changes[f"{key.format(i)}.from"] = max(begins - time, 0.0)
        if ends <= time:  # its growth has ended
            changes[f"{key.format(i)}.from"] = end
        elif ends < inf:
            changes[f"{key.format(i)}.until"] = ends - time
    lower, upper = (
        scene.with_values({**changes, "septum.piece": piece}) for piece in ("bottom", "top")
    )
    return lower, upper
