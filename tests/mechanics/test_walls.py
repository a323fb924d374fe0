"""Walls not in the paper: other energies, energy per grown volume, thinning, membranes.

A sphere of radius R and thickness h that is stretched by λ = e g, with e its elastic part and g its
growth, carries the Cauchy stress p R λ / 2h where its thickness stays.
"""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from fenics_yeast import simulate
from fenics_yeast.scene import LinearWall, OgdenWall, Scene, StaticPath, Until
from fenics_yeast.simulation import Result, build_shell

MU, H, R, P = 40.0, 0.1, 2.5, 0.20265
UNIT = MU * H / R
LOAD = P / UNIT


def balloon(e, alpha: float = 2.0):
    """p R/(μ h) of a membrane with one Ogden term and nothing grown."""
    return 4 / alpha * (e ** (alpha - 3) - e ** (-2 * alpha - 3))


def inflate(scene: Scene, wall, volume_ratio: float = 2.0) -> Result:
    path = StaticPath(until=Until(volume_ratio=volume_ratio), steps=8)
    result = simulate(scene.with_values({"wall": wall, "path": path}))
    assert result.status == "finished"
    return result


def test_terms_of_an_ogden_wall_add_up(elastic_scene: Scene) -> None:
    moduli, exponents = (30.0, -4.0, 2.0), (2.0, -2.0, 5.0)
    wall = OgdenWall(thickness=H, shear_moduli=moduli, ogden_exponents=exponents)
    assert wall.shear_modulus == 28
    history = inflate(elastic_scene, wall).history
    stretch = history.volume_ratio ** (1 / 3)
    terms = zip(moduli, exponents, strict=True)
    expected = sum(mu * H / R * balloon(stretch, alpha) for mu, alpha in terms)
    np.testing.assert_allclose(history.pressure_MPa, expected, atol=2e-4 * expected.max())


def test_terms_of_one_exponent_equal_one_term(elastic_scene: Scene) -> None:
    one = OgdenWall(thickness=H, shear_moduli=[MU / 4, MU * 3 / 4], ogden_exponents=[3.0, 3.0])
    plain = {"thickness": H, "shear_modulus": MU, "ogden_exponent": 3.0}
    pressures = [inflate(elastic_scene, wall).history.pressure_MPa for wall in (one, plain)]
    np.testing.assert_allclose(*pressures, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("poisson", [0.3, 0.5, -0.2])
def test_a_saint_venant_kirchhoff_sphere_has_the_closed_form(
    elastic_scene: Scene, poisson: float
) -> None:
    """ψ = E ε²/(1-ν) with ε = (λ²-1)/2 in both directions, p R/h = ψ'(λ)/λ²."""
    wall = LinearWall(law="linear", thickness=H, young_modulus=100.0, poisson_ratio=poisson)
    history = inflate(elastic_scene, wall).history
    stretch = history.volume_ratio ** (1 / 3)
    expected = 100 * H / R / (1 - poisson) * (stretch**2 - 1) / stretch
    np.testing.assert_allclose(history.pressure_MPa, expected, atol=2e-4 * expected.max())


# --- growing spheres --------------------------------------------------------------------------


def rate(e: float, g: float, thins: bool) -> float:
    """Rate of ln g by equation (13); both growth strains are equal."""
    stress = LOAD * MU * e * g / 2 * (e**2 if thins else 1)
    return max(0.0, 2**0.5 * stress - 1) / (2**0.5 * 45)


def elastic_stretch(g: float, power: int) -> float:
    return brentq(lambda e: balloon(e) - LOAD * g**power, 1, 7 ** (1 / 6), xtol=1e-15)


WALLS = {
    "as the paper's": ({}, 3, False),
    "per grown volume": ({"energy_per": "grown"}, 1, False),
    "thinning": ({"thickness_change": "elastic"}, 3, True),
}


@pytest.mark.parametrize(("keys", "power", "thins"), WALLS.values(), ids=WALLS)
def test_growing_spheres_follow_their_differential_equation(
    sphere_scene: Scene, keys: dict, power: int, thins: bool
) -> None:
    """p R/(μ h) g³ = 2 (1/e - e⁻⁷); per grown volume g in place of g³: the wall grows stiffer."""
    values = {f"wall.{key}": value for key, value in keys.items()} | {"wall.bending": False}
    result = simulate(sphere_scene.with_values({**values, "numerics.step": 0.2}))
    end = result.end_time
    assert result.status == "finished" and end == 8

    def slope(_, y):
        g = np.exp(y[0])
        return [rate(elastic_stretch(g, power), g, thins)]

    grown = np.exp(solve_ivp(slope, (0, end), [0.0], rtol=1e-10, atol=1e-12).y[0, -1])
    expected = (elastic_stretch(grown, power) * grown) ** 3
    assert grown > 1.1
    assert result.history.volume_ratio[-1] == pytest.approx(expected, rel=2e-5)


def test_a_wall_per_grown_volume_reaches_three_times_the_growth_strain(
    sphere_scene: Scene,
) -> None:
    """It ends where p R g/(μ h), not p R g³/(μ h), meets the limit 1.2395 of its elasticity.

    It does not soften, but a sphere of constant thickness carries a stress that grows with its
    radius: `d ln g/dt` grows with g, so that this end comes in finite time as well.
    """

    def end(power: int) -> float:
        """Time to the limit point, by quadrature over e."""

        def duration(e: float) -> float:
            by_e = (-2 * e**-2 + 14 * e**-8) / balloon(e) / power
            return by_e / rate(e, (balloon(e) / LOAD) ** (1 / power), False)

        return quad(duration, elastic_stretch(1.0, power), 7 ** (1 / 6))[0]

    for per, power in (("reference", 3), ("grown", 1)):
        values = {
            "wall.energy_per": per,
            "wall.bending": False,
            "run": {"end": 100.0},
            "numerics.step": "adaptive",
            "numerics.tolerance": 1e-6,
        }
        result = simulate(sphere_scene.with_values(values))
        assert result.status == "no-equilibrium"
        assert ("softened" in result.message) == (per == "reference")
        assert result.end_time == pytest.approx(end(power), rel=2e-4)
        largest = np.log(1.239463 / LOAD) / power
        assert result.history.max_growth_strain[-1] == pytest.approx(largest, rel=0.02)


def test_thinning_increases_the_stress(elastic_scene: Scene) -> None:
    """σ = p r/2h with the current thickness h/e² in place of h."""
    stress = []
    for change in ("none", "elastic"):
        values = {"wall.thickness_change": change, "wall.bending": False, "numerics.elements": 24}
        result = simulate(elastic_scene.with_values(values))
        stress.append(result.profiles.all[-1].stress.mean())
    e = elastic_stretch(1.0, 3)
    assert stress == pytest.approx([P * R * e / (2 * H), P * R * e**3 / (2 * H)], rel=1e-6)


# --- membranes --------------------------------------------------------------------------------


def test_a_membrane_sphere_has_the_closed_form_to_the_last_digits(elastic_scene: Scene) -> None:
    values = {"wall.bending": False, "path": StaticPath(until=Until(volume_ratio=8.0), steps=20)}
    scene = elastic_scene.with_values(values)
    result = simulate(scene)
    history = result.history
    stretch = history.volume_ratio ** (1 / 3)
    np.testing.assert_allclose(history.pressure_MPa / UNIT, balloon(stretch), atol=1e-7)
    assert "past a limit point" in result.message
    nodes = 12 * 3 + 1
    assert result.dofs == 2 * nodes  # no rotation, no shear force
    wall = result.profiles.all[-1]
    assert wall.strain.shape[1] == 1 and wall.xi == [0]
    np.testing.assert_allclose(wall.psi, wall.S / R, atol=0.02)
    assert build_shell(scene).points.degree == 5


# Pole stretch, p R/(μ h), w/R of a flat neo-Hookean disc with a constrained edge: membrane theory's
# ordinary differential equations, integrated to 1e-11.
DISC = [(1.05, 0.234941, 0.274093), (1.1, 0.527782, 0.383472), (1.5, 1.643582, 0.798789),
        (3.0, 1.807922, 1.488846)]  # fmt: skip


@pytest.mark.parametrize(("stretch", "load", "rise"), DISC)
def test_a_flat_membrane_inflates_as_its_differential_equations(
    elastic_scene, stretch, load, rise
) -> None:
    """From its plane, where it has no stiffness, at pressures below the limit point."""
    values = {"cell": {"shape": "disc", "diameter": 2 * R}, "wall.bending": False,
              "numerics.elements": 40, "numerics.grading": "uniform"}  # fmt: skip
    scene = elastic_scene.with_values(values)
    if stretch < 2:
        result = simulate(scene.with_values({"turgor.pressure": load * UNIT}))
        found = result.history.pole_height_um[-1] / R
        assert found == pytest.approx(rise, rel=1e-5)
        at_pole = np.exp(result.profiles.all[-1].strain[-1, 0])
        np.testing.assert_allclose(at_pole, stretch, rtol=2e-4)
    else:
        path = StaticPath(until=Until(volume_ratio=3.0), steps=60)
        history = simulate(scene.with_values({"path": path})).history
        found = np.interp(rise, history.pole_height_um / R, history.pressure_MPa / UNIT)
        assert found == pytest.approx(load, rel=2e-4)
        assert history.pressure_MPa.max() / UNIT == pytest.approx(1.87917, rel=2e-4)


def test_a_ring_without_bending_is_refused(elastic_scene: Scene) -> None:
    ring = {"shape": "cone", "outer_diameter": 4, "inner_diameter": 1, "height": 0}
    with pytest.raises(ValueError, match=r"wall.bending = false: a flat membrane ring"):
        elastic_scene.with_values({"cell": ring, "wall.bending": False})
