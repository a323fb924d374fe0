"""The wall across its thickness: what it is made of and how it is integrated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from ..geometry import Array
from .hyperelasticity import Material, scaled
from .laws import Coefficient, Law, Parameter
from .parameters import Parameters, values_of
from .thickness_rule import thickness_rule

# Keeps the pivots of the shear force off zero; beyond it V/V0 agrees with γ = 0 to 10 digits.
_LARGEST_PENALTY = 1e8


@dataclass(frozen=True)
class WallProperties:
    """What a wall is made of.

    Attributes
    ----------
    thickness, shear_modulus
        `h` in µm and μ in MPa, outside the zones of the wall.
    energy, growth_law
        Strain energy ψ; growth rate in the growing zones, None for an elastic wall.
    thickness_ratio, modulus_ratio
        Factors of thickness and moduli in the zones of the wall; None for 1.
    energy_per_grown_volume
        Whether ψ is per unit grown volume; otherwise it is per unit reference volume.
    thinning
        Elastic strain through the wall; None for constant thickness.
    bending
        False for a membrane, whose only unknown is the displacement.
    """

    thickness: float
    shear_modulus: float
    energy: Law
    growth_law: Law | None = None
    thickness_ratio: Parameter | None = None
    modulus_ratio: Parameter | None = None
    energy_per_grown_volume: bool = False
    thinning: Law | None = None
    bending: bool = True


_MEMBRANE_STIFFNESS = 4.0  # μ h in MPa µm of a wall whose shear force has the unit 1 µN/µm


@dataclass(frozen=True)
class Approximation:
    """How the wall is approximated on its mesh.

    Attributes
    ----------
    order
        Lagrange degree of displacement and rotation.
    thickness_points, thickness_rule
        Number of integration points through the thickness, and their rule: see `thickness_rule`.
    shear_penalty
        κ; an infinite κ enforces `γ = 0`.
    """

    order: int
    thickness_points: int
    shear_penalty: float
    thickness_rule: Literal["gauss", "clustered"] = "gauss"


@dataclass(frozen=True)
class Section:
    """The section of a wall as coefficients of its forms.

    Attributes
    ----------
    distances, weights, compliance
        In UFL: ξ of each integration point, its weight times `h/2`, and `1/(κ μ h)`.
    rotation, shear_force
        In UFL: β in rad and Q in µN/µm of a unit of their DOFs, see `Shell`.
    """

    material: Material
    distances: list[Any]
    weights: list[Any]
    compliance: Any
    rotation: Any
    shear_force: Any

    @classmethod
    def of(
        cls, wall: WallProperties, approximation: Approximation, parameters: Parameters
    ) -> Section:
        """Return the section of a wall, with the parameters named in `section_values`."""
        zeta, weights = _rule(wall, approximation)
        thickness, compliance = parameters["thickness"], parameters["compliance"]
        psi = parameters.of(wall.energy, "energy")
        if wall.thickness_ratio is not None:
            ratio = parameters["thickness_ratio"]
            thickness, compliance = thickness * ratio, compliance / ratio
        if wall.modulus_ratio is not None:
            ratio = parameters["modulus_ratio"]
            psi, compliance = scaled(psi, ratio), compliance / ratio
        thinning = None if wall.thinning is None else parameters.of(wall.thinning, "thinning")
        return cls(
            material=Material(psi, wall.energy_per_grown_volume, thinning),
            distances=[float(z) * thickness / 2 for z in zeta],
            weights=[float(weight) * thickness / 2 for weight in weights],
            compliance=compliance,
            rotation=parameters["rotation"],
            shear_force=parameters["shear_force"],
        )


def section_values(
    wall: WallProperties, approximation: Approximation, rotation: float
) -> dict[str, Parameter]:
    """Return the parameters of the section of a wall, whose rotation has a unit in rad."""
    h, mu = wall.thickness, wall.shear_modulus
    penalty = min(approximation.shear_penalty, _LARGEST_PENALTY)
    values: dict[str, Parameter] = {
        "thickness": h,
        "compliance": 1 / (penalty * mu * h),
        "rotation": rotation,
        "shear_force": mu * h * rotation / _MEMBRANE_STIFFNESS,
    }
    values |= values_of(wall.energy, "energy") | values_of(wall.thinning, "thinning")
    if wall.thickness_ratio is not None:
        values["thickness_ratio"] = wall.thickness_ratio
    if wall.modulus_ratio is not None:
        values["modulus_ratio"] = wall.modulus_ratio
    return values


def coefficients(
    wall: WallProperties, approximation: Approximation, rotation: float
) -> dict[str, Coefficient]:
    """Return the coefficients of a wall's forms: of its section and of its growth law."""
    values = section_values(wall, approximation, rotation)
    values |= values_of(wall.growth_law, "growth")
    return {name: x for name, x in values.items() if not isinstance(x, tuple)}


def distances(wall: WallProperties, approximation: Approximation) -> Array:
    """Return the distances ξ of the integration points from the mid-surface in µm.

    They are positive outward, and those outside the zones of the wall; shape ``(points,)``.
    """
    return _rule(wall, approximation)[0] * wall.thickness / 2


def _rule(wall: WallProperties, approximation: Approximation) -> tuple[Array, Array]:
    """Return points and weights of the rule through the thickness; a membrane has one point."""
    if not wall.bending:
        return thickness_rule(1, "gauss")
    return thickness_rule(approximation.thickness_points, approximation.thickness_rule)
