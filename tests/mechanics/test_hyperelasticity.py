"""The Ogden wall: principal stresses (11) against the tensor form (8) of the same energy."""

import numpy as np
import pytest
import ufl

from fenics_yeast import _dolfinx as dx
from fenics_yeast.mechanics import hyperelasticity as wall

EXPONENTS = [2.0, 1.3, 6.0, -2.0, -0.7]


@pytest.fixture(scope="module")
def principal(one_element):
    """Energy and principal Kirchhoff stresses of the package at given strains, μ and α."""
    strain = dx.fem.Constant(one_element, np.zeros(2))
    mu, alpha = (dx.fem.Constant(one_element, np.float64(1)) for _ in range(2))

    def energy(eps):
        return wall.ogden(eps, mu, alpha)

    values = ufl.as_vector([energy(strain), *wall.kirchhoff_stress(energy, strain)])
    expression = dx.compile_expression(values, np.array([[0.5]]))

    def evaluate(eps_e, mu_value, alpha_value):
        strain.value[:], mu.value, alpha.value = eps_e, mu_value, alpha_value
        psi, *tau = dx.evaluator(expression, one_element, np.array([0], dtype=np.int32))()[0]
        return psi, np.array(tau)

    return evaluate


def energy_of_tensor(b: np.ndarray, mu: float, alpha: float) -> float:
    """Equation (9) as a function of the elastic left Cauchy-Green tensor."""
    return 2 * mu / alpha**2 * (np.sum(np.linalg.eigvalsh(b) ** (alpha / 2)) - 3)


def stress_of_tensor(b: np.ndarray, free: np.ndarray, mu: float, alpha: float) -> np.ndarray:
    """Equation (8) with the pressure of incompressibility that frees the direction `free`."""
    gradient, h = np.zeros((3, 3)), 1e-5
    for i in range(3):
        for j in range(3):
            change = np.zeros((3, 3))
            change[i, j] += h / 2
            change[j, i] += h / 2
            ahead = energy_of_tensor(b + change, mu, alpha)
            behind = energy_of_tensor(b - change, mu, alpha)
            gradient[i, j] = (ahead - behind) / (2 * h)
    tau = 2 * gradient @ b
    return tau - free @ tau @ free * np.eye(3)


@pytest.mark.parametrize("alpha", EXPONENTS)
@pytest.mark.parametrize("seed", range(4))
def test_principal_stresses_are_those_of_the_tensor_form(principal, alpha, seed):
    random = np.random.default_rng(seed)
    mu, eps = random.uniform(1, 50), random.uniform(-0.3, 0.3, 2)
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    squares = np.exp(2 * np.append(eps, -eps.sum()))  # incompressible: ε3 = -ε1 - ε2
    b = axes @ np.diag(squares) @ axes.T
    expected = stress_of_tensor(b, axes[:, 2], mu, alpha)
    psi, tau = principal(eps, mu, alpha)
    found = axes @ np.diag([*tau, 0.0]) @ axes.T
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * mu)
    assert psi == pytest.approx(energy_of_tensor(b, mu, alpha), rel=1e-12)


@pytest.mark.parametrize("alpha", EXPONENTS)
def test_stresses_have_the_closed_form(principal, alpha):
    """Equation (11), second line."""
    e1, e2 = eps = np.array([0.21, -0.08])
    closed = 2 * 40 / alpha * (np.exp(alpha * eps) - np.exp(-alpha * (e1 + e2)))
    np.testing.assert_allclose(principal(eps, 40.0, alpha)[1], closed, rtol=1e-13)


@pytest.mark.parametrize("alpha", EXPONENTS)
def test_small_strain_stiffness_is_the_shear_modulus_for_every_exponent(principal, alpha):
    """Pure shear `ε, -ε` of an incompressible wall: τ = ± 2 μ ε, no energy at rest."""
    assert principal((0, 0), 40.0, alpha)[0] == 0
    np.testing.assert_array_equal(principal((0, 0), 40.0, alpha)[1], [0, 0])
    np.testing.assert_allclose(principal((1e-6, -1e-6), 40.0, alpha)[1], [8e-5, -8e-5], rtol=1e-5)
