"""The unloaded shape of a cell whose turgid outline is given, found before its run."""

import hashlib
from dataclasses import replace
from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array, Curve, Discretisation, Parametric
from ..mechanics import OwnLaw, Shell
from ..scene import ProfileCell, Scene, Unloaded
from ..solve import InversionError, OutlineInversion
from .build import approximation_of, wall_of
from .discretise import divided
from .ranks import RootError, on_root
from .result import UnloadedShape
from .scales import residual_tolerance

_ENOUGH = 1e-6  # of the radius: distance between outline and equilibrium


class UnloadedShapeError(RuntimeError):
    """A turgid outline for which no unloaded shape was found."""


def find_unloaded(scene: Scene, comm: Any = None, *, energy: OwnLaw | None = None) -> Scene:
    """Return a scene with the unloaded shape of its turgid outline; any other scene as it is.

    The shape is found without growth, force and septum, under the turgor of the start. A scene
    that has the shape already, from the same outline, wall, turgor and mesh, is returned as it is.
    Collective: rank 0 finds the shape.

    Parameters
    ----------
    scene, energy
        As in `simulate`.
    comm
        MPI communicator; by default all ranks of the world.

    Raises
    ------
    UnloadedShapeError
        If there is no such shape, or it was not found.
    """
    cell = scene.cell
    if not isinstance(cell, ProfileCell) or cell.outline_is == "unloaded":
        return scene
    inputs = _digest(scene, cell)
    if energy is None and cell.unloaded is not None and cell.unloaded.inputs == inputs:
        return scene
    comm = dx.MPI.COMM_WORLD if comm is None else comm
    try:
        found = on_root(comm, lambda: _found(scene, cell, energy, inputs), UnloadedShapeError)
    except RootError as error:
        raise error.__cause__ or error from None
    return scene.with_values({"cell.unloaded": comm.bcast(found)})


def fit_of(scene: Scene) -> UnloadedShape | None:
    """Return how well the unloaded shape of a scene fits its turgid outline, if it has one."""
    cell = scene.cell
    if not isinstance(cell, ProfileCell) or cell.unloaded is None:
        return None
    outline, found = cell.curve, cell.unloaded
    S = np.array(found.S)
    moved = np.hypot(outline.radius(S) - found.r, outline.height(S) - found.z)
    return UnloadedShape(found.residual_distance, float(moved.max()))


def _found(scene: Scene, cell: ProfileCell, energy: OwnLaw | None, inputs: str) -> Unloaded:
    outline, pressure = cell.curve, scene.turgor.initial
    whole = _whole(scene)
    rest: dict[str, object] = dict.fromkeys(("growth", "run", "path", "load", "septum"))
    elastic = whole.with_values(rest | {"turgor": {"pressure": pressure}})
    shells: list[Shell] = []

    def mesh_on(meridian: Parametric) -> Discretisation:
        def reference(S: Array) -> tuple[Curve, Array]:
            return meridian, meridian.arc_length(outline.parameter(S))

        return replace(divided(whole, reference), zones=(), loaded=None)

    def shell_on(mesh: Discretisation) -> Shell:
        parts = mesh, wall_of(elastic, mesh, energy), approximation_of(whole)
        if not shells:
            shells.append(Shell(*parts, dx.MPI.COMM_SELF))
        else:
            shells[0].reset(*parts)
        return shells[0]

    t = outline.parameter(_nodes(whole))
    tolerance = residual_tolerance(elastic, len(t))
    inversion = OutlineInversion(outline, t, mesh_on, shell_on, tolerance)
    try:
        shape = inversion.solve(pressure, _ENOUGH * cell.radius)
    except InversionError as error:
        raise UnloadedShapeError(_no_shape(error, pressure)) from None
    places = np.column_stack(outline.point(shape.t, 0)) - shape.displacement
    return Unloaded(
        S=tuple(outline.arc_length(shape.t).tolist()),
        r=tuple(places[:, 0].tolist()),
        z=tuple(places[:, 1].tolist()),
        residual_distance=shape.distance,
        inputs=inputs,
    )


def _no_shape(error: InversionError, pressure: float) -> str:
    nearest = "no equilibrium was found near the outline"
    if np.isfinite(error.distance):
        nearest = f"the nearest equilibrium is {error.distance:.2g} µm from the outline"
    return (
        f"no unloaded shape found for the turgid outline: beyond {error.part * pressure:.4g} of "
        f"{pressure:.6g} MPa, {nearest}; check turgor.pressure, wall.thickness and moduli, or "
        "increase cell.tolerance"
    )


def _whole(scene: Scene) -> Scene:
    """Return the scene of the whole cell, of which this one may be a piece, with its mesh."""
    piece = scene.septum is not None and scene.septum.piece is not None
    return scene.with_values({"septum.piece": None}) if piece else scene


def _nodes(scene: Scene) -> Array:
    """Return the arc lengths on a cell's outline at which its elements end."""
    nodes: list[Array] = []

    def same(S: Array) -> tuple[Curve, Array]:
        nodes.append(S)
        return scene.cell.curve, S

    divided(scene, same)
    return nodes[0]


def _digest(scene: Scene, cell: ProfileCell) -> str:
    """Return a digest of what the unloaded shape depends on."""
    nodes, outline = _nodes(_whole(scene)), (cell.r, cell.z, cell.tolerance, cell.edge)
    method = scene.numerics.geometry, approximation_of(scene)
    inputs = outline, scene.wall, scene.turgor.initial, nodes.tolist(), method
    return hashlib.sha256(repr(inputs).encode()).hexdigest()[:16]
