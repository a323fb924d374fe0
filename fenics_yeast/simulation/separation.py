"""Separation of a cell into two by a septum.

The septum is a rigid disc welded to the wall: from the time of the cut on it holds radius and
rotation of the wall at its edge, on both sides, and is free to move along the axis with its piece.
Turgor acts on it as on the wall, and what it takes it gives to the edge. At the cut nothing moves:
each piece is in equilibrium as it was, since the septum now gives what the other piece gave.
"""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from ..scene import PressureTable, Scene


def pieces(scene: Scene, time: float) -> tuple[Scene, Scene]:
    """The lower and the upper piece of a cell that is cut at a time, as scenes of their own.

    Their time counts from the cut. They are run from the wall at the cut::

        whole = simulate(scene)
        lower, upper = pieces(scene, 85)
        daughter = simulate(upper, state=whole.profiles.at(85))

    Parameters
    ----------
    scene
        The whole cell, with a table `[septum]`; its run goes on after the cut.
    time
        Time of the cut in min.

    Raises
    ------
    ValueError
        If the scene has no septum or no run beyond the cut.
    """
    if scene.septum is None or scene.septum.piece is not None:
        raise ValueError("a scene of a whole cell with a table [septum] is wanted")
    if scene.run is None or scene.run.end <= time:
        raise ValueError(f"a run that goes on after the cut at {time:g} min is wanted")
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
        if ends <= time:  # it has grown, and does not any more
            changes[f"{key.format(i)}.from"] = end
        elif ends < inf:
            changes[f"{key.format(i)}.until"] = ends - time
    lower, upper = (
        scene.with_values({**changes, "septum.piece": piece}) for piece in ("bottom", "top")
    )
    return lower, upper
