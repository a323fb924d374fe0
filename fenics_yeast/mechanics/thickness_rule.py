"""Integration through the thickness of a wall."""

from typing import Literal

import numpy as np
from numpy.polynomial import legendre

from ..geometry import Array

# Of the Gegenbauer polynomials whose zeros are the clustered points: 1/2 for those of Gauss, and
# towards -1/2 the outermost points move to the faces.
_LAMBDA = -0.15


def thickness_rule(points: int, rule: Literal["gauss", "clustered"]) -> tuple[Array, Array]:
    """Return points and weights of a rule on (-1, 1), each of shape ``(points,)``.

    Gauss' rule is best for what varies smoothly. Growth begins at a face, where stress first
    passes the threshold, and leaves a kink that moves inward: points that are clustered at the
    faces halve the error of V/V0 of Gauss' rule or better. They are zeros of Gegenbauer
    polynomials; their rule is exact for polynomials of degree `points - 1`, and one more if
    `points` is odd. With two points it would be too inaccurate in bending.

    Raises
    ------
    ValueError
        For fewer than three clustered points.
    """
    if rule == "gauss":
        return legendre.leggauss(points)
    if points < 3:
        raise ValueError("clustered points must be at least three")
    # Eigenvalues of the Jacobi matrix: G. H. Golub, J. H. Welsch, Math. Comp. 23 (1969) 221-230.
    n = np.arange(1, points)
    squared = n * (n + 2 * _LAMBDA - 1) / (4 * (n + _LAMBDA) * (n + _LAMBDA - 1))
    zeros = np.linalg.eigvalsh(np.diag(np.sqrt(squared), 1), UPLO="U")
    zeros = (zeros - zeros[::-1]) / 2
    moments = np.append(2.0, np.zeros(points - 1))
    return zeros, np.linalg.solve(legendre.legvander(zeros, points - 1).T, moments)
