"""Equilibrium: elastic spheres against closed forms, and the convergence of Newton's method."""

from contextlib import suppress

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_yeast import _dolfinx as dx
from fenics_yeast import simulate
from fenics_yeast.simulation import build_shell
from fenics_yeast.solve.equilibrium import Equilibrium, EquilibriumError

R0, H, MU = 2.5, 0.1, 40.0
LIMIT = 1.239463  # largest p R0/(μ h) of a neo-Hookean membrane, at λ = 7^(1/6)
TOLERANCE = 1e-11  # µN


def load(stretch: float, alpha: float) -> float:
    """p R0/(μ h) of a spherical membrane; the energy is per unit reference volume."""
    return 4 / alpha * (stretch ** (alpha - 3) - stretch ** (-2 * alpha - 3))


def thick_load(stretch: float, alpha: float, ratio: float) -> float:
    """The same with the bending strain (λ - 1)/R0 of a wall of thickness `ratio` R0, 3 fibres."""
    zeta, weights = np.polynomial.legendre.leggauss(3)
    xi = ratio / 2 * zeta  # in radii
    square = stretch**2 + 2 * xi * (stretch - 1)
    tau = 2 / alpha * (square ** (alpha / 2) - square**-alpha)
    return np.sum(weights / 2 * 2 * tau * (stretch + xi) / square) / stretch**2


def stretch_of(scene) -> float:
    result = simulate(scene)
    assert result.status == "finished"
    return result.history.volume_ratio[-1] ** (1 / 3)


@pytest.mark.distributed
@pytest.mark.parametrize("alpha", [2.0, 3.5, -1.0])
@pytest.mark.parametrize("pressure", [0.2, 1.0, -0.1])
def test_elastic_sphere_has_its_closed_form(elastic_scene, alpha, pressure):
    """With the bending strain of the shell; exact but for the error of the elements."""
    scene = elastic_scene.with_values({"turgor.pressure": pressure, "wall.ogden_exponent": alpha})
    wanted = pressure * R0 / (MU * H)
    expected = brentq(lambda s: thick_load(s, alpha, H / R0) - wanted, 0.9, 1.25)
    assert stretch_of(scene) == pytest.approx(expected, abs=2e-7)


@pytest.mark.parametrize("pressure", [0.2, 1.5])
def test_wall_of_one_fibre_is_a_membrane(elastic_scene, pressure):
    """It has no bending stiffness; the membrane's closed form is exact."""
    scene = elastic_scene.with_values(
        {"turgor.pressure": pressure, "numerics.thickness_points": 1, "numerics.elements": 24}
    )
    expected = brentq(lambda s: load(s, 2.0) - pressure * R0 / (MU * H), 1.0, 7 ** (1 / 6))
    assert stretch_of(scene) == pytest.approx(expected, abs=2e-7)


def test_thin_shell_converges_to_the_membrane_with_the_square_of_its_thickness(elastic_scene):
    """The bending error of the stretch goes with (h/R)²."""
    expected = brentq(lambda s: load(s, 2.0) - 0.8, 1.0, 1.3)
    ratios, errors = np.array([0.16, 0.08, 0.04]), []
    for ratio in ratios:
        values = {
            "wall.thickness": ratio * R0,
            "turgor.pressure": 0.8 * MU * ratio,
            "numerics.elements": 24,
        }
        errors.append(stretch_of(elastic_scene.with_values(values)) - expected)
    exponent, _ = np.polyfit(np.log(ratios), np.log(np.abs(errors)), 1)
    assert exponent == pytest.approx(2, abs=0.05)
    assert abs(errors[-1]) < 1e-3


@pytest.mark.distributed
def test_solver_finds_no_equilibrium_beyond_the_limit_point(elastic_scene):
    """Stretch 7^(1/6) at the limit; the shell's bending moves it by 1e-4 or so."""
    assert load(7 ** (1 / 6), 2.0) == pytest.approx(LIMIT, abs=1e-6)
    shell = build_shell(elastic_scene)
    with Equilibrium(shell, TOLERANCE) as equilibrium:
        stretches = []
        for part in (0.5, 0.8, 0.95, 0.99):
            shell.pressure.value = part * LIMIT * MU * H / R0
            equilibrium.solve()
            stretches.append((shell.volume() / (4 / 3 * np.pi * R0**3)) ** (1 / 3))
        expected = brentq(lambda s: load(s, 2.0) - 0.99 * LIMIT, 1.0, 7 ** (1 / 6))
        assert stretches[-1] == pytest.approx(expected, rel=2e-3)
        softness = equilibrium.compliance()
        assert softness > 0
        shell.pressure.value = 1.01 * LIMIT * MU * H / R0
        with pytest.raises(EquilibriumError):
            equilibrium.solve()


@pytest.mark.distributed
def test_compliance_is_the_slope_of_the_volume(elastic_scene):
    shell = build_shell(elastic_scene)
    volumes = []
    with Equilibrium(shell, TOLERANCE) as equilibrium:
        for pressure in (0.199, 0.201, 0.2):
            shell.pressure.value = pressure
            equilibrium.solve()
            volumes.append(shell.volume())
        compliance = equilibrium.compliance()
    assert compliance == pytest.approx((volumes[1] - volumes[0]) / 0.002, rel=1e-5)


@pytest.mark.parametrize("pressure", [2.5, 20.0])
def test_failed_solution_has_a_reason_and_leaves_the_shell_unchanged(fine_scene, pressure):
    """Bit for bit, in an implicit stage; the next solution succeeds."""
    shell = build_shell(fine_scene)
    shell.pressure.value = 0.20265
    with Equilibrium(shell, TOLERANCE) as equilibrium:
        equilibrium.solve()
        shell.growth.stage.value = 1.0
        w, eps_g = shell.w.x.array.copy(), shell.growth.get()
        shell.pressure.value = pressure
        with pytest.raises(EquilibriumError) as caught:
            equilibrium.solve()
        np.testing.assert_array_equal(shell.w.x.array, w)
        np.testing.assert_array_equal(shell.growth.get(), eps_g)
        assert str(caught.value)
        shell.pressure.value = 0.20265
        equilibrium.solve()
        assert shell.growth.get().max() > 0


# --- Newton's method ----------------------------------------------------------------------


@pytest.fixture
def growing(fine_scene):
    """A bud under turgor at the end of an implicit stage of 4 min, and Newton's method."""
    shell = build_shell(fine_scene)
    shell.pressure.value = 0.20265
    with Equilibrium(shell, TOLERANCE, reuse_threshold=0.0) as equilibrium:
        equilibrium.solve()
        shell.growth.set_base(shell.growth.get())
        shell.growth.stage.value = 4.0
        equilibrium.solve()
        yield shell, equilibrium


def reductions(shell, equilibrium: Equilibrium) -> tuple[np.ndarray, np.ndarray]:
    """Residuals before and after the first iteration, from ever closer to the solution."""
    w, direction = shell.w.x.array.copy(), np.zeros(len(shell.w.x.array))
    S, dofs = dx.node_dofs(shell.space)
    direction[dofs[:, 0]] = np.sin(S / R0)
    direction[dofs[:, 1]] = 1 - np.cos(S / R0)
    pairs = []
    for size in 0.01 * 0.5 ** np.arange(6):
        norms: list[float] = []
        equilibrium.snes.setMonitor(lambda snes, iteration, norm, into=norms: into.append(norm))
        shell.w.x.array[:] = w + size * direction
        with suppress(EquilibriumError):  # only the first iteration matters
            equilibrium.solve()
        equilibrium.snes.cancelMonitor()
        pairs.append(norms[:2])
    before, after = np.array(pairs).T
    return before, after


def fitted_exponent(x: np.ndarray, y: np.ndarray) -> float:
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def test_newton_converges_quadratically_with_growth_in_its_stage(growing):
    shell, equilibrium = growing
    assert shell.growth.get().max() > 0.01
    assert fitted_exponent(*reductions(shell, equilibrium)) == pytest.approx(2, abs=0.05)


def test_newton_is_linear_without_the_consistent_tangent(growing):
    """The order above depends on the derivative of the growth update."""
    shell, equilibrium = growing

    def held(snes, x, J, P):
        dx.assemble_matrix(P, shell.forms.tangent, shell.conditions)

    equilibrium.snes.setJacobian(held, equilibrium.snes.getJacobian()[0])
    assert fitted_exponent(*reductions(shell, equilibrium)) == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("order", [1, 3])
def test_iterations_do_not_depend_on_the_shear_penalty(fine_scene, order):
    """From κ = 10 to no shear: counts differ by at most one, and the volumes converge."""
    counts, volumes = [], []
    for kappa in (10.0, 1e3, 1e6, float("inf")):
        scene = fine_scene.with_values(
            {
                "numerics.shear_penalty": kappa,
                "numerics.order": order,
                "numerics.integrator": "backward-euler",
                "run.end": 8.0,
            }
        )
        result = simulate(scene)
        assert result.status == "finished"
        counts.append(result.newton_iterations)
        volumes.append(result.history.volume_ratio[-1])
    assert max(counts) - min(counts) <= 1
    np.testing.assert_allclose(volumes[1:], volumes[-1], rtol=0, atol=2e-5)
