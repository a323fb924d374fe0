"""Growth (12) and (13): its direction, threshold and rate, its dissipation, its implicit update."""

import numpy as np
import pytest
import ufl

from fenics_yeast import _dolfinx as dx
from fenics_yeast import simulate
from fenics_yeast.mechanics import GrowthState, QuadraturePoints
from fenics_yeast.mechanics import growth_laws as growth
from fenics_yeast.mechanics import hyperelasticity as wall
from fenics_yeast.simulation import build_shell

ELEMENT = np.array([0], dtype=np.int32)
SIGMA_TRS, T_GRW = 1.0, 45.0


@pytest.fixture(scope="module")
def law(one_element):
    """Growth rate and dissipation of the package at a point, for σ_trs = 1 MPa, t_grw = 45 min."""
    tau, eps, eps_g = (dx.fem.Constant(one_element, np.zeros(2)) for _ in range(3))
    point = growth.WallPoint(tau, eps, eps_g)
    rate = growth.stress_driven(point, SIGMA_TRS, T_GRW)
    values = ufl.as_vector([rate[0], rate[1], growth.dissipation(point, rate)])
    expression = dx.compile_expression(values, np.array([[0.5]]))

    def evaluate(tau_value, eps_value=(0, 0), eps_g_value=(0, 0)):
        tau.value[:], eps.value[:], eps_g.value[:] = tau_value, eps_value, eps_g_value
        *rates, dissipation = dx.evaluator(expression, one_element, ELEMENT)()[0]
        return np.array(rates), dissipation

    return evaluate


def test_rate_is_the_excess_of_the_true_stress_over_the_threshold(law):
    """‖τ‖ = 5, J = 2.5: the true stress is twice the threshold, so that the rate is 1/t_grw."""
    rate, dissipation = law((3, 4), eps_value=(np.log(2.0), np.log(1.25)))
    np.testing.assert_allclose(rate, np.array([0.6, 0.8]) / T_GRW, rtol=1e-13)
    assert dissipation == pytest.approx(5 / T_GRW, rel=1e-13)


@pytest.mark.parametrize("angle", np.deg2rad([0, 30, 45, 90, 135, 200, 300]))
def test_growth_follows_the_stress(law, angle):
    """In tension, in compression and in both; the wall shrinks under compression."""
    direction = np.array([np.cos(angle), np.sin(angle)])
    rate, dissipation = law(3 * direction)
    np.testing.assert_allclose(rate, 2 / T_GRW * direction, rtol=1e-12, atol=1e-15)
    assert dissipation > 0


@pytest.mark.parametrize("size", [0.0, 1e-9, 0.5, 0.999999])
def test_no_growth_below_the_threshold(law, size):
    rate, dissipation = law((0.6 * size, -0.8 * size))
    np.testing.assert_array_equal(rate, 0)
    assert dissipation == 0
    assert law((0.6 * 1.000001, -0.8 * 1.000001))[1] > 0


def test_growth_strain_does_not_enter_the_rate(law):
    """The law reads stress and total strain; the energy is per reference volume."""
    np.testing.assert_array_equal(law((3, 4))[0], law((3, 4), eps_g_value=(0.3, 0.1))[0])


# --- the implicit update ------------------------------------------------------------------


@pytest.fixture(scope="module")
def point(one_element):
    """Growth state of one point of a wall whose total strain is given."""
    strain = dx.fem.Constant(one_element, np.zeros(2))

    def energy(eps):
        return wall.ogden(eps, 40.0, 2.0)

    def rate(at):
        return growth.stress_driven(at, SIGMA_TRS, T_GRW)

    points = QuadraturePoints(one_element, ELEMENT, degree=1)
    state = GrowthState(points, [strain], wall.Material(energy), rate)
    return strain, state


def rate_in_numpy(eps: np.ndarray, eps_g: np.ndarray) -> np.ndarray:
    e = eps - eps_g
    tau = 40 * (np.exp(2 * e) - np.exp(-2 * e.sum()))
    size = np.linalg.norm(tau)
    return max(size * np.exp(-eps.sum()) / SIGMA_TRS - 1, 0) / T_GRW * tau / size


@pytest.mark.parametrize("stage", [0.01, 1.0, 6.0])
@pytest.mark.parametrize("strain", [(0.02, 0.015), (0.04, -0.02), (0.001, 0.0), (-0.03, -0.01)])
def test_update_solves_the_equation_of_its_stage(point, strain, stage):
    """From the base, for short and long stages; at the third strain there is no growth."""
    eps, state = point
    eps.value[:], state.stage.value = strain, stage
    base = np.array([0.004, -0.003])
    state.set_base(base[None, :])
    state.set(base[None, :])
    assert state.update()
    found = state.get()[0]
    expected = base + stage * rate_in_numpy(np.array(strain), found)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(
        state.rate()[0], rate_in_numpy(np.array(strain), found), rtol=1e-9, atol=1e-15
    )


# --- in a shell ---------------------------------------------------------------------------


def test_an_elastic_wall_has_no_growth_state(elastic_scene):
    shell = build_shell(elastic_scene)
    assert shell.growth is None
    assert shell.dissipation_rate() == 0
    assert len(shell.growing_points.elements) == 0


def test_growth_is_zero_outside_the_zone(bud_run, fine_scene):
    profile = bud_run.profiles.at(90.0)
    grown = np.abs(profile.growth_strain).max(axis=(1, 2))
    edge = np.pi * 2.5 * (1 - 24 / 180)
    assert np.all(grown[profile.S_points < edge] == 0)
    assert grown[profile.S_points > edge].max() > 0.1


def test_dissipation_is_never_negative(bud_run):
    """It is positive while the bud grows, which it does throughout."""
    assert np.all(bud_run.history.dissipation_rate > 0)


@pytest.mark.distributed
def test_dissipation_of_a_sphere_is_that_of_its_stress(sphere_scene):
    """`τ_i dε_i^g/dt` of a membrane in volume `4 π R0² h`, at its elastic equilibrium."""
    scene = sphere_scene.with_values({"run.end": 0.01, "numerics.step": 0.01})
    history = simulate(scene).history
    stretch = history.volume_ratio[0] ** (1 / 3)
    stress = 0.20265 * 2.5 * stretch / 0.2
    excess = np.sqrt(2) * stress / SIGMA_TRS - 1
    per_volume = np.sqrt(2) * stretch**2 * stress * excess / T_GRW
    wall_volume = 4 * np.pi * 2.5**2 * 0.1
    assert history.dissipation_rate[0] == pytest.approx(per_volume * wall_volume, rel=2e-3)


@pytest.mark.distributed
@pytest.mark.parametrize(("factor", "grows"), [(0.96, True), (1.04, False)])
def test_sphere_grows_if_its_stress_passes_the_threshold(sphere_scene, factor, grows):
    """‖σ‖ = √2 p r/2h in the mid-surface, 1.6 % more and less in the outer and inner fibres."""
    elastic = 1.0336396 ** (1 / 3)  # stretch without growth
    threshold = factor * np.sqrt(2) * 0.20265 * 2.5 * elastic / 0.2
    scene = sphere_scene.with_values(
        {
            "growth.threshold": threshold,
            "numerics.step": 1.0,
            "run.end": 2.0,
        }
    )
    history = simulate(scene).history
    assert (history.max_growth_strain[-1] > 0) == grows
    assert (history.dissipation_rate[-1] > 0) == grows
    assert (history.volume_ratio[-1] > history.volume_ratio[0] + 1e-6) == grows
