"""Growth and elastic strains, equations (4) to (7) of the paper.

The deformation gradient splits as `F = F^e F^g` (4). With principal stretches `λ_i = λ_i^e λ_i^g`
(5), logarithmic strains add: `ε_i = ε_i^e + ε_i^g`. Growth keeps the thickness, `λ_3^g = 1`.
Every function takes and returns UFL expressions.
"""

from typing import Any

import ufl


def logarithmic_strain(E: Any) -> Any:
    """Return `ε = ln λ` of a principal Green-Lagrange strain: equation (6) with (3)."""
    return ufl.ln(2 * E + 1) / 2


def elastic_strain(eps: Any, eps_g: Any) -> Any:
    """Return `ε^e = ε - ε^g`: equation (7), the logarithm of (5)."""
    return eps - eps_g
