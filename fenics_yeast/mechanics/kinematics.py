"""Strain measures of a thin shell of revolution, equations (1) to (7) of the paper.

The paper writes (2) for straight conical elements. Here the same strains are written for a
curved meridian; on a meridian made of straight pieces, where `Φ' = 0`, they are the paper's own.
Every function takes and returns UFL expressions.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import ufl


class Meridian(NamedTuple):
    """A meridian at a point: radius, its derivatives along the reference arc length, angle.

    For the reference wall these are `R, cos Φ, sin Φ, Φ, Φ'`; for the current one
    `r, r', z', ψ, ψ'`.
    """

    r: Any
    r_S: Any
    z_S: Any
    psi: Any
    psi_S: Any


class Strains(NamedTuple):
    """Membrane, bending and shear parts of the Green-Lagrange strain (1)."""

    E1m: Any
    E2m: Any
    E1b: Any
    E2b: Any
    gamma: Any


def strains(reference: Meridian, current: Meridian) -> Strains:
    """Strain parts (2) from the reference and the current meridian."""
    R, Phi, Phi_S = reference.r, reference.psi, reference.psi_S
    r, r_S, z_S, psi, psi_S = current
    E1m, E2m = membrane_strains(R, r, r_S, z_S)
    return Strains(
        E1m=E1m,
        E2m=E2m,
        E1b=(r_S * ufl.cos(psi) + z_S * ufl.sin(psi)) * psi_S - Phi_S,
        E2b=(r * ufl.sin(psi) / R - ufl.sin(Phi)) / R,
        gamma=r_S * ufl.sin(psi) - z_S * ufl.cos(psi),
    )


def membrane_strains(R: Any, r: Any, r_S: Any, z_S: Any) -> tuple[Any, Any]:
    """`E1m, E2m`, the part of (2) that a wall without bending has."""
    return (r_S**2 + z_S**2 - 1) / 2, ((r / R) ** 2 - 1) / 2


def green_lagrange(parts: Strains, xi: Any) -> tuple[Any, Any]:
    """`E1, E2` at the distance ξ from the mid-surface, outward positive: equation (1)."""
    return parts.E1m + xi * parts.E1b, parts.E2m + xi * parts.E2b


def stretch(E: Any) -> Any:
    """Principal stretch of a principal Green-Lagrange strain: equation (3)."""
    return ufl.sqrt(2 * E + 1)


def logarithmic(E: Any) -> Any:
    """Logarithmic strain `ln λ` of a principal Green-Lagrange strain: equations (3), (6)."""
    return ufl.ln(2 * E + 1) / 2


def elastic(eps: Any, eps_g: Any) -> Any:
    """Elastic part of the logarithmic strain: equation (7), the logarithm of (5)."""
    return eps - eps_g
