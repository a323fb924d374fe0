"""Zones of the wall: thickness and modulus by arc length, against closed forms."""

import numpy as np
import pytest
from scipy.optimize import brentq, root
from support.scenes import BALLOON, BUD

from fenics_yeast import Scene, simulate
from fenics_yeast.scene import SceneError

BALLOON_SCENE = Scene.from_toml(BALLOON)


@pytest.fixture(scope="module")
def coarse(cell_scene: Scene) -> Scene:
    """The bud on few uniform elements, to 30 min in fixed steps."""
    numerics = {"elements": 20, "grading": "uniform", "thickness_points": 3, "step": 2.0}
    changes = {"growth.zone.half_angle": 36, "numerics": numerics, "run": {"end": 30.0}}
    return cell_scene.with_values(changes)


@pytest.mark.parametrize(
    "values", [{"thickness": 0.1}, {"shear_modulus": 40}, {"modulus_factor": 1}]
)
def test_zones_equal_to_the_rest_change_nothing(coarse, values):
    zone = {"from_fraction": 0.4, "to_fraction": 0.9, **values}
    plain = simulate(coarse).history
    zoned = simulate(coarse.with_values({"wall.zone": [zone]})).history
    np.testing.assert_allclose(zoned.volume_ratio, plain.volume_ratio, rtol=1e-12)


@pytest.mark.parametrize("bending", [True, False])
def test_zones_that_cover_the_wall_equal_a_uniform_wall(coarse, bending):
    """Thickness and modulus as functions of arc length, compared with constants."""
    bending_key = {"wall.bending": bending}
    wall = {"wall.thickness": 0.15, "wall.shear_modulus": 60.0, **bending_key}
    plain = simulate(coarse.with_values(wall)).history
    whole = {"thickness": 0.15, "modulus_factor": 1.5}
    halves = [
        {"from_fraction": 0.0, "to_fraction": 0.5, **whole},
        {"from_fraction": 0.5, "to_fraction": 1.0, **whole},
    ]
    zoned = simulate(coarse.with_values({"wall.zone": halves, **bending_key})).history
    np.testing.assert_allclose(zoned.volume_ratio, plain.volume_ratio, rtol=1e-9)
    np.testing.assert_allclose(
        zoned.dissipation_rate, plain.dissipation_rate, rtol=1e-5, atol=1e-12
    )
    assert plain.volume_ratio[-1] > 1.01


@pytest.mark.parametrize(("thicker", "stiffer"), [(2.0, 1.0), (1.0, 3.0), (1.5, 0.8)])
def test_each_half_of_a_sphere_is_stretched_as_its_own_wall(thicker, stiffer):
    """Far from where they meet, p R/(μ h) = 2 (1/λ - λ⁻⁷): a membrane is statically determinate.

    The difference where they meet decays over R times the square root of the strain.
    """
    R, h, mu, p = 2.5, 0.02, 40.0, 0.03
    zone = {"pole": "top", "half_angle": 90, "thickness": thicker * h, "modulus_factor": stiffer}
    values = {"wall.thickness": h, "turgor.pressure": p, "wall.zone": [zone]}
    wall = simulate(BALLOON_SCENE.with_values({**values, "numerics.elements": 60})).profiles.at(0)
    found = wall.strain.mean(axis=(1, 2))[[0, -1]]
    for strain, stiffness in zip(found, (h * mu, h * mu * thicker * stiffer), strict=True):
        stretch = brentq(lambda x, k=stiffness: 2 * (1 / x - x**-7) - p * R / k, 1, 1.3)
        assert strain == pytest.approx(np.log(stretch), rel=2e-4)
    assert found[0] > 0.006


def test_a_cylinder_of_two_moduli_has_the_membrane_solution():
    """Each half far from its edges: hoop equilibrium, and one axial force in both.

    With ψ(λ1, λ2) of a neo-Hookean membrane, h ∂ψ/∂λ2 = p R λ1 λ2 in each half, and
    h ∂ψ/∂λ1 - p R λ2²/2 is the same in both, whose lengths add up to that between the edges.
    """
    R, h, mu, p, factor = 1.0, 0.003, 40.0, 0.03, 3.0
    zone = {"from_fraction": 0.5, "to_fraction": 1.0, "modulus_factor": factor}
    scene = BALLOON_SCENE.with_values(
        {
            "cell": {"shape": "cylinder", "diameter": 2 * R, "length": 12.0, "edge": "sliding"},
            "wall.thickness": h,
            "turgor.pressure": p,
            "wall.zone": [zone],
            "numerics.elements": 60,
        }
    )
    wall = simulate(scene).profiles.at(0)

    def residual(x):
        first, second = x[:2], x[2:]

        def half(a, b, k):
            tension = k * h * np.array([a - a**-3 * b**-2, b - b**-3 * a**-2])
            return tension[1] - p * R * a * b, tension[0] - p * R * b**2 / 2

        (hoop, force), (other_hoop, other_force) = half(*first, mu), half(*second, factor * mu)
        return [hoop, other_hoop, force - other_force, first[0] + second[0] - 2]

    expected = root(residual, [1.0, 1.05, 1.0, 1.02], tol=1e-13).x
    for S, stretches in ((3.0, expected[:2]), (9.0, expected[2:])):
        nearest = np.argmin(np.abs(wall.S_points - S))
        strains = wall.strain[nearest].mean(axis=0)
        np.testing.assert_allclose(strains, np.log(stretches), rtol=0, atol=1e-5)
    assert expected[1] > 1.05
    assert expected[0] - 1 > 5e-4


def test_a_stiffer_ring_expands_less(coarse):
    """Down to the unloaded radius."""
    radii = []
    for factor in (1.0, 10.0, 100.0):
        zone = {"from_fraction": 0.75, "to_fraction": 0.8, "modulus_factor": factor}
        history = simulate(coarse.with_values({"wall.zone": [zone]})).history
        radii.append(history.neck_radius_um[-1])
    unloaded = 2.5 * np.sin(np.deg2rad(36))
    assert radii == sorted(radii, reverse=True)
    assert radii[0] > 1.05 * unloaded
    assert radii[-1] == pytest.approx(unloaded, rel=1e-2)


def test_zones_of_the_wall_survive_a_round_trip_through_toml(coarse):
    text = BUD.replace(
        "[turgor]", '[[wall.zone]]\nfrom = "6 um"\nto = 7\nthickness = 0.2\n[turgor]'
    )
    scene = Scene.from_toml(text)
    assert scene.wall.zone[0].thickness == 0.2
    assert Scene.from_toml(scene.to_toml()) == scene
    assert scene.with_values({"wall.zone.0.to": 7.5}).wall.zone[0].to == 7.5


@pytest.mark.parametrize(
    ("zone", "said"),
    [
        ({"from": 1, "to": 2}, ["wall.zone[0] = ", "a thickness, a shear_modulus or a modulus"]),
        ({"from": 1, "thickness": 0.2}, ["wall.zone[0].to is missing"]),
        ({"from": 1, "to": 2, "thickness": 3}, ["wall.zone[0].thickness = 3", "radius (2.5 µm)"]),
        (
            {"from": 1, "to": 9, "thickness": 0.2},
            ["wall.zone[0]", "meridian's length (7.85398 µm)"],
        ),
        (
            {"from": 1, "to": 2, "shear_modulus": 3, "modulus_factor": 3},
            ["wall.zone[0].modulus_factor = 3", "either shear_modulus or modulus_factor"],
        ),
        ({"from": 1, "to": 2, "modulus_factor": -1}, ["modulus_factor = -1", "> 0"]),
        (3, ["wall.zone[0] = 3: expected a table [wall.zone[0]]"]),
    ],
)
def test_invalid_zones_of_the_wall_are_reported_on_one_line(zone, said):
    with pytest.raises(SceneError) as caught:
        BALLOON_SCENE.with_values({"wall.zone": [zone]})
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    for part in said:
        assert part in message


def test_zones_of_a_wall_with_several_moduli_need_modulus_factor():
    wall = {"thickness": 0.1, "law": "linear", "young_modulus": 100, "poisson_ratio": 0.3}
    zone = {"from": 1, "to": 2, "shear_modulus": 30}
    with pytest.raises(SceneError, match=r"shear_modulus = 30: this law needs modulus_factor"):
        BALLOON_SCENE.with_values({"wall": {**wall, "zone": [zone]}})
