"""One discretised wall: its unknowns, growth strains, loads and forms."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import ufl

from .. import _dolfinx as dx
from ..geometry import Array, Discretisation
from . import kinematics
from .circumferential import SecondVariation
from .deformation import Deformation
from .forms import Forms
from .growth_laws import WallPoint
from .growth_state import GrowthState
from .growth_weights import WeightField
from .laws import Coefficient, Law
from .loads import NodalForce
from .parameter_derivatives import ParameterDerivatives
from .parameters import Parameters
from .reference import Reference
from .section import Approximation, Section, WallProperties, coefficients, distances

_NO_VOLUME = 1e-9  # in parts of a hemisphere's
_RADIUS = 2.5  # µm, of a wall whose rotation has the unit 1 rad


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

    The shear force `Q` is an unknown beside displacement and director rotation. Its elimination
    gives the penalty `½ κ μ h γ²`, but as an unknown it keeps Newton's method insensitive to κ.

    The DOFs of rotation and shear force have units that follow the size and stiffness of the wall,
    so that all equations are forces in µN: the same wall in other units of length and force gives
    the same digits. Those of a cell of 5 µm with a wall of 4 MPa µm are 1 rad and 1 µN/µm.

    Parameters
    ----------
    discretisation, wall, approximation
        Reference meridian and elements; what the wall is made of; how it is approximated.
    comm
        MPI communicator that shares the mesh.

    Attributes
    ----------
    mesh, comm, points, growing_points
        Interval mesh, its communicator, quadrature points of all local and of the growing elements.
    space, w
        Space of the state; the trial state `(u_r, u_z, β, Q)`, `(u_r, u_z)` of a membrane.
    radius, rotation
        Largest radius of the unloaded wall in µm; rotation in rad of a unit of its DOFs.
    pressure, force
        Turgor in MPa, a constant of the forms; axial force at a node, or None.
    bending, thickness, membrane_stiffness
        Whether the wall resists bending; its thickness in µm and the size of `E h` in µN/µm,
        both outside the zones of the wall.
    reference_volume
        Volume in µm³ that ratios refer to: that of the unloaded cell or, if that is zero, of
        a hemisphere on the edge.
    growth, material
        Growth strains of the growing elements, or None; material of the wall.
    eps, xi
        Logarithmic strains `(ε1, ε2)` at each through-thickness integration point, in UFL, and
        the points' distance from the mid-surface in µm, outward positive.
    forms, conditions, constrained
        Compiled forms; the homogeneous conditions at the ends, and their local DOFs.
    """

    def __init__(
        self,
        discretisation: Discretisation,
        wall: WallProperties,
        approximation: Approximation,
        comm: Any,
    ) -> None:
        self._order = approximation.order
        self._reference = reference = Reference(discretisation, comm, approximation.order)
        self.mesh, self.comm = reference.mesh, reference.mesh.comm
        self.bending = wall.bending
        space = dx.shell_space if wall.bending else dx.membrane_space
        self.space = space(self.mesh, approximation.order)
        self.w = dx.fem.Function(self.space)
        self.pressure = reference.constant(0.0)
        meridian = reference.meridian()
        values = self._describe(wall, approximation)
        self._parameters = parameters = Parameters(self.mesh, reference.points, values)
        section = Section.of(wall, approximation, parameters)
        self.material = section.material
        self.conditions, self.constrained = reference.constrain_ends(self.space, wall.bending)
        if wall.bending:
            deformation = Deformation.of_shell(meridian, self.w, section)
        else:
            deformation = Deformation.of_membrane(meridian, self.w)
        self.eps, self._deformation, self._section = deformation.eps, deformation, section
        law = wall.growth_law
        self.growth = None if law is None else self._growth_state(law, deformation)
        self.forms = Forms(reference, section, self.w, deformation, self.pressure, self.growth)
        self._derivatives: dict[tuple[str, ...], ParameterDerivatives] = {}
        self._trial, self._measured = self.w.x.array, (b"", 0.0)
        self._place()

    def reset(
        self, discretisation: Discretisation, wall: WallProperties, approximation: Approximation
    ) -> None:
        """Become the unloaded shell of another wall that has the same `structure`.

        No form is compiled: nodes are moved and values are set, so that all numbers are those of
        a new shell, to the last bit.
        """
        self._reference.move(discretisation)
        self._parameters.set(self._describe(wall, approximation), self._reference.points)
        self._trial[:] = 0
        self._measured = b"", 0.0
        self.pressure.value = np.float64(0)
        if self.growth is not None and wall.growth_law is not None:
            self.growth.reset(self.growing_points, [*wall.growth_law.weights.values()])
        self._place()

    def _describe(
        self, wall: WallProperties, approximation: Approximation
    ) -> dict[str, Coefficient]:
        """Take over the sizes of a wall; return the parameters of its forms."""
        reference = self._reference
        self.discretisation = reference.discretisation
        self.points, self.growing_points = reference.points, reference.growing_points
        self.thickness = wall.thickness
        self.membrane_stiffness = 3 * wall.shear_modulus * wall.thickness
        self.radius = self._largest_radius()
        self.rotation = _RADIUS / self.radius
        self.xi = distances(wall, approximation)
        return coefficients(wall, approximation, self.rotation)

    def _place(self) -> None:
        """Find the loaded node, and the volume of the unloaded wall."""
        loaded = self.discretisation.loaded
        self.force = None
        if loaded is not None:
            self.force = NodalForce(self.w, self.comm, loaded, self.thickness)
        self.reference_volume = self._reference_volume()

    @cached_property
    def second_variation(self) -> SecondVariation:
        """The second variation for perturbations with waves around the axis, compiled once."""
        return SecondVariation(
            self._reference,
            self._section,
            self._deformation,
            self.pressure,
            self.growth,
            self._order,
        )

    def parameter_derivatives(self, names: Sequence[str]) -> ParameterDerivatives:
        """Return the derivatives by some parameters of the forms, compiled once for the shell."""
        key = tuple(names)
        if key not in self._derivatives:
            parts = self._deformation, self.growth, self._parameters
            self._derivatives[key] = ParameterDerivatives(
                self._reference, self._section, self.w, *parts, key
            )
        return self._derivatives[key]

    @cached_property
    def point_fields(self) -> Callable[[], Array]:
        """Evaluates strains, Cauchy stresses and growth strains at this rank's points.

        For each through-thickness integration point there are the meridional and hoop components
        of the three; shape ``(elements, points n 3 2)``.
        """
        values: list[Any] = []
        for j, eps in enumerate(self.eps):
            eps_g = ufl.as_vector([0, 0]) if self.growth is None else self.growth.strain(j)
            tau = self.material.stress(eps, eps_g)
            eps_3 = self.material.thickness_strain(eps, eps_g)
            sigma = tau / WallPoint(tau, eps, eps_g, eps_3).J
            values += [vector[i] for vector in (eps, sigma, eps_g) for i in range(2)]
        return self.points.at(self.points.owned).compile(values)

    def _growth_state(self, law: Law, deformation: Deformation) -> GrowthState:
        stretch = kinematics.stretch(deformation.strain[0])
        fields = {
            name: WeightField(self.growing_points, stretch, weights)
            for name, weights in law.weights.items()
        }
        weights = {name: field.function for name, field in fields.items()}
        rate = self._parameters.of(law, "growth", **weights)
        return GrowthState(
            self.growing_points, deformation.eps, self.material, rate, [*fields.values()]
        )

    def _largest_radius(self) -> float:
        curve = self.discretisation.curve
        return float(curve.radius(np.linspace(0, curve.length, 101)).max())

    def _reference_volume(self) -> float:
        volume = self.volume()
        hemisphere = 2 * np.pi / 3 * self.radius**3
        return volume if volume > _NO_VOLUME * hemisphere else hemisphere

    def state(self) -> ShellState:
        """Return a copy of the trial state."""
        eps_g = None if self.growth is None else self.growth.get()
        return ShellState(self._trial.copy(), eps_g)

    def restore(self, state: ShellState) -> None:
        """Set the trial state to a copy."""
        self._trial[:] = state.w
        if self.growth is not None and state.eps_g is not None:
            self.growth.set(state.eps_g)

    def volume(self) -> float:
        """Return the volume enclosed by the mid-surface in the trial state, µm³."""
        if self.comm.size > 1:  # assembled by all ranks or by none
            return dx.assemble_scalar(self.forms.volume, self.comm)
        trial = self._trial.tobytes()
        if trial != self._measured[0]:
            self._measured = trial, dx.assemble_scalar(self.forms.volume, self.comm)
        return self._measured[1]

    def volume_changes(self, changes: Array) -> Array:
        """Return the changes of the volume in µm³ by those of the state, to first order.

        `changes` has the shape ``(n, DOFs)``, ghosts among them.
        """
        gradient = np.zeros(changes.shape[1])  # at ghosts, what this rank adds to their owners
        dx.assemble_vector(gradient, self.forms.volume_gradient)
        found = 2 * np.pi * changes @ gradient
        return found if self.comm.size == 1 else np.asarray(self.comm.allreduce(found))

    def dissipation_rate(self) -> float:
        """Return the dissipation of growth (12) in the trial state, µm³ MPa/min."""
        if self.growth is None:
            return 0.0
        return dx.assemble_scalar(self.forms.dissipation, self.comm)
