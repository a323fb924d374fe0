"""Where a wall has lost its stiffness, and with it its equilibrium."""

import numpy as np

from ..geometry import Array
from ..scene import AnyWall, LinearWall


def softest_stretch(wall: AnyWall, strain: Array) -> float | None:
    """Return the least stretch at which a Saint Venant-Kirchhoff wall resists no compression.

    With the energy of plane stress `E/(1 - ν²) (E1² + 2 ν E1 E2 + E2²)/2` in the Green-Lagrange
    strains, the nominal stress `P1` rises with the stretch `λ1` only if

        (3 λ1² - 1)/2 + ν E2 > 0

    so that without `E2` a wall cannot be compressed beyond `λ1 = 1/√3`. Other laws have no such
    limit.

    Parameters
    ----------
    wall
        The wall of a scene.
    strain
        Elastic logarithmic strains, meridional and hoop, shape ``(..., 2)``.

    Returns
    -------
    float or None
        The stretch; None if the wall is stiff everywhere.
    """
    if not isinstance(wall, LinearWall) or not strain.size:
        return None
    squares = np.exp(2 * strain)
    others = (squares[..., ::-1] - 1) / 2
    soft = (3 * squares - 1) / 2 + wall.poisson_ratio * others <= 0
    return float(np.sqrt(squares[soft].min())) if soft.any() else None
