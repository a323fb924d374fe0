"""Distances of points from a meridian along its normals: closed forms."""

import numpy as np
import pytest
from support.shapes import parametric

from fenics_yeast.geometry import (
    Cap,
    Sphere,
    aligned_distances,
    curve_through,
    displaced,
    signed_distances,
    spheroid,
)

SPHERE = parametric(Sphere(2.5))
EGG = spheroid(2.0, 3.5)


def on_circle(radius: float, number: int = 100, middle: float = 0.0) -> np.ndarray:
    t = np.linspace(0, np.pi, number)
    return np.column_stack([radius * np.sin(t), middle - radius * np.cos(t)])


def off_normal(distance: np.ndarray) -> np.ndarray:
    """Points at some distances from the egg, at as many places along it."""
    t = np.linspace(0, EGG.end, len(distance))
    x, (r_t, z_t) = np.column_stack(EGG.point(t, 0)), EGG.point(t, 1)
    normal = np.column_stack([z_t, -r_t]) / np.hypot(r_t, z_t)[:, None]
    return x + distance[:, None] * normal


@pytest.mark.parametrize("radius", [2.2, 2.5, 3.1])
def test_a_concentric_sphere_is_everywhere_as_far_as_the_radii_differ(radius):
    found = signed_distances(SPHERE, on_circle(radius))
    np.testing.assert_allclose(found.distance, radius - 2.5, atol=1e-12)
    assert found.root_mean_square == pytest.approx(abs(radius - 2.5), abs=1e-12)
    np.testing.assert_allclose(found.normal, on_circle(1.0), atol=1e-6 if radius == 2.5 else 1e-9)


def test_points_along_normals_are_at_the_distance_they_were_put():
    put = 0.2 * np.random.default_rng(1).normal(size=200)
    found = signed_distances(EGG, off_normal(put))
    np.testing.assert_allclose(found.distance, put, atol=1e-12)
    np.testing.assert_allclose(found.t, np.linspace(0, EGG.end, 200), atol=1e-9)


def test_a_point_beyond_the_axis_counts_as_its_mirror_image():
    points = off_normal(np.full(50, 0.1))
    mirrored = points * np.array([-1.0, 1.0])
    assert (
        signed_distances(EGG, mirrored).distance == signed_distances(EGG, points).distance
    ).all()


def test_beyond_an_edge_the_distance_is_that_of_the_edge():
    cap = parametric(Cap(2.5, np.pi / 2))  # its edge is at (2.5, 0)
    found = signed_distances(cap, np.array([[2.8, -0.4], [2.2, -0.4]]))
    np.testing.assert_allclose(found.distance, [0.5, -0.5], atol=1e-12)


@pytest.mark.parametrize("shift", [-40.0, 0.3, 7.0])
def test_alignment_finds_how_far_a_contour_was_shifted(shift):
    points = off_normal(np.full(150, 0.05))
    found = aligned_distances(EGG, points - np.array([0.0, shift]))
    assert found.shift == pytest.approx(shift, abs=1e-8)
    np.testing.assert_allclose(found.distance, 0.05, atol=1e-8)


def test_no_other_shift_fits_better():
    noise = 0.1 * np.random.default_rng(2).normal(size=150)
    best = aligned_distances(EGG, off_normal(noise))
    for more in (-1e-3, 1e-3):
        moved = off_normal(noise) + np.array([0.0, best.shift + more])
        assert signed_distances(EGG, moved).root_mean_square > best.root_mean_square


def test_distances_change_with_the_meridian_by_its_motion_along_the_normal():
    points = off_normal(0.1 * np.random.default_rng(3).normal(size=80))
    t = np.linspace(0, EGG.end, 60)
    motion = np.column_stack([np.sin(t), 0.3 * np.cos(t) ** 2])
    found, small = signed_distances(EGG, points), 1e-5
    there, back = (
        signed_distances(displaced(EGG, t, sign * small * motion, (True, True)), points).distance
        for sign in (1, -1)
    )
    v = np.column_stack(curve_through(t, motion, (True, True)).point(found.t, 0))
    expected = -(found.normal * v).sum(axis=1)
    np.testing.assert_allclose((there - back) / (2 * small), expected, atol=1e-8)


def test_a_curve_through_points_of_a_sphere_is_a_sphere():
    """Its error falls by 2^6 for twice as many points, its curvature's by 2^4."""
    S = np.linspace(0, SPHERE.end, 301)
    errors = []
    for n in (12, 24):
        t = np.linspace(0, np.pi, n + 1)
        curve = curve_through(t, np.column_stack([np.sin(t), -np.cos(t)]), (True, True))
        places = np.column_stack(curve.point(S / 2.5, 0))
        bends = curve.curvature_at(S / 2.5)
        errors.append([abs(np.hypot(*places.T) - 1).max(), abs(bends - 1).max()])
    rates = np.log2(np.divide(*errors))
    assert rates == pytest.approx([6, 4], abs=0.5)
