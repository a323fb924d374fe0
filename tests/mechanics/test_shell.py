"""Forms of the wall against the potential, written independently in NumPy, and differences."""

import numpy as np
import pytest

from fenics_yeast import _dolfinx as dx
from fenics_yeast.simulation import build_shell

MU, ALPHA, KAPPA, H = 30.0, 2.7, 50.0, 0.1


@pytest.fixture(scope="module")
def rough_scene(fine_scene):
    """A few elements, half of them growing; the numbers are arbitrary and not converged."""
    return fine_scene.with_values(
        {
            "wall.shear_modulus": MU,
            "wall.ogden_exponent": ALPHA,
            "growth.zone.half_angle": 90.0,
            "numerics.elements": 10,
            "numerics.grading": "uniform",
            "numerics.shear_penalty": KAPPA,
        }
    )


def disturbed(scene, stage: float, **numerics):
    """A shell in a random state, with growth strains that differ at every point."""
    scene = scene.with_values({f"numerics.{key}": value for key, value in numerics.items()})
    shell, random = build_shell(scene), np.random.default_rng(7)
    shell.pressure.value = 0.3
    shell.w.x.array[:] = 0.02 * random.normal(size=len(shell.w.x.array))
    base = 0.01 * random.normal(size=shell.growth.get().shape)
    shell.growth.stage.value = stage
    shell.growth.set_base(base)
    shell.growth.set(base)
    assert shell.growth.update()
    return shell


def vector(form) -> np.ndarray:
    return dx.fem.assemble_vector(form).array.copy()


def dense(form) -> np.ndarray:
    matrix = dx.create_matrix(form)
    dx.assemble_matrix(matrix, form, [])
    values = matrix.convert("dense").getDenseArray().copy()
    matrix.destroy()
    return values


def potential(shell, w: np.ndarray, eps_g: np.ndarray) -> complex:
    """Total potential per 2π of two-node elements with one point each, in NumPy."""
    S, motion = dx.node_dofs(shell.space)
    motion = motion[np.argsort(S)]
    S = np.sort(S)
    L, middle = np.diff(S), (S[1:] + S[:-1]) / 2
    shear, parent = shell.space.sub(1).collapse()
    place = shear.tabulate_dof_coordinates()[:, 0]
    Q = MU * H * shell.rotation / 4 * w[np.ravel(parent)[np.argsort(place)]]
    curve = shell.discretisation.curve
    R, Phi, Phi_S = curve.radius(middle), curve.angle(middle), curve.curvature(middle)
    mean = (w[motion[1:]] + w[motion[:-1]]) / 2
    slope = (w[motion[1:]] - w[motion[:-1]]) / L[:, None]

    psi, psi_S = Phi + shell.rotation * mean[:, 2], Phi_S + shell.rotation * slope[:, 2]
    r = R + mean[:, 0]
    r_S, z_S = np.cos(Phi) + slope[:, 0], np.sin(Phi) + slope[:, 1]
    gamma = r_S * np.sin(psi) - z_S * np.cos(psi)
    E1b = (r_S * np.cos(psi) + z_S * np.sin(psi)) * psi_S - Phi_S
    E2b = (r * np.sin(psi) - R * np.sin(Phi)) / R**2
    density = Q * gamma - Q**2 / (2 * KAPPA * MU * H)
    grown = np.zeros((len(L), len(shell.xi), 2))
    places = shell.growing_points.S[:, 0]
    grown[np.searchsorted(middle, places - 1e-9)] = eps_g.reshape(len(places), -1, 2)
    zeta, weights = np.polynomial.legendre.leggauss(len(shell.xi))
    for j in range(len(zeta)):
        xi = H / 2 * zeta[j]
        e1 = np.log(r_S**2 + z_S**2 + 2 * xi * E1b) / 2 - grown[:, j, 0]
        e2 = np.log((r / R) ** 2 + 2 * xi * E2b) / 2 - grown[:, j, 1]
        powers = np.exp(ALPHA * e1) + np.exp(ALPHA * e2) + np.exp(-ALPHA * (e1 + e2)) - 3
        density = density + H / 2 * weights[j] * 2 * MU / ALPHA**2 * powers
    return np.sum((density * R - shell.pressure.value * r**2 * z_S / 2) * L)


@pytest.mark.parametrize("geometry", ["curved", "conical"])
def test_residual_is_the_derivative_of_the_potential(rough_scene, geometry):
    """By complex steps, which have no error of differences; the growth strains are constant."""
    shell = disturbed(rough_scene, stage=2.0, order=1, geometry=geometry)
    w, eps_g = shell.w.x.array.astype(complex), shell.growth.get()
    expected = np.zeros(len(w))
    for i in range(len(w)):
        w[i] += 1e-30j
        expected[i] = potential(shell, w, eps_g).imag / 1e-30
        w[i] = w[i].real
    np.testing.assert_allclose(
        vector(shell.forms.residual), expected, rtol=1e-10, atol=1e-12 * abs(expected).max()
    )


def differences(shell, direction: np.ndarray, update: bool) -> np.ndarray:
    """Change of the residual along a direction, with growth updated in its stage or constant."""
    w, eps_g, step, values = shell.w.x.array.copy(), shell.growth.get(), 1e-6, []
    for sign in (1, -1):
        shell.w.x.array[:] = w + sign * step * direction
        assert not update or shell.growth.update()
        values.append(vector(shell.forms.residual))
    shell.w.x.array[:] = w
    shell.growth.set(eps_g)
    return (values[0] - values[1]) / (2 * step)


@pytest.mark.parametrize("order", [1, 3])
@pytest.mark.parametrize("name", ["tangent", "consistent_tangent"])
def test_tangents_are_differences_of_the_residual(rough_scene, name, order):
    """At constant growth, and with growth updated in an implicit stage."""
    shell = disturbed(rough_scene, stage=2.0, order=order)
    shell.forms.update()
    tangent = dense(getattr(shell.forms, name))
    random = np.random.default_rng(8)
    for _ in range(3):
        direction = random.normal(size=len(shell.w.x.array))
        expected = differences(shell, direction, update=name == "consistent_tangent")
        np.testing.assert_allclose(
            tangent @ direction, expected, rtol=0, atol=1e-7 * abs(expected).max()
        )


def test_growth_in_the_stage_softens_the_wall(rough_scene):
    """Otherwise the test above would not distinguish the two tangents."""
    shell = disturbed(rough_scene, stage=2.0, order=1)
    shell.forms.update()
    constant, updated = dense(shell.forms.tangent), dense(shell.forms.consistent_tangent)
    assert np.linalg.norm(updated - constant) > 0.05 * np.linalg.norm(constant)


def test_tangent_at_given_growth_is_symmetric(rough_scene):
    """The turgor is a follower load with a potential, because the poles lie on the axis."""
    shell = disturbed(rough_scene, stage=2.0, order=3)
    tangent = dense(shell.forms.tangent)
    np.testing.assert_allclose(tangent, tangent.T, rtol=0, atol=1e-13 * abs(tangent).max())


@pytest.mark.parametrize("geometry", ["curved", "conical"])
def test_an_unloaded_wall_is_in_equilibrium(rough_scene, geometry):
    shell = build_shell(rough_scene.with_values({"numerics.geometry": geometry}))
    np.testing.assert_allclose(vector(shell.forms.residual), 0, atol=1e-14)


def test_an_axial_translation_causes_no_force(rough_scene):
    """The rigid motion of a wall of revolution: no force, no stiffness along it."""
    shell = build_shell(rough_scene)
    motion = np.zeros(len(shell.w.x.array))
    motion[dx.node_dofs(shell.space)[1][:, 1]] = 0.7
    tangent = dense(shell.forms.tangent)
    np.testing.assert_allclose(tangent @ motion, 0, atol=1e-12 * abs(tangent).max())
    shell.w.x.array[:] = motion
    np.testing.assert_allclose(vector(shell.forms.residual), 0, atol=1e-12)


def test_uniform_inflation_stretches_every_fibre(fine_scene):
    """E = (λ² - 1)/2 + ξ (λ - 1)/R0 in both directions, to the error of interpolation."""
    shell, factor = build_shell(fine_scene), 1.1
    inflate(shell, factor)
    for eps, xi in zip(shell.eps, shell.xi, strict=True):
        found = shell.points.compile(list(eps))()
        fibre = np.log(factor**2 + 2 * xi * (factor - 1) / 2.5) / 2
        np.testing.assert_allclose(found, fibre, rtol=0, atol=2e-6)


def inflate(shell, factor: float) -> None:
    S, dofs = dx.node_dofs(shell.space)
    curve = shell.discretisation.curve
    shell.w.x.array[dofs[:, 0]] = (factor - 1) * curve.radius(S)
    shell.w.x.array[dofs[:, 1]] = (factor - 1) * (curve.height(S) + 2.5)


def test_the_pressure_force_is_the_gradient_of_the_volume(rough_scene):
    """∂Π/∂p = -V/2π: the residual changes by minus the gradient of the volume."""
    shell = disturbed(rough_scene, stage=2.0, order=3)
    gradient, loaded = vector(shell.forms.volume_gradient), vector(shell.forms.residual)
    shell.pressure.value += 0.5
    np.testing.assert_allclose(vector(shell.forms.residual) - loaded, -0.5 * gradient, atol=1e-13)

    direction = np.random.default_rng(9).normal(size=len(gradient))
    w, volumes = shell.w.x.array.copy(), []
    for sign in (1, -1):
        shell.w.x.array[:] = w + sign * 1e-5 * direction
        volumes.append(shell.volume())
    slope = (volumes[0] - volumes[1]) / 2e-5
    assert slope == pytest.approx(2 * np.pi * gradient @ direction, rel=1e-8)


def test_the_volume_of_a_sphere_is_exact_on_a_curved_meridian(elastic_scene):
    """At rest and inflated, on a curved meridian; straight elements enclose less, by O(size²)."""
    exact = 4 / 3 * np.pi * 2.5**3
    shell = build_shell(elastic_scene.with_values({"numerics.elements": 48}))
    assert shell.volume() == pytest.approx(exact, rel=1e-9)
    inflate(shell, 1.2)
    assert shell.volume() == pytest.approx(1.2**3 * exact, rel=1e-6)
    missing = []
    for elements in (60, 120):
        numerics = {"elements": elements, "order": 1, "geometry": "conical"}
        scene = elastic_scene.with_values({f"numerics.{k}": v for k, v in numerics.items()})
        missing.append(1 - build_shell(scene).volume() / exact)
    assert missing[1] > 0
    assert missing[0] / missing[1] == pytest.approx(4, rel=0.01)
