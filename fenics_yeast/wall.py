"""Strain energies of the wall, equations (8) to (11): functions of the elastic strain alone.

A strain energy is a function of the principal elastic logarithmic strains, a UFL vector
`(ε1^e, ε2^e)`, and returns the energy per unit reference volume in MPa. Stresses and tangents
come from it by UFL differentiation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ufl

StrainEnergy = Callable[[Any], Any]


def ogden(eps_e: Any, mu: Any, alpha: Any) -> Any:
    """Incompressible one-term Ogden energy in plane stress: equation (9) with `J^e = 1`.

    Parameters
    ----------
    eps_e
        Elastic logarithmic strains `(ε1^e, ε2^e)`.
    mu
        Shear modulus μ in MPa.
    alpha
        Exponent α, any number but zero; 2 is the neo-Hookean wall.
    """
    lambda_1 = ufl.exp(alpha * eps_e[0])
    lambda_2 = ufl.exp(alpha * eps_e[1])
    lambda_3 = ufl.exp(-alpha * (eps_e[0] + eps_e[1]))
    return 2 * mu / alpha**2 * (lambda_1 + lambda_2 + lambda_3 - 3)


def kirchhoff_stress(psi: StrainEnergy, eps_e: Any) -> Any:
    """Principal Kirchhoff stresses `τ_i = ∂ψ/∂ε_i^e`: equations (8), (10) and (11)."""
    eps_e = ufl.variable(eps_e)
    return ufl.diff(psi(eps_e), eps_e)
