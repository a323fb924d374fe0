"""Reference meridians: their arc length, angle, curvature and poles."""

import numpy as np
import pytest
from scipy.special import ellipe
from support.shapes import ellipse

from fenics_yeast.geometry import (
    Cap,
    Capsule,
    Curve,
    Sphere,
    Straight,
    polar_extent,
    smooth_contour,
    spheroid,
)

CLOSED: dict[str, Curve] = {
    "sphere": Sphere(2.5),
    "spheroid": spheroid(2.0, 3.5),
    "capsule": Capsule(2.0, 7.0),
    "contour": smooth_contour(*map(tuple, ellipse(60)), 1e-5),
}
CURVES: dict[str, Curve] = {
    **CLOSED,
    "cap": Cap(10.0, np.deg2rad(20.0)),
    "disc": Straight(2.0, 0.0, 0.0),
    "cone": Straight(4.0, 1.5, 1.0),
    "cylinder": Straight(2.0, 2.0, 9.0),
}


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_angle_and_curvature_are_derivatives_by_arc_length(curve):
    """R' = cos Φ, Z' = sin Φ and Φ' by differences, away from the joints."""
    S, step = np.linspace(0.01, 0.99, 57) * curve.length, 1e-5
    S = S[[all(abs(s - joint) > 2 * step for joint in curve.joints) for s in S]]

    def slope(function):
        return (function(S + step) - function(S - step)) / (2 * step)

    np.testing.assert_allclose(slope(curve.radius), np.cos(curve.angle(S)), atol=2e-9)
    np.testing.assert_allclose(slope(curve.height), np.sin(curve.angle(S)), atol=2e-9)
    np.testing.assert_allclose(slope(curve.angle), curve.curvature(S), atol=1e-7)
    for joint in curve.joints:  # the curvature jumps, the angle does not
        sides = np.array([joint - 1e-9, joint + 1e-9])
        assert abs(np.diff(curve.curvature(sides))[0]) > 0.1
        assert abs(np.diff(curve.angle(sides))[0]) < 1e-8


@pytest.mark.parametrize("curve", CLOSED.values(), ids=CLOSED)
def test_closed_meridians_are_smooth_at_their_poles(curve):
    ends = np.array([0.0, curve.length])
    np.testing.assert_allclose(curve.radius(ends), 0, atol=1e-12)
    np.testing.assert_allclose(curve.angle(ends), [0, np.pi], atol=1e-9)
    near = np.array([1e-4, curve.length - 1e-4])  # odd in S: R = S + O(S³)
    np.testing.assert_allclose(curve.radius(near), 1e-4, rtol=1e-7)


def test_length_of_an_ellipse_is_the_elliptic_integral():
    length = CURVES["spheroid"].length
    assert length == pytest.approx(2 * 3.5 * ellipe(1 - (2 / 3.5) ** 2), rel=1e-13)


@pytest.mark.parametrize("name", CLOSED)
def test_the_angle_of_a_polar_cap_is_measured_at_the_middle_of_the_axis(name):
    curve = CLOSED[name]
    middle = curve.height(np.array([0.0, curve.length])).mean()
    for angle in (0.3, 1.0, 2.0, np.pi):
        for pole, sign in (("bottom", -1), ("top", 1)):
            S = np.array([polar_extent(curve, pole, angle)])
            height = sign * (curve.height(S) - middle)
            assert np.arctan2(curve.radius(S), height)[0] == pytest.approx(angle, abs=1e-8)
