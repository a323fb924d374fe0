"""Deformation of the wall: equations (1) to (3) and (6) as functions of its state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from . import kinematics
from .growth_strains import logarithmic_strain
from .kinematics import Meridian
from .section import Section


@dataclass(frozen=True)
class Deformation:
    """Strains of the trial state in UFL.

    Attributes
    ----------
    R
        Reference radius.
    enclosed
        Enclosed volume per 2π and reference arc length.
    strain, E
        Membrane and bending strains `(E1m, E2m, E1b, E2b)`, or `(E1m, E2m)` of a membrane; the
        same as a UFL variable, the only argument of the energy that depends on the state.
    eps
        Logarithmic strains `(ε1, ε2)` at each through-thickness integration point.
    current, Phi, Phi_S
        The current meridian, and angle and curvature of the unloaded one.
    gamma, Q
        Shear strain and shear force; None for a membrane.
    """

    R: Any
    enclosed: Any
    strain: Any
    E: Any
    eps: list[Any]
    current: Meridian
    Phi: Any
    Phi_S: Any
    gamma: Any = None
    Q: Any = None

    @classmethod
    def of_shell(cls, reference_meridian: Any, w: Any, section: Section) -> Deformation:
        """Return the strains of `(u_r, u_z, β, Q)` at the distances ξ of a section."""
        R, Phi, Phi_S = reference_meridian
        motion, Q = ufl.split(w)
        u_r, u_z, beta = motion[0], motion[1], section.rotation * motion[2]
        reference = Meridian(R, ufl.cos(Phi), ufl.sin(Phi), Phi, Phi_S)
        current = Meridian(
            r=reference.r + u_r,
            r_S=reference.r_S + u_r.dx(0),
            z_S=reference.z_S + u_z.dx(0),
            psi=Phi + beta,
            psi_S=Phi_S + beta.dx(0),
        )
        parts = kinematics.strains(reference, current)
        strain = ufl.as_vector([parts.E1m, parts.E2m, parts.E1b, parts.E2b])
        E = ufl.variable(strain)
        varied = kinematics.Strains(E[0], E[1], E[2], E[3], parts.gamma)
        eps = [_logarithmic(kinematics.green_lagrange(varied, xi)) for xi in section.distances]
        enclosed = current.r**2 * current.z_S / 2
        place = current, Phi, Phi_S
        return cls(R, enclosed, strain, E, eps, *place, parts.gamma, section.shear_force * Q)

    @classmethod
    def of_membrane(cls, reference_meridian: Any, w: Any) -> Deformation:
        """Return the strains of `(u_r, u_z)` at the mid-surface."""
        R, Phi, Phi_S = reference_meridian
        u_r, u_z = (w[i] for i in range(2))
        r, r_S, z_S = R + u_r, ufl.cos(Phi) + u_r.dx(0), ufl.sin(Phi) + u_z.dx(0)
        strain = ufl.as_vector(kinematics.membrane_strains(R, r, r_S, z_S))
        E = ufl.variable(strain)
        eps = [_logarithmic((E[0], E[1]))]
        current = Meridian(r, r_S, z_S, None, None)  # without a director
        return cls(R, r**2 * z_S / 2, strain, E, eps, current, Phi, Phi_S)


def resultants(section: Section, deformation: Deformation, eps_g: list[Any]) -> list[Any]:
    """Return the parts of the resultants `(N1, N2, M1, M2)` of each integration point.

    `eps_g` has the growth strains at each; it is empty where the wall is elastic.
    """
    parts = []
    for j, (weight, eps) in enumerate(zip(section.weights, deformation.eps, strict=True)):
        energy = weight * section.material.energy(eps, eps_g[j] if eps_g else None)
        parts.append(ufl.diff(energy, deformation.E))
    return parts


def _logarithmic(E: tuple[Any, Any]) -> Any:
    return ufl.as_vector([logarithmic_strain(E_i) for E_i in E])
