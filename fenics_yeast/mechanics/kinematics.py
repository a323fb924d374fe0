"""Strains of a thin shell of revolution, equations (1) to (3) of the paper.

The paper writes (2) for straight conical elements. These strains hold for a curved meridian; on
straight elements, where `Φ' = 0`, they reduce to the paper's.
Every function takes and returns UFL expressions.
"""

from typing import Any, NamedTuple

import ufl


class Meridian(NamedTuple):
    """A meridian at a point: radius, slopes, angle; derivatives by reference arc length.

    The reference wall has `R, cos Φ, sin Φ, Φ, Φ'`, the current wall `r, r', z', ψ, ψ'`.
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


def green_lagrange(parts: Strains, xi: Any) -> tuple[Any, Any]:
    """Return `E1, E2` at a distance ξ from the mid-surface, outward positive: equation (1)."""
    return parts.E1m + xi * parts.E1b, parts.E2m + xi * parts.E2b


def strains(reference: Meridian, current: Meridian) -> Strains:
    """Return the strain parts of the reference and the current meridian: equation (2)."""
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
    """Return `E1m, E2m`, the membrane part of equation (2)."""
    return (r_S**2 + z_S**2 - 1) / 2, ((r / R) ** 2 - 1) / 2


def stretch(E: Any) -> Any:
    """Return `λ`, the principal stretch of a principal Green-Lagrange strain: equation (3)."""
    return ufl.sqrt(2 * E + 1)
