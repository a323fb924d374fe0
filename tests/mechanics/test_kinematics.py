"""Strains (1) to (7), as plain numbers: UFL's functions of floats are floats."""

import math

import numpy as np
import pytest

from fenics_yeast.mechanics import kinematics
from fenics_yeast.mechanics.growth_strains import elastic_strain, logarithmic_strain
from fenics_yeast.mechanics.kinematics import Meridian, green_lagrange, strains


def sphere(R0: float, S: float) -> Meridian:
    Phi = S / R0
    return Meridian(R0 * math.sin(Phi), math.cos(Phi), math.sin(Phi), Phi, 1 / R0)


def facet(R0: float, S: float) -> Meridian:
    """The same point on a straight conical element tangent to the sphere."""
    return sphere(R0, S)._replace(psi_S=0.0)


def scaled(reference: Meridian, factor: float) -> Meridian:
    r, r_S, z_S, psi, psi_S = reference
    return Meridian(factor * r, factor * r_S, factor * z_S, psi, psi_S)


PLACES = [0.3, 2.0, 5.5]


@pytest.mark.parametrize("S", PLACES)
@pytest.mark.parametrize("shape", [sphere, facet])
def test_wall_at_rest_or_moved_along_the_axis_is_not_strained(shape, S):
    """The height does not enter, so that a translation is the same meridian."""
    reference = shape(2.5, S)
    assert strains(reference, reference) == pytest.approx((0, 0, 0, 0, 0), abs=1e-15)


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.3])
@pytest.mark.parametrize("S", PLACES)
def test_uniform_inflation_gives_its_stretch_in_both_directions(S, factor):
    parts = strains(sphere(2.5, S), scaled(sphere(2.5, S), factor))
    E1, E2 = green_lagrange(parts, 0.0)
    assert kinematics.stretch(E1) == pytest.approx(factor, rel=1e-14)
    assert kinematics.stretch(E2) == pytest.approx(factor, rel=1e-14)
    assert logarithmic_strain(E1) == pytest.approx(math.log(factor), abs=1e-14)
    assert elastic_strain(logarithmic_strain(E2), 0.1) == pytest.approx(
        math.log(factor) - 0.1, abs=1e-14
    )
    assert parts.gamma == pytest.approx(0, abs=1e-15)


def test_inflated_sphere_bends_alike_in_both_directions_but_its_facets_do_not():
    """A straight element has no curvature: its strain lacks the term (λ - 1) Φ'."""
    factor, R0, S = 1.2, 2.5, 2.0
    parts = strains(sphere(R0, S), scaled(sphere(R0, S), factor))
    assert parts.E1b == pytest.approx((factor - 1) / R0, rel=1e-13)
    assert parts.E2b == pytest.approx((factor - 1) / R0, rel=1e-13)
    faceted = strains(facet(R0, S), scaled(facet(R0, S), factor))
    assert faceted.E1b == 0
    assert faceted.E2b == pytest.approx((factor - 1) / R0, rel=1e-13)
    assert (faceted.E1m, faceted.E2m) == (parts.E1m, parts.E2m)


@pytest.mark.parametrize("angle", [-0.4, 0.1, 1.0])
def test_turned_director_shears_the_wall(angle):
    reference = sphere(2.5, 2.0)
    parts = strains(reference, reference._replace(psi=reference.psi + angle))
    assert parts.gamma == pytest.approx(math.sin(angle), rel=1e-13)
    assert (parts.E1m, parts.E2m) == pytest.approx((0, 0), abs=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_strains_are_those_of_the_points_beside_the_mid_surface(seed):
    """Metric of `x + ξ n` with the outward director n, against that of `X + ξ N`, to first order.

    The metrics are quadratic in ξ, so that central differences give the linear term exactly.
    """
    random = np.random.default_rng(seed)
    R, Phi, Phi_S = random.uniform(0.5, 3), random.uniform(0, np.pi), random.normal()
    r, r_S, z_S, psi, psi_S = random.normal(size=5)
    reference = Meridian(R, math.cos(Phi), math.sin(Phi), Phi, Phi_S)
    current = Meridian(r, r_S, z_S, psi, psi_S)

    def metric(at: Meridian, xi: float) -> tuple[float, float, float]:
        along = np.array([at.r_S, at.z_S])
        along += xi * at.psi_S * np.array([np.cos(at.psi), np.sin(at.psi)])
        director = np.array([np.sin(at.psi), -np.cos(at.psi)])
        return along @ along, (at.r + xi * director[0]) ** 2, along @ director

    def strain(xi: float) -> np.ndarray:
        change = np.subtract(metric(current, xi), metric(reference, xi))
        return change * [1 / 2, 1 / (2 * R**2), 1]

    parts, xi = strains(reference, current), 0.05
    middle, slope = strain(0.0), (strain(xi) - strain(-xi)) / (2 * xi)
    assert (parts.E1m, parts.E2m, parts.gamma) == pytest.approx(middle, rel=1e-12)
    assert (parts.E1b, parts.E2b) == pytest.approx(slope[:2], rel=1e-11)
    assert green_lagrange(parts, xi) == pytest.approx(middle[:2] + xi * slope[:2], rel=1e-11)
