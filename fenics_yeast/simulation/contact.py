"""Whether a wall touches itself, or has gone through itself."""

import numpy as np

from ..geometry import Array

_APART = 2.0  # thicknesses along the wall from which on a point is another part of it
_MOST = 500  # nodes that are compared


def touches_itself(
    r: Array, z: Array, thickness: float, poles: tuple[bool, bool] = (True, True)
) -> bool:
    """Whether two parts of a wall are closer than its thickness.

    Contact is not modelled: a wall that touches itself may go through itself, with its sides or
    with its poles.

    Parameters
    ----------
    r, z
        Current radius and height in µm of the nodes, along the meridian.
    thickness
        Thickness of the wall in µm.
    poles
        Whether the first and the last node are poles, through which the wall continues.
    """
    every, least = -(-len(r) // _MOST), _APART * thickness
    r, z = r[::every], z[::every]
    dr, dz = r[1:] - r[:-1], z[1:] - z[:-1]
    along = np.zeros(len(r))
    np.cumsum(np.hypot(dr, dz), out=along[1:])
    ways = [along] * poles[0] + [along[-1] - along] * poles[1]  # to the poles
    one_way = (dz >= 0).all() or (dr <= 0).all() or (dr >= 0).all()
    if one_way:
        facing_axis = ~(r > thickness)
        for way in ways:
            facing_axis &= way > least
        if not facing_axis.any():
            return False  # the common case: no part faces another one or the axis
    points = np.column_stack([r, z])
    apart = np.abs(along[:, None] - along)
    across = np.full_like(apart, np.inf)
    for way in ways:
        across = np.minimum(across, way[:, None] + way)
    return _near(points, points, apart, thickness, least) or _near(
        points, points * (-1, 1), across, thickness, least
    )


def _near(points: Array, others: Array, apart: Array, distance: float, least: float) -> bool:
    """Whether two lines cross or come close where they are apart by a least length of wall."""
    starts, along = others[:-1], np.diff(others, axis=0)
    gaps = points[:, None] - starts
    squares = np.maximum((along**2).sum(axis=1), 1e-300)
    part = np.clip((gaps * along).sum(axis=2) / squares, 0, 1)
    distances = np.linalg.norm(gaps - part[..., None] * along, axis=2)
    lengths = np.minimum(apart[:, :-1], apart[:, 1:])  # of the wall to the nearer end
    if ((distances < distance) & (lengths > least)).any():
        return True
    # Segments cross if the ends of each are on both sides of the other.
    side = along[:, 0] * gaps[..., 1] - along[:, 1] * gaps[..., 0]  # of points, by other segments
    back = others[:, None] - points[:-1]
    forward = np.diff(points, axis=0)
    side_of_others = forward[:, 0] * back[..., 1] - forward[:, 1] * back[..., 0]
    crossing = (side[:-1] * side[1:] < 0) & (side_of_others[:-1] * side_of_others[1:] < 0).T
    return bool((crossing & (lengths[:-1] > 0) & (lengths[1:] > 0)).any())
