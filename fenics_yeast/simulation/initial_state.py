"""Start a wall from the profile of another run."""

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import NEAR, Array
from ..mechanics import Shell
from .profiles import Profile


def set_initial_state(shell: Shell, profile: Profile | None) -> None:
    """Set a shell to the state of a profile: positions, director angles and growth strains.

    The shell must be the unloaded wall of the profile, or a part of it, on the same nodes. The
    next equilibrium gives the shear force. Collective; only rank 0 needs the profile.

    Raises
    ------
    ValueError
        If the profile belongs to another wall, or has grown outside the growing zones.
    """
    profile = shell.comm.bcast(profile)
    assert profile is not None
    curve = shell.discretisation.curve
    S, dofs = dx.node_dofs(shell.space)
    near = NEAR * curve.length
    places = _places(S, profile.S, near, "nodes")
    moved = (profile.r - curve.radius(profile.S), profile.z - curve.height(profile.S),
             (profile.psi - curve.angle(profile.S)) / shell.rotation)  # fmt: skip
    for i, motion in enumerate(moved[: dofs.shape[1]]):
        shell.w.x.array[dofs[:, i]] = motion[places]
    shell.w.x.scatter_forward()

    points = shell.points.S
    places = _places(points.ravel(), profile.S_points, near, "quadrature points")
    grown = profile.growth_strain[places].reshape(*points.shape, -1)
    if grown.shape[-1] != 2 * len(shell.eps):
        raise ValueError(f"numerics.thickness_points must be {len(profile.xi)}, as in the profile")
    rest = np.ones(len(points), dtype=bool)
    if shell.growth is not None:
        growing = shell.growing_points.elements
        rest[growing] = False
        shell.growth.set(grown[growing].reshape(shell.growth.get().shape))
    if grown[rest].any():
        raise ValueError("the profile has growth outside the scene's growing zones")


def _places(sought: Array, known: Array, near: float, what: str) -> NDArray[np.int64]:
    """Return the indices of arc lengths among known ones."""
    after = np.clip(np.searchsorted(known, sought), 1, len(known) - 1)
    nearest = after - (sought - known[after - 1] < known[after] - sought)
    if np.abs(known[nearest] - sought).max(initial=0.0) > near:
        raise ValueError(f"the {what} differ from the profile's; use the same table [numerics]")
    return nearest
