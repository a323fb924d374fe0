"""One discretised wall: unknowns, growth state, potential and the forms that follow from it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import CONSTRAINED, Discretisation
from . import growth_laws as growth
from . import hyperelasticity as wall
from . import kinematics
from .fields import PointField
from .growth_state import GrowthState
from .growth_weights import WeightField, Weights
from .laws import Law, Parameter
from .loads import NodalForce

Array = NDArray[np.float64]

_ELASTIC, _GROWING = 0, 1
_AXIAL, _ROTATION = 1, 2
# Keeps the pivots of the shear force off zero; V/V0 is that of γ = 0 to 10 digits from here on.
_LARGEST_PENALTY = 1e8
_NO_VOLUME = 1e-9


@dataclass(frozen=True)
class ShellState:
    """Copy of the state of a shell.

    Attributes
    ----------
    w
        Local coefficients of displacement, rotation and shear force, ghosts among them.
    eps_g
        Growth strains of the local growing cells; None for an elastic wall.
    """

    w: Array
    eps_g: Array | None


class Shell:
    """A wall of revolution on an interval mesh.

    The total potential per 2π is

        Π = ∫ [∫ ψ(ε(ξ) - ε^g(ξ)) dξ + Q γ - Q²/(2 κ μ h)] R dS - p ∫ ½ r² z' dS

    with the shear force `Q` as an unknown beside displacement and director rotation: eliminated,
    it gives the penalty `½ κ μ h γ²`, but Newton's method does not feel κ.

    Parameters
    ----------
    discretisation
        Reference meridian, cells and zones.
    comm
        MPI communicator that shares the mesh.
    order
        Lagrange degree of displacement and rotation.
    thickness_points
        Number of Gauss points through the thickness.
    thickness, shear_modulus, shear_penalty
        `h` in µm, μ in MPa, κ; an infinite κ holds `γ = 0`.
    energy
        Strain energy ψ of the elastic logarithmic strains.
    thicker, stiffer
        What thickness and moduli are multiplied by, where the wall has zones.
    growth_law
        Growth rate in the zone; None for an elastic wall, which then has no growth state.
    per_grown
        Whether the energy is per volume of the grown wall, not of the reference wall.
    thinning
        Elastic strain through the wall; None where it keeps its thickness.
    bending
        False for a membrane, whose only unknown is the displacement.

    Attributes
    ----------
    w
        Trial state `(u_r, u_z, β, Q)`, a function of the mixed space.
    pressure
        Turgor in MPa, a constant of the forms.
    force
        Force along the axis at a node, or None.
    bending, membrane_stiffness
        Whether the wall resists bending; `E h` of its size, in µN/µm.
    reference_volume
        Volume in µm³ that ratios refer to: that of the unloaded cell or, where that is none, of
        a half sphere on the edge.
    growth
        Growth strains of the growing cells, or None.
    eps, xi
        Logarithmic strains `(ε1, ε2)` at each thickness point, in UFL, and the points' distance
        from the mid-surface in µm, outward positive.
    quadrature_S
        Arc length of the quadrature points of each local cell, shape ``(cells, points)``.
    residual, tangent, volume_gradient
        Compiled derivative of Π by the state; its second derivative at given growth, which is
        symmetric; derivative of the enclosed volume per 2π, which is minus that of the residual
        by the pressure (`pressure_force` where an edge is free, else None).
    consistent_tangent, stage_force
        Compiled derivatives of the residual, by the state and by the stage's length, when growth
        follows the strain in its stage; None for an elastic wall.
    conditions, constrained
        Conditions at the ends, all homogeneous, and their local degrees of freedom.
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
        energy: Law,
        thickness_ratio: Parameter = 1.0,
        modulus_ratio: Parameter = 1.0,
        growth_law: Law | None = None,
        per_grown: bool = False,
        thinning: Law | None = None,
        bending: bool = True,
    ) -> None:
        self.discretisation = discretisation
        self.mesh = mesh = dx.interval_mesh(comm, discretisation.nodes)
        self.comm = mesh.comm
        self.degree = 2 * order - 1  # as many Gauss points as the order: no locking
        self.bending, self.membrane_stiffness = bending, 3 * shear_modulus * thickness
        self.space = (dx.shell_space if bending else dx.membrane_space)(mesh, order)
        self.w = dx.fem.Function(self.space)
        self.pressure = self._constant(0.0)
        points = thickness_points if bending else 1
        self._zeta, self._weights = np.polynomial.legendre.leggauss(points)
        self.xi: Array = self._zeta * thickness / 2
        self._place_points()
        self._h = self._constant(thickness)
        penalty = min(shear_penalty, _LARGEST_PENALTY)
        self._compliance = self._constant(1 / (penalty * shear_modulus * thickness))
        psi = energy.on(self._coefficient)
        if thickness_ratio != 1:
            thickened = self._coefficient(thickness_ratio)
            self._h, self._compliance = self._h * thickened, self._compliance / thickened
        if modulus_ratio != 1:
            scaled = self._coefficient(modulus_ratio)
            psi = wall.scaled(psi, scaled)
            self._compliance = self._compliance / scaled
        self._constrain_ends()
        through = None if thinning is None else thinning.on(self._coefficient)
        self.material = wall.Material(psi, per_grown, through)

        self._describe()
        self.growth = None
        if growth_law is not None:
            self._growth_weights: list[WeightField] = []
            rate = growth_law.on(self._coefficient)
            self.growth = GrowthState(
                mesh,
                self.growing_elements,
                self.degree,
                self.eps,
                self.material,
                rate,
                self._growth_weights,
            )
        self._derive()
        self.force = None
        if discretisation.loaded is not None:
            self.force = NodalForce(self.w, self.comm, discretisation.loaded, thickness)
        self.reference_volume = self._reference_volume()

    # --- reference wall and boundary conditions -------------------------------------------

    def _constant(self, value: float) -> Any:
        return dx.fem.Constant(self.mesh, np.float64(value))

    def _coefficient(self, value: Parameter) -> Any:
        """A parameter of a law as a constant, or as a function given at the quadrature points."""
        if isinstance(value, Weights):
            place = (self.mesh, self.growing_elements, self.degree, self.quadrature_S)
            field = WeightField(*place, kinematics.stretch(self._strain[0]), value)
            self._growth_weights.append(field)
            return field.function
        if not callable(value):
            return self._constant(value)
        space = dx.quadrature_space(self.mesh, 1, self.degree)
        function = dx.fem.Function(space)
        function.x.array[dx.dof_array(space)] = value(self.quadrature_S)
        return function[0]

    def _place_points(self) -> None:
        """Reference meridian at the quadrature points; which cells grow."""
        places = dx.quadrature_points(self.degree).ravel()
        vertices = self.mesh.geometry.x[dx.element_vertices(self.mesh), 0]
        S = vertices[:, :1] + (vertices[:, 1:] - vertices[:, :1]) * places
        space = dx.quadrature_space(self.mesh, 3, self.degree)
        curve = self.discretisation.curve
        self._reference = dx.fem.Function(space)
        values = np.stack([curve.radius(S), curve.angle(S), curve.curvature(S)], axis=-1)
        self._reference.x.array[dx.dof_array(space)] = values.reshape(len(S), -1)

        grows = np.zeros(len(S), dtype=bool)
        for part in self.discretisation.growing:
            grows |= part.holds(S.mean(axis=1))
        self.growing_elements = np.flatnonzero(grows).astype(np.int32)
        tags = dx.element_tags(self.mesh, np.where(grows, _GROWING, _ELASTIC).astype(np.int32))
        metadata = {"quadrature_degree": self.degree, "quadrature_rule": "default"}
        self._dS = ufl.Measure("dx", domain=self.mesh, subdomain_data=tags, metadata=metadata)
        self.quadrature_S = S

    def _constrain_ends(self) -> None:
        """Hold what regularity asks at the poles, and what the edges' supports take."""
        ends = zip(self.discretisation.ends, self.discretisation.ends_at, strict=True)
        held = [
            (i, S) for end, S in ends for i in CONSTRAINED[end] if self.bending or i < _ROTATION
        ]
        if all(i != _AXIAL for i, _ in held):
            held.append((_AXIAL, 0.0))  # else a closed cell could move along its axis
        dofs = [(dx.end_dofs(self.space, i, S), dx.motion_part(self.space, i)) for i, S in held]
        zero = self._constant(0.0)
        self.conditions = [dx.fem.dirichletbc(zero, d, part) for d, part in dofs]
        self.constrained = np.concatenate([d for d, _ in dofs])

    # --- the wall in UFL ------------------------------------------------------------------

    def _describe(self) -> None:
        """Strains at each thickness point from the trial state, equations (1) to (6)."""
        self._R, Phi, Phi_S = (self._reference[i] for i in range(3))
        if not self.bending:
            self._describe_membrane(Phi)
            return
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
        parts = kinematics.strains(reference, self._current)
        self._gamma = parts.gamma
        self._strain = ufl.as_vector([parts.E1m, parts.E2m, parts.E1b, parts.E2b])
        # The energy depends on the state through these four numbers alone.
        self._E = ufl.variable(self._strain)
        E1m, E2m, E1b, E2b = (self._E[i] for i in range(4))
        parts = kinematics.Strains(E1m, E2m, E1b, E2b, parts.gamma)
        self.eps = []
        for zeta in self._zeta:
            E = kinematics.green_lagrange(parts, float(zeta) * self._h / 2)
            self.eps.append(ufl.as_vector([kinematics.logarithmic(E_i) for E_i in E]))

    def _describe_membrane(self, Phi: Any) -> None:
        """The same without rotation, at the mid-surface alone."""
        u_r, u_z = (self.w[i] for i in range(2))
        r, r_S, z_S = self._R + u_r, ufl.cos(Phi) + u_r.dx(0), ufl.sin(Phi) + u_z.dx(0)
        self._current = kinematics.Meridian(r, r_S, z_S, psi=None, psi_S=None)
        self._strain = ufl.as_vector(kinematics.membrane_strains(self._R, r, r_S, z_S))
        self._E = ufl.variable(self._strain)
        self.eps = [ufl.as_vector([kinematics.logarithmic(self._E[i]) for i in range(2)])]

    def _resultants(self, eps_g: list[Any]) -> list[Any]:
        """Part of each thickness point in the resultants `(N1, N2, M1, M2)` of the wall.

        `eps_g` holds the growth strains at the points; empty where nothing grows.
        """
        parts = []
        for j, (weight, eps) in enumerate(zip(self._weights, self.eps, strict=True)):
            energy = self.material.energy(eps, eps_g[j] if eps_g else None)
            energy = float(weight) * self._h / 2 * energy
            parts.append(ufl.diff(energy, self._E))
        return parts

    def _derive(self) -> None:
        """Residual and tangents of the potential.

        The energy enters through its derivatives by the membrane and bending strains, which are
        the stress resultants `(N1, N2, M1, M2)` and their tangent: the same forms as those of
        `ufl.derivative` on the whole, in a third of the operations.
        """
        v, dw = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        d_E = ufl.derivative(self._strain, self.w, v)
        D_E = ufl.derivative(self._strain, self.w, dw)
        dD_E = ufl.derivative(d_E, self.w, dw)
        lagrangian = -self.pressure * self._enclosed
        if self.bending:
            shear = (self._Q * self._gamma - self._Q**2 * self._compliance / 2) * self._R
            lagrangian = shear - self.pressure * self._enclosed
        residual, tangent = 0, 0
        elastic = self._resultants([])
        eps_g: list[Any] = []
        if self.growth is not None:
            eps_g = [ufl.variable(self.growth.strain(j)) for j in range(len(self.eps))]
        growing = self._resultants(eps_g)
        regions = [(_ELASTIC, elastic), (_GROWING, growing)]
        for tag, parts in regions[: 1 if self.growth is None else 2]:
            dS, resultants = self._dS(tag), reduce(add, parts)
            rest = ufl.derivative(lagrangian * dS, self.w, v)
            residual += ufl.dot(resultants, d_E) * self._R * dS + rest
            tangent += ufl.dot(d_E, ufl.diff(resultants, self._E) * D_E) * self._R * dS
            tangent += ufl.dot(resultants, dD_E) * self._R * dS
            tangent += ufl.derivative(rest, self.w, dw)
        enclosed = self._enclosed * self._dS
        # On an edge that may move along the axis pressure does not act on the opening, as the
        # enclosed volume would have it: what is taken off has no potential.
        opening = self._opening(v)
        self.pressure_force = None
        if opening is not None:
            residual += self.pressure * opening
            tangent += ufl.derivative(self.pressure * opening, self.w, dw)
            force = opening - ufl.derivative(enclosed, self.w, v)
            self.pressure_force = dx.compile_form(force)
        self.residual = dx.compile_form(residual)
        self.tangent = dx.compile_form(tangent)
        self.volume_gradient = dx.compile_form(ufl.derivative(enclosed, self.w, v))
        self._volume = dx.compile_form(2 * np.pi * enclosed)
        self.consistent_tangent = self.stage_force = self._dissipation = None
        if self.growth is not None:
            by_growth = [ufl.diff(part, g) for part, g in zip(growing, eps_g, strict=True)]
            followed, lengthened = self._follow(self.growth, by_growth)
            dS = self._dS(_GROWING)
            tangent += ufl.dot(d_E, followed * D_E) * self._R * dS
            self.consistent_tangent = dx.compile_form(tangent)
            self.stage_force = dx.compile_form(ufl.dot(d_E, lengthened) * self._R * dS)
            self._dissipation = self._compile_dissipation(self.growth)

    def _opening(self, v: Any) -> Any:
        """Work of unit pressure on the opening of a free upper edge; None where there is none."""
        if self.discretisation.ends[1] != "free":
            return None
        curve = self.discretisation.curve
        tags = dx.end_tag(self.mesh, curve.length)
        R = self._constant(float(curve.radius(np.array([curve.length]))[0]))
        motion, change = (ufl.split(f)[0] if self.bending else f for f in (self.w, v))
        ds = ufl.Measure("ds", domain=self.mesh, subdomain_data=tags)
        return (R + motion[0]) ** 2 / 2 * change[_AXIAL] * ds(1)

    def _follow(self, state: GrowthState, by_growth: list[Any]) -> tuple[Any, Any]:
        """Derivatives of the resultants by strain and by stage that go through the growth update.

        They are evaluated once for each tangent, on the growing cells, and enter its form as
        numbers, 4 by 4 and 4: far less to compile than their expressions.
        """
        changes = list(zip(by_growth, state.by_strain, self.eps, strict=True))
        D = reduce(add, [N_g * g_eps * ufl.diff(eps, self._E) for N_g, g_eps, eps in changes])
        d = reduce(add, [N_g * g_a for N_g, g_a in zip(by_growth, state.by_stage, strict=True)])
        place = (self.mesh, self.growing_elements, self.degree)
        n = len(self._strain)
        self._followed = PointField(*place, [D[i, j] for i in range(n) for j in range(n)])
        self._lengthened = PointField(*place, [d[i] for i in range(n)])
        f = self._followed.function
        matrix = ufl.as_matrix([[f[n * i + j] for j in range(n)] for i in range(n)])
        return matrix, self._lengthened.function

    def differentiate(self) -> None:
        """Bring `consistent_tangent` and `stage_force` up to the trial state."""
        self._followed.update()
        self._lengthened.update()

    @property
    def _enclosed(self) -> Any:
        """Enclosed volume per 2π and reference arc length."""
        return self._current.r**2 * self._current.z_S / 2

    def _compile_dissipation(self, state: GrowthState) -> Any:
        total = 0
        for point, rate, weight in zip(state.points, state.rates, self._weights, strict=True):
            dV = float(weight) * self._h / 2 * self._R
            total += growth.dissipation(point, rate) * dV
        return dx.compile_form(2 * np.pi * total * self._dS(_GROWING))

    # --- state and functionals ------------------------------------------------------------

    def state(self) -> ShellState:
        """Copy of the trial state."""
        eps_g = None if self.growth is None else self.growth.get()
        return ShellState(self.w.x.array.copy(), eps_g)

    def restore(self, state: ShellState) -> None:
        """Make a copy the trial state again."""
        self.w.x.array[:] = state.w
        if self.growth is not None and state.eps_g is not None:
            self.growth.set(state.eps_g)

    def volume(self) -> float:
        """Volume enclosed by the mid-surface in the trial state, µm³."""
        return dx.assemble_scalar(self._volume, self.comm)

    def _reference_volume(self) -> float:
        volume, curve = self.volume(), self.discretisation.curve
        largest = float(curve.radius(np.linspace(0, curve.length, 101)).max())
        half_sphere = 2 * np.pi / 3 * largest**3
        return volume if volume > _NO_VOLUME * half_sphere else half_sphere

    def dissipation_rate(self) -> float:
        """Dissipation of growth (12) in the trial state, µm³ MPa/min; zero without growth."""
        if self.growth is None:
            return 0.0
        return dx.assemble_scalar(self._dissipation, self.comm)
