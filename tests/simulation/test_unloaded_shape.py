"""The unloaded shape of a turgid outline: closed forms, and shapes that are inflated to it."""

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from support.shapes import ellipse, parametric

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast.geometry import signed_distances
from fenics_yeast.simulation import (
    UnloadedShapeError,
    build_shell,
    discretise,
    find_unloaded,
    fit_of,
    has_exact_sensitivity,
    pieces,
)
from fenics_yeast.studies import simulate_with_derivatives

WALL = {"thickness": 0.1, "shear_modulus": 40.0, "ogden_exponent": 2.0}


def scene(cell: dict, pressure: float, **tables) -> Scene:
    wall = WALL | tables.pop("wall", {})
    return Scene.model_validate(
        {"cell": cell, "wall": wall, "turgor": {"pressure": pressure}, **tables}
    )


def turgid(r, z, pressure: float, **tables) -> Scene:
    """A scene of a turgid outline through points."""
    cell = {"shape": "profile", "r": [*map(float, r)], "z": [*map(float, z)], "tolerance": 0.0,
            "outline_is": "turgid"}  # fmt: skip
    return scene(cell | tables.pop("cell", {}), pressure, **tables)


def unloaded(found: Scene) -> np.ndarray:
    """Places `(r, z)` of the unloaded shape that was found."""
    return np.column_stack([found.cell.unloaded.r, found.cell.unloaded.z])


# Closed forms ---------------------------------------------------------------------------------


@pytest.mark.distributed
@pytest.mark.parametrize("stretch", [1.02, 1.1, 1.2, 1.3])
def test_a_spherical_membrane_shrinks_by_the_stretch_of_its_closed_form(stretch):
    """p r/(2 μ h) = 1 - λ⁻⁶, for the radius r under pressure."""
    pressure = 2 * 40.0 * 0.1 * (1 - stretch**-6) / 3.0
    outline = turgid(*ellipse(80, 3.0, 3.0), pressure, wall={"bending": False})
    places = unloaded(find_unloaded(outline)) + np.array([0.0, 3.0 * (1 - 1 / stretch)])
    np.testing.assert_allclose(np.hypot(*places.T), 3.0 / stretch, rtol=1e-5)


def test_a_thin_wall_shrinks_as_a_membrane_in_its_local_equilibrium():
    """Around an ellipse: N1 = p R2/2, N2 = N1 (2 - κ1 R2), and the wall's law gives stretches."""
    a, c, pressure, mu, h = 2.0, 2.5, 0.3, 40.0, 0.1
    found = find_unloaded(turgid(*ellipse(160, a, c), pressure, wall={"bending": False}))
    outline, S = found.cell.curve, np.array(found.cell.unloaded.S)
    r, z, places = outline.radius(S), outline.height(S), unloaded(found)
    across = np.hypot(a**2 / c**2 * z, r)
    bend = outline.curvature(S)
    inner = slice(5, -5)

    def balance(stretches, one, two):
        l1, l2 = stretches
        rest = (l1 * l2) ** -2
        return [mu * h * (l1**2 - rest) / (l1 * l2) - one,
                mu * h * (l2**2 - rest) / (l1 * l2) - two]  # fmt: skip

    expected = []
    for R2, k in zip(across[inner], bend[inner], strict=True):
        N1 = pressure * R2 / 2
        expected.append(fsolve(balance, (1.05, 1.05), (N1, N1 * (2 - k * R2)), xtol=1e-12))
    hoop = np.array(expected)[:, 1]
    np.testing.assert_allclose(places[inner, 0], r[inner] / hoop, rtol=3e-5)


# There and back -------------------------------------------------------------------------------

ROUND_TRIPS = {
    "capsule": ({"shape": "capsule", "diameter": 4.0, "length": 10.0}, 0.4),
    "prolate": ({"shape": "spheroid", "diameter": 5.0, "height": 8.0}, 0.9),
    "oblate": ({"shape": "spheroid", "diameter": 5.0, "height": 3.5}, 0.5),
    "sphere, stretch 1.3": ({"shape": "sphere", "diameter": 5.0}, 1.95),
    "clamped": ({"shape": "cap", "radius": 2.5, "half_angle": 120.0, "edge": "clamped"}, 0.4),
    "hinged": ({"shape": "cap", "radius": 2.5, "half_angle": 100.0, "edge": "hinged"}, 0.4),
    "guided": ({"shape": "cap", "radius": 2.5, "half_angle": 80.0, "edge": "guided"}, 0.4),
}


@pytest.mark.parametrize("name", ROUND_TRIPS)
def test_the_unloaded_shape_of_an_inflated_one_is_recovered(name):
    """To 2e-5 of the cell's size; the spline through the outline limits that of a capsule."""
    cell, pressure = ROUND_TRIPS[name]
    numerics = {"elements": 60}
    known = scene(cell, pressure, numerics=numerics)
    inflated = simulate(known).profiles.all[-1]
    edge = {"edge": cell["edge"]} if "edge" in cell else {}
    found = find_unloaded(turgid(inflated.r, inflated.z, pressure, cell=edge, numerics=numerics))
    curve = known.cell.curve
    places = unloaded(found) - np.array([0.0, found.cell.unloaded.z[0]])
    places[:, 1] += curve.height(np.zeros(1))
    away = signed_distances(parametric(curve), places)
    assert abs(away.distance).max() < 2e-5 * known.cell.radius
    again = simulate(found)
    assert again.history.rows[-1].volume_ratio == pytest.approx(
        simulate(known).history.rows[-1].volume_ratio, rel=1e-5
    )


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_a_run_begins_at_the_outline(preset):
    outline = turgid(*ellipse(120, 2.5, 3.0), 0.3, numerics={"preset": preset})
    result = simulate(outline)
    inflated = result.profiles.all[-1]
    away = signed_distances(outline.cell.curve, np.column_stack([inflated.r, inflated.z]))
    assert abs(away.distance).max() < 3e-6
    assert result.unloaded is not None
    assert result.unloaded.residual_distance_um < 2.5e-6
    row = result.history.rows[-1]
    assert row.volume_um3 == pytest.approx(4 / 3 * np.pi * 2.5**2 * 3.0, rel=2e-5)
    assert row.volume_ratio > 1.05


def test_a_small_pressure_moves_an_outline_in_proportion():
    moved = [
        fit_of(find_unloaded(turgid(*ellipse(80, 2.5, 3.0), p))).largest_displacement_um
        for p in (1e-3, 2e-3)
    ]
    assert moved[1] / moved[0] == pytest.approx(2, rel=2e-3)


# Zones, loads and growth ----------------------------------------------------------------------

GROWTH = {
    "growth": {"zone": {"pole": "top", "half_angle": 24.0}, "threshold": 0.9, "time": 45.0},
    "run": {"end": 10.0},
}


def test_zones_are_places_of_the_outline():
    """The edge of the zone is where the outline is seen at its angle; the wall has not grown."""
    outline = turgid(*ellipse(120, 2.5, 3.0), 0.3, **GROWTH)
    quiet = outline.with_values({"growth.threshold": 50.0})
    neck = simulate(quiet).history.rows[-1].neck_radius_um
    curve = outline.cell.curve

    def angle(S):
        S = np.array([S])
        return np.rad2deg(np.arctan2(curve.radius(S), curve.height(S)))[0] - 24

    edge = brentq(angle, 0.5 * curve.length, curve.length - 0.1)
    assert neck == pytest.approx(curve.radius(np.array([edge]))[0], rel=1e-5)


def test_growth_force_and_septum_do_not_change_the_unloaded_shape():
    outline = turgid(*ellipse(120, 2.5, 3.0), 0.3, numerics={"elements": 40})
    alone = find_unloaded(outline)
    others = [
        GROWTH, {"load": {"point_force": -0.1}}, GROWTH | {"septum": {}},
        {"path": {"until": {"pressure": 0.5}}},
    ]  # fmt: skip
    S = np.linspace(0, outline.cell.curve.length, 50)
    expected = alone.cell.reference(S)[0]
    for tables in others:
        found = find_unloaded(outline.with_values(tables))
        curve, places = found.cell.reference(S)
        assert curve.length == pytest.approx(expected.length, rel=1e-6)
        np.testing.assert_allclose(places, alone.cell.reference(S)[1], atol=5e-6)


def test_a_piece_has_the_unloaded_shape_of_the_whole_to_the_last_bit():
    outline = turgid(*ellipse(120, 2.5, 3.0), 0.3, **GROWTH, septum={})
    found = find_unloaded(outline)
    for piece in pieces(outline, 5.0):
        assert find_unloaded(piece).cell.unloaded == found.cell.unloaded


# Derivatives ----------------------------------------------------------------------------------


def test_a_derivative_by_turgor_includes_the_change_of_the_unloaded_shape():
    """V/V0 = λ³ with 1 - λ⁻⁶ = p r/(2 μ h), by differences."""
    stretch, radius = 1.1, 3.0
    pressure = 2 * 40.0 * 0.1 * (1 - stretch**-6) / radius
    outline = turgid(*ellipse(80, radius, radius), pressure, wall={"bending": False},
                     run={"end": 1.0, "save": [1.0]})  # fmt: skip
    keys = ["turgor.pressure", "wall.shear_modulus"]
    assert not any(has_exact_sensitivity(outline, key) for key in keys)
    assert has_exact_sensitivity(outline.with_values(GROWTH), "growth.threshold")
    with pytest.raises(SceneError, match="as the unloaded shape depends on it; use studies"):
        simulate(outline, sensitivities=keys)
    found = simulate_with_derivatives(outline, keys).sensitivities
    by_pressure = 3 * stretch**2 * stretch**7 / 6 * radius / (2 * 40.0 * 0.1)
    assert found.volume_ratio[-1] == pytest.approx(
        [by_pressure, -by_pressure * pressure / 40.0], rel=1e-4
    )


# What is kept ---------------------------------------------------------------------------------


def test_the_shape_is_found_once_for_a_scene_and_again_when_its_inputs_change():
    outline = turgid(*ellipse(80, 2.5, 3.0), 0.3)
    found = find_unloaded(outline)
    assert find_unloaded(found) is found
    assert found == outline and hash(found) == hash(outline)
    written = Scene.from_toml(found.to_toml())
    assert find_unloaded(written) is written
    assert written.cell.unloaded == found.cell.unloaded
    assert find_unloaded(outline).cell.unloaded == found.cell.unloaded  # to the last bit
    for key, value in (
        ("turgor.pressure", 0.2),
        ("wall.thickness", 0.12),
        ("cell.tolerance", 0.01),
    ):
        other = find_unloaded(found.with_values({key: value}))
        assert other.cell.unloaded != found.cell.unloaded
    later = found.with_values({"turgor.ramp": 0.1})
    assert find_unloaded(later) is later


def test_an_own_law_is_inverted_too():
    def soft(eps, mu):
        import ufl

        return mu / 2 * (ufl.exp(2 * eps[0]) + ufl.exp(2 * eps[1])
                         + ufl.exp(-2 * (eps[0] + eps[1])))  # fmt: skip

    from fenics_yeast.mechanics import Law

    outline = turgid(*ellipse(80, 2.5, 3.0), 0.3)
    own = find_unloaded(outline, energy=Law(soft, {"mu": 40.0}))
    np.testing.assert_allclose(unloaded(own), unloaded(find_unloaded(outline)), atol=1e-5)


def test_without_a_run_the_unloaded_shape_is_unknown():
    outline = turgid(*ellipse(80, 2.5, 3.0), 0.3)
    for use in (discretise, build_shell):
        with pytest.raises(ValueError, match="found by a run; see find_unloaded"):
            use(outline)


# Refused --------------------------------------------------------------------------------------


def test_a_wall_that_cannot_carry_the_turgor_has_no_unloaded_shape():
    """A membrane carries at most p r = 2 μ h: here 2.67 MPa."""
    outline = turgid(*ellipse(80, 3.0, 3.0), 2.7)
    with pytest.raises(UnloadedShapeError) as caught:
        find_unloaded(outline)
    assert str(caught.value).startswith("no unloaded shape found for the turgid outline: beyond 2.")
    assert "of 2.7 MPa" in str(caught.value) and "check turgor.pressure" in str(caught.value)
