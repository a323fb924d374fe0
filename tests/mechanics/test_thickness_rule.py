"""Integration through the thickness: exact for polynomials, clustered where growth begins."""

import numpy as np
import pytest

from fenics_yeast.mechanics import thickness_rule


@pytest.mark.parametrize("points", range(3, 25))
def test_clustered_points_integrate_polynomials_with_positive_weights(points: int) -> None:
    places, weights = thickness_rule(points, "clustered")
    assert np.all(weights > 0) and np.all(np.diff(places) > 0) and abs(places).max() < 1
    degree = points - 1 + points % 2
    for k in range(degree + 1):
        assert weights @ places**k == pytest.approx((1 + (-1) ** k) / (k + 1), abs=1e-13)
    assert abs(weights @ places ** (degree + 1) - 2 / (degree + 2)) > 0


@pytest.mark.parametrize("points", [5, 8, 13])
def test_they_lie_between_those_of_gauss_and_those_that_include_the_faces(points: int) -> None:
    """Zeros of Legendre's polynomial, and of its derivative with the faces (Lobatto)."""
    clustered, gauss = (thickness_rule(points, r)[0][-1] for r in ("clustered", "gauss"))
    assert gauss < clustered < 1
    # To the outermost point there is an angle of j/(n + 1/2) by Gauss and of k/(n - 0.15), with the
    # first zeros j and k of the Bessel functions of order 0 and -0.65 (Szegő, Orthogonal
    # Polynomials, theorem 8.1.2).
    angles = 2.405 / (points + 0.5), 1.278 / (points - 0.15)
    expected = (1 - np.cos(angles[1])) / (1 - np.cos(angles[0]))
    assert (1 - clustered) / (1 - gauss) == pytest.approx(expected, rel=0.02)


def test_two_points_cannot_be_clustered() -> None:
    with pytest.raises(ValueError, match="at least three"):
        thickness_rule(2, "clustered")
