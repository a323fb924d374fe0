"""Second variation of the potential of a shell for perturbations with waves around the axis.

An axisymmetric state is perturbed by

    u = a cos(nθ) e_r + b sin(nθ) e_θ + c cos(nθ) e_z

and a rotation of the director `d = sin ψ e_r - cos ψ e_z` by β cos(nθ) in the meridian's plane and
by ω sin(nθ) across it. The unknowns on the meridian are `a`, `s = a + b`, `c`, β and
`τ = ω + β cos Φ`, and two shear forces: regularity at a pole for n = 1 is then `s = c = τ = 0`, and
an edge may hold only β. To second order, with `x` the current position and commas for derivatives
by arc length S and by angle θ over R,

    δE_ij = (x,i · u,j + x,j · u,i + u,i · u,j) / 2        in the mid-surface,
    δγ_i = u,i · d + x,i · δd + u,i · δd                   in shear,

bending likewise from `x,i · d,j`, where `d` keeps its length (docs/model.md has all terms). Stress
resultants and their tangent are those of the axisymmetric form; the stiffness against shear in the
surface is `(S1 - S2) / (C1 - C2)` of the principal stresses and squared stretches, by the law's
isotropy. Pressure follows the wall, dead forces along the axis contribute nothing. The mean over
θ leaves one form on the interval, in which n is a constant.
"""

from functools import reduce
from operator import add
from typing import Any

import numpy as np
import ufl

from .. import _dolfinx as dx
from ..geometry import Array, End
from .deformation import Deformation, resultants
from .growth_state import GrowthState
from .hyperelasticity import Material, kirchhoff_stress
from .reference import ELASTIC, GROWING, Reference
from .section import Section

RADIAL, S_, AXIAL, ROTATION, TWIST = range(5)  # components of (a, s, c, β, τ)
_ALIKE = 1e-4  # difference of principal strains that have the shear stiffness of equal ones

# Components that vanish for n >= 2; fewer do at a pole for n = 1.
_CONSTRAINED: dict[End, tuple[int, ...]] = {
    "pole": (RADIAL, S_, AXIAL, ROTATION, TWIST),
    "clamped": (RADIAL, S_, AXIAL, ROTATION, TWIST),
    "hinged": (RADIAL, S_, AXIAL),
    "guided": (AXIAL, ROTATION),
    "sliding": (AXIAL,),
    "free": (),
}
_POLE_OF_ONE_WAVE = (S_, AXIAL, TWIST)


class SecondVariation:
    """The second variation around the trial state of a shell, for one number of waves at a time.

    Attributes
    ----------
    space
        Space of the perturbation.
    waves
        The number of waves n >= 1, a constant of the form.
    form
        The compiled bilinear form, symmetric.
    """

    def __init__(
        self,
        reference: Reference,
        section: Section,
        deformation: Deformation,
        pressure: Any,
        growth: GrowthState | None,
        order: int,
    ) -> None:
        self._reference = reference
        self.space = dx.circumferential_space(reference.mesh, order, deformation.Q is not None)
        self.waves = reference.constant(2.0)
        v = dx.fem.Function(self.space)
        density = _Density(section, deformation, v, self.waves)
        measure = reference.measure()
        total = 0
        for tag in (ELASTIC,) if growth is None else (ELASTIC, GROWING):
            eps_g: list[Any] = []
            if tag == GROWING and growth is not None:
                eps_g = [growth.strain(j) for j in range(len(deformation.eps))]
            total += (density.elastic(eps_g) * deformation.R - pressure * density.volume) * measure(
                tag
            )
        w, dw = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        self.form = dx.compile_form(ufl.derivative(ufl.derivative(total, v, w), v, dw))
        self._conditions: dict[bool, list[Any]] = {}
        self._rotation = section.rotation

    def conditions(self, waves: int) -> list[Any]:
        """Return the conditions at the ends, all homogeneous, for a number of waves."""
        one = waves == 1
        if one not in self._conditions:
            self._conditions[one] = self.supports(one) + (self._fix() if one else [])
        return self._conditions[one]

    def supports(self, one_wave: bool) -> list[Any]:
        """Return the conditions of poles and edges for one wave, or for more."""
        discretisation = self._reference.discretisation
        fixed = []
        for end, S in zip(discretisation.ends, discretisation.ends_at, strict=True):
            pole = end == "pole" and one_wave
            fixed += [(i, S) for i in (_POLE_OF_ONE_WAVE if pole else _CONSTRAINED[end])]
        return self._held(fixed)

    def rigid_motions(self) -> list[Array]:
        """Return motion across the axis and tilt of the unloaded wall, with one wave.

        In the DOFs that this rank owns; only tilt about the middle of the coordinates.
        """
        S, dofs = dx.node_dofs(self.space)
        curve, size = self._reference.discretisation.curve, len(dx.is_motion(self.space))
        across, tilt = np.zeros(size), np.zeros(size)
        across[dofs[:, RADIAL]] = 1
        tilt[dofs[:, RADIAL]], tilt[dofs[:, AXIAL]] = curve.height(S), -curve.radius(S)
        if dx.is_mixed(self.space):
            tilt[dofs[:, ROTATION]] = -1 / float(self._rotation.value)
        return [across, tilt]

    def _fix(self) -> list[Any]:
        """Return what keeps a wall from moving across its axis and from tilting, if it can."""
        discretisation, fixed = self._reference.discretisation, []
        ends, bending = discretisation.ends, dx.is_mixed(self.space)
        if ends == ("pole", "pole"):
            # No motion across the axis and no tilt; a membrane has no rotation to fix.
            first, last = discretisation.ends_at
            fixed += [(RADIAL, first), (ROTATION, first) if bending else (RADIAL, last)]
        elif not {"clamped", "hinged"} & {*ends}:
            fixed.append((RADIAL, discretisation.ends_at[0]))  # no motion across the axis
        return self._held(fixed)

    def _held(self, fixed: list[tuple[int, float]]) -> list[Any]:
        """Return the conditions that hold components of the motion at ends."""
        zero, bending = self._reference.constant(0.0), dx.is_mixed(self.space)
        return [
            dx.fem.dirichletbc(zero, dx.end_dofs(self.space, i, S), dx.motion_part(self.space, i))
            for i, S in fixed
            if bending or i < ROTATION
        ]


class _Density:
    """Densities of the second variation per reference area and per 2π, in UFL.

    A motion `v` has the components (a, s, c, β, τ) and the shear forces; of a membrane (a, s, c).
    """

    def __init__(self, section: Section, deformation: Deformation, v: Any, waves: Any) -> None:
        self._section, self._deformation = section, deformation
        wall, n = deformation, waves
        r, r_S, z_S = wall.current[:3]
        self._bending = wall.Q is not None
        self._shear: Any = None
        motion = v
        if self._bending:
            motion, self._shear = ufl.split(v)
        a, b, c = motion[0], motion[1] - motion[0], motion[2]
        # Derivatives of u by S and by θ, the latter with sin, cos, sin of nθ.
        u_S = (a.dx(0), motion[1].dx(0) - a.dx(0), c.dx(0))
        u_t = (-n * a - b, a + n * b, -n * c)
        x_S, x_t = (r_S, 0, z_S), (0, r, 0)
        self._u_S, self._u_t, self._x_S, self._x_t = u_S, u_t, x_S, x_t
        R = wall.R
        self._first = [_dot(x_S, u_S), _dot(x_t, u_t) / R**2]
        self._second = [_dot(u_S, u_S) / 2, _dot(u_t, u_t) / 2 / R**2]
        self._E12m = (_dot(x_S, u_t) + _dot(u_S, x_t)) / (2 * R)
        self._E12b: Any = 0
        self.volume = (
            a * (u_t[1] * z_S + r * u_S[2])
            + b * (u_t[2] * r_S - u_t[0] * z_S)
            - c * (u_t[1] * r_S + r * u_S[0])
        ) / 2
        if self._bending:
            self._rotate(motion, n)

    def _rotate(self, motion: Any, n: Any) -> None:
        """Add what the rotation of the director contributes."""
        wall, section, u_S, u_t = self._deformation, self._section, self._u_S, self._u_t
        r, _, _, psi, psi_S = wall.current
        R, Phi, Phi_S = wall.R, wall.Phi, wall.Phi_S
        beta, tau = (section.rotation * motion[i] for i in (ROTATION, TWIST))
        beta_S, tau_S = (section.rotation * motion[i].dx(0) for i in (ROTATION, TWIST))
        omega = tau - beta * ufl.cos(Phi)
        # Φ is given at quadrature points: its derivative by hand.
        omega_S = tau_S - beta_S * ufl.cos(Phi) + beta * ufl.sin(Phi) * Phi_S
        sin, cos = ufl.sin(psi), ufl.cos(psi)
        d, t = (sin, 0, -cos), (cos, 0, sin)
        d_S, d_t = tuple(psi_S * x for x in t), (0, sin, 0)
        # Change of the director to first order; to second order it gets shorter along itself.
        e = (beta * cos, omega, beta * sin)
        e_S = (
            beta_S * cos - beta * psi_S * sin, omega_S, beta_S * sin + beta * psi_S * cos
        )  # fmt: skip
        e_t = (-n * beta * cos - omega, beta * cos + n * omega, -n * beta * sin)
        short, short_S = beta**2 + omega**2, 2 * (beta * beta_S + omega * omega_S)
        x_S, x_t, gamma = self._x_S, self._x_t, wall.gamma
        self._first += [
            _dot(u_S, d_S) + _dot(x_S, e_S),
            (_dot(u_t, d_t) + _dot(x_t, e_t)) / R**2,
        ]
        self._second += [
            _dot(u_S, e_S) - (short_S * gamma + short * psi_S * _dot(x_S, t)) / 2,
            (_dot(u_t, e_t) - short * r * sin / 2) / R**2,
        ]
        twisted = _dot(u_S, d_t) + _dot(x_S, e_t) + _dot(u_t, d_S) + _dot(x_t, e_S)
        self._E12b = twisted / (2 * R)
        self._gamma_1 = _dot(u_S, d) + _dot(x_S, e)
        self._gamma_1_second = _dot(u_S, e) - short * gamma / 2
        self._gamma_2 = (_dot(u_t, d) + _dot(x_t, e)) / R

    def elastic(self, eps_g: list[Any]) -> Any:
        """Return the density of energy and shear; `eps_g` is empty where the wall is elastic."""
        wall, section = self._deformation, self._section
        N = reduce(add, resultants(section, wall, eps_g))
        first, second = ufl.as_vector(self._first), ufl.as_vector(self._second)
        total = ufl.dot(first, ufl.diff(N, wall.E) * first) / 2 + ufl.dot(N, second)
        points = zip(section.weights, section.distances, wall.eps, strict=True)
        for j, (weight, xi, eps) in enumerate(points):
            parts = self._E12m, xi * self._E12b
            total += weight * _in_surface(
                section.material, eps, eps_g[j] if eps_g else None, *parts
            )
        if not self._bending:
            return total
        Q1, Q2 = (section.shear_force * self._shear[i] for i in range(2))
        total += wall.Q * self._gamma_1_second + Q1 * self._gamma_1 + Q2 * self._gamma_2
        return total - (Q1**2 + Q2**2) * section.compliance / 2


def _in_surface(material: Material, eps: Any, eps_g: Any, E12m: Any, E12b: Any) -> Any:
    """Return the energy of a small shear strain between the principal directions.

    It is the sum of that of the mid-surface and that of the twist. Where the stiffness is negative,
    at large strains of some walls, stresses on the rotating director would outweigh it, in a term
    of second order in the distance that the theory neglects. There the twist has that term, with
    the stiffness `2 (τ1 - τ2) / (C1² - C2²)`.
    """
    elastic = ufl.variable(eps if eps_g is None else eps - eps_g)
    tau = kirchhoff_stress(material.psi, elastic)
    S = [tau[i] * ufl.exp(-2 * elastic[i]) for i in range(2)]
    C = [ufl.exp(2 * elastic[i]) for i in range(2)]
    limit: Any = 0
    for i in range(2):
        change = ufl.diff(S[i], elastic)
        limit += (change[i] / C[i] - change[1 - i] / C[1 - i]) / 4
    alike = ufl.lt(abs(elastic[0] - elastic[1]), _ALIKE)
    stiffness = ufl.conditional(
        alike, limit, (S[0] - S[1]) / ufl.conditional(alike, 1.0, C[0] - C[1])
    )
    grown: Any = 1
    if eps_g is not None:
        grown = ufl.exp(eps_g[0] + eps_g[1])
    stresses = ufl.conditional(stiffness < 0, (S[0] + S[1]) / (C[0] + C[1]), 0.0)
    energy = (stiffness * (E12m + E12b) ** 2 + stresses * E12b**2) * 2 / grown**2
    return energy * grown if material.per_grown else energy


def _dot(x: tuple[Any, ...], y: tuple[Any, ...]) -> Any:
    return reduce(add, [x[i] * y[i] for i in range(3)])
