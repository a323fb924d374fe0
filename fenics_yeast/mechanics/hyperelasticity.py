"""Stress and strain energy of the wall, equations (8) to (11) of the paper.

A strain energy is a function of the principal elastic logarithmic strains, a UFL vector
`(ε1^e, ε2^e)`, and returns the energy per unit reference volume in MPa. UFL differentiates it to
give stresses and tangents.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ufl

from .growth_strains import elastic_strain, logarithmic_strain

StrainEnergy = Callable[[Any], Any]


def kirchhoff_stress(psi: StrainEnergy, eps_e: Any) -> Any:
    """Return the principal Kirchhoff stresses `τ_i = ∂ψ/∂ε_i^e`: equations (8) and (10).

    For `ogden`, UFL's differentiation gives equation (11).
    """
    eps_e = ufl.variable(eps_e)
    return ufl.diff(psi(eps_e), eps_e)


def ogden(eps_e: Any, mu: Any, alpha: Any) -> Any:
    """Return the incompressible one-term Ogden energy in plane stress: equation (9).

    Parameters
    ----------
    eps_e
        Elastic logarithmic strains `(ε1^e, ε2^e)`.
    mu, alpha
        Shear modulus μ in MPa; exponent α, not zero, 2 for the neo-Hookean wall.
    """
    lambda_1 = ufl.exp(alpha * eps_e[0])
    lambda_2 = ufl.exp(alpha * eps_e[1])
    lambda_3 = ufl.exp(-alpha * (eps_e[0] + eps_e[1]))
    return 2 * mu / alpha**2 * (lambda_1 + lambda_2 + lambda_3 - 3)


def ogden_sum(eps_e: Any, **terms: Any) -> Any:
    """Return the sum of Ogden energies with moduli `mu_0, mu_1, …` and exponents `alpha_0, …`."""
    pairs = [(terms[f"mu_{i}"], terms[f"alpha_{i}"]) for i in range(len(terms) // 2)]
    return sum(ogden(eps_e, mu, alpha) for mu, alpha in pairs)


def saint_venant_kirchhoff(eps_e: Any, young: Any, poisson: Any) -> Any:
    """Return the Saint Venant-Kirchhoff energy in plane stress, quadratic in Green-Lagrange strain.

    Parameters
    ----------
    eps_e
        Elastic logarithmic strains `(ε1^e, ε2^e)`.
    young, poisson
        Young's modulus in MPa, Poisson's ratio.
    """
    E1, E2 = (_green(eps_e[i]) for i in range(2))
    return young / (2 * (1 - poisson**2)) * (E1**2 + E2**2 + 2 * poisson * E1 * E2)


def scaled(psi: StrainEnergy, factor: Any) -> StrainEnergy:
    """Return a strain energy with its moduli multiplied by a factor."""
    return lambda eps_e: factor * psi(eps_e)


def incompressible_thinning(eps_e: Any) -> Any:
    """Return the logarithmic strain `ε3^e` through an incompressible wall."""
    return -(eps_e[0] + eps_e[1])


def saint_venant_kirchhoff_thinning(eps_e: Any, poisson: Any) -> Any:
    """Return the strain `ε3^e` through a Saint Venant-Kirchhoff wall in plane stress."""
    E3 = -poisson / (1 - poisson) * (_green(eps_e[0]) + _green(eps_e[1]))
    return logarithmic_strain(E3)


def _green(eps: Any) -> Any:
    """Return the Green-Lagrange strain of a logarithmic one."""
    return (ufl.exp(2 * eps) - 1) / 2


@dataclass(frozen=True)
class Material:
    """The material of the wall.

    Attributes
    ----------
    psi, per_grown
        Strain energy; whether it is per unit grown volume or per unit reference volume.
    thinning
        Strain `ε3^e` through the wall, a function of the elastic strains; None for constant
        thickness.
    """

    psi: StrainEnergy
    per_grown: bool = False
    thinning: StrainEnergy | None = None

    def energy(self, eps: Any, eps_g: Any = None) -> Any:
        """Return the energy per unit reference volume of total and growth strains, if any."""
        if eps_g is None:
            return self.psi(eps)
        energy = self.psi(elastic_strain(eps, eps_g))
        return energy * ufl.exp(eps_g[0] + eps_g[1]) if self.per_grown else energy

    def stress(self, eps: Any, eps_g: Any) -> Any:
        """Return the principal Kirchhoff stresses `τ_i` in MPa, forces per reference section."""
        tau = kirchhoff_stress(self.psi, elastic_strain(eps, eps_g))
        return tau * ufl.exp(eps_g[0] + eps_g[1]) if self.per_grown else tau

    def thickness_strain(self, eps: Any, eps_g: Any) -> Any:
        """Return the strain `ε3` through the wall; None for constant thickness."""
        return None if self.thinning is None else self.thinning(elastic_strain(eps, eps_g))
