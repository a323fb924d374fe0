"""Where a wall has lost its stiffness or its thickness, or is folded too sharply for a shell."""

import numpy as np

from ..geometry import Array
from ..scene import LinearWall

_SHARP = 0.05  # stretch of a face; in the theory, a fold of zero radius makes it 0
_THIN = 0.1  # of the thickness; a little further, nothing is left and the stress is infinite


def softest_stretch(wall: LinearWall, strain: Array) -> float | None:
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
    if not strain.size:
        return None
    squares = np.exp(2 * strain)
    others = (squares[..., ::-1] - 1) / 2
    soft = (3 * squares - 1) / 2 + wall.poisson_ratio * others <= 0
    return float(np.sqrt(squares[soft].min())) if soft.any() else None


def sharpest_stretch(strain: Array) -> float | None:
    """Return the least stretch of a wall that is folded more sharply than its thickness, or None.

    Of total logarithmic strains, shape ``(..., 2)``. Green-Lagrange strains are linear through the
    thickness, so that they compress one face to nothing where the wall is bent to a radius of the
    size of its thickness. A face that is pressed beyond the threshold also shrinks for good.
    """
    if not strain.size:
        return None
    least = float(np.exp(strain.min()))
    return least if least < _SHARP else None


def least_thickness(wall: LinearWall, strain: Array) -> float | None:
    """Return the least thickness ratio of a Saint Venant-Kirchhoff wall that has thinned away.

    In plane stress `λ3² = 1 - 2 ν (E1 + E2) / (1 - ν)`, which is zero at moderate strains; the
    thickness of other laws never is.

    Parameters
    ----------
    wall, strain
        As in `softest_stretch`.

    Returns
    -------
    float or None
        The elastic stretch `λ3`, 0 where the wall has none; None if it is above 0.1 everywhere.
    """
    if not strain.size:
        return None
    nu, green = wall.poisson_ratio, (np.exp(2 * strain) - 1) / 2
    least = float((1 - 2 * nu / (1 - nu) * green.sum(axis=-1)).min())
    return max(0.0, least) ** 0.5 if least <= _THIN**2 else None
