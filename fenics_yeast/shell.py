"""One discretised wall: unknowns, growth state, potential and the forms that follow from it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.algorithms import expand_derivatives

from . import _dolfinx as dx
from . import growth, kinematics, wall
from .growth_state import GrowthState
from .meridian import Discretisation

Array = NDArray[np.float64]

_ELASTIC, _GROWING = 0, 1


class Shell:
    """A wall of revolution on an interval mesh.

    The total potential per 2π is

        Π = ∫ [∫ ψ(ε(ξ) - ε^g(ξ)) dξ + Q γ - Q²/(2 κ μ h)] R dS - p ∫ ½ r² z' dS

    with the shear force `Q` as an unknown beside displacement and director rotation: eliminated,
    it gives the penalty `½ κ μ h γ²`, but Newton's method does not feel κ.

    Parameters
    ----------
    discretisation
        Reference meridian, cells and growing zone.
    comm
        MPI communicator that shares the mesh.
    order
        Lagrange degree of displacement and rotation.
    thickness_points
        Number of Gauss points through the thickness.
    thickness, shear_modulus, shear_penalty
        `h` in µm, μ in MPa, κ; an infinite κ holds `γ = 0` itself.
    energy
        Strain energy ψ of the elastic logarithmic strains.
    law
        Growth law of the zone; None for an elastic wall, which then has no growth state.

    Attributes
    ----------
    w
        Trial state `(u_r, u_z, β, Q)`, a function of the mixed space.
    pressure
        Turgor in MPa, a constant of the forms.
    growth
        Growth strains of the growing cells, or None.
    conditions, constrained
        Conditions at the poles, all homogeneous, and their local degrees of freedom.
    """

    def __init__(
        self,
        discretisation: Discretisation,
        comm: Any,
        *,
        order: int,
        thickness_points: int,
        thickness: float,
        shear_modulus: float,
        shear_penalty: float,
        energy: wall.StrainEnergy,
        law: growth.GrowthLaw | None = None,
    ) -> None:
        self.discretisation = discretisation
        self.mesh = mesh = dx.interval_mesh(comm, discretisation.nodes)
        self.comm = mesh.comm
        self._degree = 2 * order - 1  # as many Gauss points as the order: no locking
        self.space = dx.shell_space(mesh, order)
        self.w = dx.fem.Function(self.space)
        self.pressure = self._constant(0.0)
        self._h = self._constant(thickness)
        self._compliance = self._constant(1 / (shear_penalty * shear_modulus * thickness))
        self._energy = energy
        self._zeta, self._weights = np.polynomial.legendre.leggauss(thickness_points)
        self._place_points()
        self._constrain_poles()

        self._eps = self._strains()
        self.growth = None
        if law is not None:
            args = (mesh, self.growing_cells, self._degree, self._eps, energy, law)
            self.growth = GrowthState(*args)
        potential = self._potential()
        self._virtual_work = ufl.derivative(potential, self.w)
        self._tangent = ufl.derivative(self._virtual_work, self.w)
        self.residual = dx.compile_form(self._virtual_work)
        self._volume = dx.compile_form(2 * np.pi * self._enclosed())

    # --- reference wall and boundary conditions -------------------------------------------

    def _constant(self, value: float) -> Any:
        return dx.fem.Constant(self.mesh, np.float64(value))

    def _place_points(self) -> None:
        """Reference meridian at the quadrature points; which cells grow."""
        places = dx.quadrature_points(self._degree).ravel()
        vertices = self.mesh.geometry.x[dx.cell_vertices(self.mesh), 0]
        S = vertices[:, :1] + (vertices[:, 1:] - vertices[:, :1]) * places
        space = dx.quadrature_space(self.mesh, 3, self._degree)
        curve = self.discretisation.curve
        self._reference = dx.fem.Function(space)
        values = np.stack([curve.radius(S), curve.angle(S), curve.curvature(S)], axis=-1)
        self._reference.x.array[dx.dof_array(space)] = values.reshape(len(S), -1)

        zone, centres = self.discretisation.zone, S.mean(axis=1)
        grows = np.zeros(len(S), dtype=bool)
        if zone is not None:
            grows = (zone.start < centres) & (centres < zone.end)
        self.growing_cells = np.flatnonzero(grows).astype(np.int32)
        tags = dx.cell_tags(self.mesh, np.where(grows, _GROWING, _ELASTIC).astype(np.int32))
        metadata = {"quadrature_degree": self._degree, "quadrature_rule": "default"}
        self._dS = ufl.Measure(
            "dx", domain=self.mesh, subdomain_data=tags, metadata=metadata
        )
        self.quadrature_S = S

    def _constrain_poles(self) -> None:
        """`u_r = β = 0` at both poles, which regularity asks, and `u_z = 0` at the bottom."""
        top = self.discretisation.curve.length
        held = [(0, 0.0), (1, 0.0), (2, 0.0), (0, top), (2, top)]
        dofs = [(dx.pole_dofs(self.space, (0, i), S), i) for i, S in held]
        zero = self._constant(0.0)
        self.conditions = [
            dx.fem.dirichletbc(zero, d, self.space.sub(0).sub(i)) for d, i in dofs
        ]
        self.constrained = np.concatenate([d for d, _ in dofs])

    # --- the wall in UFL ------------------------------------------------------------------

    def _strains(self) -> list[Any]:
        """Logarithmic strains at each thickness point, equations (1) to (6)."""
        self._R, Phi, Phi_S = (self._reference[i] for i in range(3))
        motion, self._Q = ufl.split(self.w)
        u_r, u_z, beta = (motion[i] for i in range(3))
        reference = kinematics.Meridian(self._R, ufl.cos(Phi), ufl.sin(Phi), Phi, Phi_S)
        self._current = kinematics.Meridian(
            r=reference.r + u_r,
            r_S=reference.r_S + u_r.dx(0),
            z_S=reference.z_S + u_z.dx(0),
            psi=Phi + beta,
            psi_S=Phi_S + beta.dx(0),
        )
        self._parts = kinematics.strains(reference, self._current)
        eps = []
        for zeta in self._zeta:
            E = kinematics.green_lagrange(self._parts, float(zeta) * self._h / 2)
            eps.append(ufl.as_vector([kinematics.logarithmic(E_i) for E_i in E]))
        return eps

    def _enclosed(self) -> Any:
        """Enclosed volume per 2π."""
        return self._current.r**2 * self._current.z_S / 2 * self._dS

    def _potential(self) -> Any:
        """Total potential Π per 2π at given growth."""
        shear = self._Q * self._parts.gamma - self._Q**2 * self._compliance / 2
        potential = shear * self._R * self._dS - self.pressure * self._enclosed()
        for j, (weight, eps) in enumerate(zip(self._weights, self._eps, strict=True)):
            dV = float(weight) * self._h / 2 * self._R
            potential += self._energy(eps) * dV * self._dS(_ELASTIC)
            if self.growth is not None:
                eps_e = kinematics.elastic(eps, self.growth.strain(j))
                potential += self._energy(eps_e) * dV * self._dS(_GROWING)
        return potential

    @cached_property
    def tangent(self) -> Any:
        """Compiled second derivative of the potential at given growth; symmetric."""
        return dx.compile_form(self._tangent)

    @cached_property
    def consistent_tangent(self) -> Any:
        """Compiled derivative of the residual when growth follows the strain in its stage."""
        dw = ufl.TrialFunction(self.space)
        along = []
        for j, eps in enumerate(self._eps):
            d_eps = expand_derivatives(ufl.derivative(eps, self.w, dw))
            followed = self._growing.followed(j, d_eps)
            along += [followed[0], followed[1]]
        follow = ufl.derivative(self._virtual_work, self._growing.eps_g, ufl.as_vector(along))
        return dx.compile_form(self._tangent + follow)

    @cached_property
    def volume_gradient(self) -> Any:
        """Compiled derivative of the enclosed volume per 2π: minus that of the residual by p."""
        return dx.compile_form(ufl.derivative(self._enclosed(), self.w))

    @cached_property
    def _dissipation(self) -> Any:
        state, total = self._growing, 0
        for point, rate, weight in zip(state.points, state.rates, self._weights, strict=True):
            dV = float(weight) * self._h / 2 * self._R
            total += growth.dissipation(point, rate) * dV
        return dx.compile_form(2 * np.pi * total * self._dS(_GROWING))

    @property
    def _growing(self) -> GrowthState:
        if self.growth is None:
            raise ValueError("an elastic wall has no growth state")
        return self.growth

    # --- state and functionals ------------------------------------------------------------

    def volume(self) -> float:
        """Volume enclosed by the mid-surface in the trial state, µm³."""
        return dx.assemble_scalar(self._volume, self.comm)

    def dissipation_rate(self) -> float:
        """Dissipation of growth (12) in the trial state, µm³ MPa/min; zero without growth."""
        if self.growth is None:
            return 0.0
        return dx.assemble_scalar(self._dissipation, self.comm)
