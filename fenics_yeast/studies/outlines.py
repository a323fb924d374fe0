"""Distances of measured from computed outlines: residuals of a fit, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._mpi import MPI
from ..geometry import (
    Array,
    Distances,
    Parametric,
    aligned_distances,
    curve_through,
    signed_distances,
)
from ..scene import MeasuredOutlines, Outline, Scene, SceneError
from ..simulation import Profile, Profiles, Replay, Result, ShellPool, Status, simulate
from .derivatives import Sides

_ON_AXIS = 1e-9  # of the largest radius: an end that is a pole
_RISE = 10.0  # of the distances beyond the end of a run, in radii per time span


class OutlineResiduals(NamedTuple):
    """Distances of measured points over their noise, and derivatives by numbers of the scene.

    Attributes
    ----------
    residuals
        Positive where the measured cell is larger, shape ``(points,)``.
    jacobian
        Derivatives per unit of each key in µm, MPa, min and degrees, shape ``(points, keys)``; not
        numbers where a run for differences has no state.
    complete
        Whether all runs reached the last outline; beyond their ends, distances increase steeply.
    result
        The run.
    """

    residuals: Array
    jacobian: Array
    complete: bool
    result: Result


def meridian_of(profile: Profile) -> Parametric:
    """Return the smooth curve through the nodes of a profile, by reference arc length."""
    r, S = profile.r, profile.S - profile.S[0]
    axis = _ON_AXIS * r.max()
    poles = bool(r[0] <= axis), bool(r[-1] <= axis)
    return curve_through(S, np.column_stack([r, profile.z]), poles)


def distances(outline: Outline, profile: Profile, *, shift: float | None = None) -> Distances:
    """Return the distances of a measured outline from a computed profile, along its normals.

    Parameters
    ----------
    outline, profile
        The measured outline, and the wall at its time.
    shift
        What to add to the heights of the points, in µm; by default, what makes the root mean
        square distance least, since the image does not know where a run has its lower end.
    """
    curve = meridian_of(profile)
    if shift is None:
        return aligned_distances(curve, outline.points)
    moved = outline.points + np.array([0.0, shift])
    return signed_distances(curve, moved)._replace(shift=shift)


def outline_residuals(measured: MeasuredOutlines, profiles: Profiles) -> Array:
    """Return the distances of all points over the noise, outline by outline, shape ``(points,)``.

    Each outline is shifted along the axis to where it fits best. Outlines after the end of a run
    that ended early are compared with its last profile, and distances increase with the time
    that is missing: they are large but continuous.

    Raises
    ------
    KeyError
        If the run has not saved one of the times before its end; see `MeasuredOutlines.times`.
    """
    found = []
    end = max((profile.time for profile in profiles), default=0.0)
    for outline in measured.outlines:
        time = outline.time - measured.offset
        late = max(time - end, 0.0) if not np.isclose(time, end, rtol=1e-9) else 0.0
        profile = profiles.at(end if late else time)
        away = distances(outline, profile).distance
        found.append(away - _RISE * profile.r.max() * late / max(time, 1.0))
    return np.concatenate(found) / measured.noise


def compare_outlines(
    scene: Scene,
    measured: MeasuredOutlines,
    keys: Sequence[str] = (),
    *,
    shells: ShellPool | None = None,
) -> OutlineResiduals:
    """Run a scene and compare it with outlines; differentiate the residuals by numbers of it.

    The run ends at the last outline. Each key costs two runs, which repeat the accepted steps and
    the mesh of the first one: central differences. Each rank makes its own runs.

    Parameters
    ----------
    scene, measured
        The scene, in which the values of `MeasuredOutlines.set` are set, and the outlines.
    keys
        Dotted keys of numbers, such as ``growth.threshold``.
    shells
        As in `simulate`; with a pool, further runs of a kind compile nothing.

    Raises
    ------
    SceneError
        If a key has no differences, or the run has no state at all.
    KeyboardInterrupt
        If a run is interrupted.
    """
    times = [time for time in measured.times if time > 0] or [1e-9]
    span = {"run.end": times[-1], "run.save": sorted({0.0, *measured.times, times[-1]})}
    scene = scene.with_values({**measured.set, **span})
    changes = [Sides.of(scene, key) for key in keys]
    with ShellPool() as own:
        pool = own if shells is None else shells
        result = simulate(scene, shells=pool, comm=MPI.COMM_SELF)
        if result.status == "interrupted":
            raise KeyboardInterrupt
        if not len(result.profiles):
            raise SceneError(f"no equilibrium to compare with: {result.message}")
        run = Replay.of(scene, result.history)
        residuals = outline_residuals(measured, result.profiles)
        jacobian = np.full((len(residuals), len(keys)), np.nan)
        statuses: list[Status] = [result.status]
        for i, one in enumerate(changes):
            ended = one.run(run, pool, MPI.COMM_SELF)
            statuses += [side.status for side in ended]
            if all(len(side.profiles) for side in ended):
                above, below = (outline_residuals(measured, side.profiles) for side in ended)
                jacobian[:, i] = (above - below) / (2 * one.change)
    complete = all(status == "finished" for status in statuses)
    return OutlineResiduals(residuals, jacobian, complete, result)
