"""One discretised wall: its unknowns, growth strains, loads and forms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Discretisation
from . import kinematics
from .deformation import Deformation
from .forms import Forms
from .growth_state import GrowthState
from .growth_weights import WeightField, Weights
from .hyperelasticity import Material, scaled
from .laws import Law, Parameter
from .loads import NodalForce
from .reference import Reference

Array = NDArray[np.float64]

# Keeps the pivots of the shear force off zero; beyond it V/V0 agrees with γ = 0 to 10 digits.
_LARGEST_PENALTY = 1e8
_NO_VOLUME = 1e-9


@dataclass(frozen=True)
class WallProperties:
    """What a wall is made of.

    Attributes
    ----------
    thickness, shear_modulus
        `h` in µm and μ in MPa, outside the zones of the wall.
    energy
        Strain energy ψ of the elastic logarithmic strains.
    growth_law
        Growth rate in the growing zones; None for an elastic wall.
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


@dataclass(frozen=True)
class Approximation:
    """How the wall is approximated on its mesh.

    Attributes
    ----------
    order
        Lagrange degree of displacement and rotation.
    thickness_points
        Number of Gauss points through the thickness.
    shear_penalty
        κ; an infinite κ enforces `γ = 0`.
    """

    order: int
    thickness_points: int
    shear_penalty: float


@dataclass(frozen=True)
class ShellState:
    """Copy of the state of a shell.

    Attributes
    ----------
    w
        Local coefficients of displacement, rotation and shear force, ghosts among them.
    eps_g
        Growth strains of the local growing elements; None for an elastic wall.
    """

    w: Array
    eps_g: Array | None


class Shell:
    """A wall of revolution on an interval mesh.

    The total potential per 2π is

        Π = ∫ [∫ ψ(ε(ξ) - ε^g(ξ)) dξ + Q γ - Q²/(2 κ μ h)] R dS - p ∫ ½ r² z' dS

    with the shear force `Q` as an unknown beside displacement and director rotation: eliminated,
    it gives the penalty `½ κ μ h γ²`, but Newton's method does not suffer from a large κ.

    Parameters
    ----------
    discretisation
        Reference meridian, elements and zones.
    wall, approximation
        What the wall is made of, and how it is approximated.
    comm
        MPI communicator that shares the mesh.

    Attributes
    ----------
    w
        Trial state `(u_r, u_z, β, Q)`, a function of the mixed space.
    pressure
        Turgor in MPa, a constant of the forms.
    force
        Axial force at a node, or None.
    bending, membrane_stiffness
        Whether the wall resists bending; the size of `E h` in µN/µm.
    reference_volume
        Volume in µm³ that ratios refer to: that of the unloaded cell or, if that is zero, of
        a hemisphere on the edge.
    growth
        Growth strains of the growing elements, or None.
    eps, xi
        Logarithmic strains `(ε1, ε2)` at each through-thickness integration point, in UFL, and
        the points' distance from the mid-surface in µm, outward positive.
    forms
        Compiled residual, tangents and functionals.
    conditions, constrained
        Conditions at the ends, all homogeneous, and their local DOFs.
    """

    def __init__(
        self,
        discretisation: Discretisation,
        wall: WallProperties,
        approximation: Approximation,
        comm: Any,
    ) -> None:
        self.discretisation = discretisation
        self._reference = reference = Reference(discretisation, comm, approximation.order)
        self.mesh, self.degree = reference.mesh, reference.degree
        self.quadrature_S = reference.quadrature_S
        self.growing_elements = reference.growing_elements
        self.comm, h, mu = self.mesh.comm, wall.thickness, wall.shear_modulus
        self.bending, self.membrane_stiffness = wall.bending, 3 * mu * h
        space = dx.shell_space if wall.bending else dx.membrane_space
        self.space = space(self.mesh, approximation.order)
        self.w = dx.fem.Function(self.space)
        self.pressure = reference.constant(0.0)
        points = approximation.thickness_points if wall.bending else 1
        zeta, weights = np.polynomial.legendre.leggauss(points)
        self.xi: Array = zeta * h / 2
        meridian = reference.meridian()

        thickness = reference.constant(h)
        penalty = min(approximation.shear_penalty, _LARGEST_PENALTY)
        compliance = reference.constant(1 / (penalty * mu * h))
        psi = wall.energy.on(reference.coefficient)
        if wall.thickness_ratio is not None:
            ratio = reference.coefficient(wall.thickness_ratio)
            thickness, compliance = thickness * ratio, compliance / ratio
        if wall.modulus_ratio is not None:
            ratio = reference.coefficient(wall.modulus_ratio)
            psi, compliance = scaled(psi, ratio), compliance / ratio
        self.conditions, self.constrained = reference.constrain_ends(self.space, wall.bending)
        thinning = None if wall.thinning is None else wall.thinning.on(reference.coefficient)
        self.material = Material(psi, wall.energy_per_grown_volume, thinning)

        if wall.bending:
            distances = [float(z) * thickness / 2 for z in zeta]
            deformation = Deformation.of_shell(meridian, self.w, distances)
        else:
            deformation = Deformation.of_membrane(meridian, self.w)
        self.eps = deformation.eps
        self.growth = None
        if wall.growth_law is not None:
            self.growth = self._growth_state(wall.growth_law, deformation)
        shares = [float(weight) * thickness / 2 for weight in weights]
        self.forms = Forms(
            reference,
            self.w,
            deformation,
            self.pressure,
            self.material,
            self.growth,
            shares,
            compliance,
        )
        self.force = None
        if discretisation.loaded is not None:
            self.force = NodalForce(self.w, self.comm, discretisation.loaded, h)
        self.reference_volume = self._reference_volume()

    def _growth_state(self, law: Law, deformation: Deformation) -> GrowthState:
        place = self.mesh, self.growing_elements, self.degree
        weights: list[WeightField] = []

        def coefficient(value: Parameter) -> Any:
            if not isinstance(value, Weights):
                return self._reference.coefficient(value)
            stretch = kinematics.stretch(deformation.strain[0])
            weights.append(WeightField(*place, self.quadrature_S, stretch, value))
            return weights[-1].function

        rate = law.on(coefficient)
        return GrowthState(*place, deformation.eps, self.material, rate, weights)

    def _reference_volume(self) -> float:
        volume, curve = self.volume(), self.discretisation.curve
        largest = float(curve.radius(np.linspace(0, curve.length, 101)).max())
        hemisphere = 2 * np.pi / 3 * largest**3
        return volume if volume > _NO_VOLUME * hemisphere else hemisphere

    def state(self) -> ShellState:
        """Return a copy of the trial state."""
        eps_g = None if self.growth is None else self.growth.get()
        return ShellState(self.w.x.array.copy(), eps_g)

    def restore(self, state: ShellState) -> None:
        """Set the trial state to a copy."""
        self.w.x.array[:] = state.w
        if self.growth is not None and state.eps_g is not None:
            self.growth.set(state.eps_g)

    def volume(self) -> float:
        """Return the volume enclosed by the mid-surface in the trial state, µm³."""
        return dx.assemble_scalar(self.forms.volume, self.comm)

    def dissipation_rate(self) -> float:
        """Return the dissipation of growth (12) in the trial state, µm³ MPa/min."""
        if self.growth is None:
            return 0.0
        return dx.assemble_scalar(self.forms.dissipation, self.comm)
