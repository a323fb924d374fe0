"""Residual and tangents of the wall, derived from its potential by UFL."""

from functools import reduce
from operator import add
from typing import Any

import numpy as np
import ufl

from .. import _dolfinx as dx
from ..geometry import Array
from . import growth_laws
from .deformation import Deformation, resultants
from .growth_state import GrowthState
from .quadrature import EvaluatedFunction
from .reference import AXIAL, ELASTIC, GROWING, Reference
from .section import Section


class Forms:
    """Compiled forms of a wall.

    The energy enters through its derivatives by the membrane and bending strains: the stress
    resultants `(N1, N2, M1, M2)` and their tangent. These are the forms of `ufl.derivative` on
    the whole potential, in a third of the operations. Forms of growth are None in an elastic wall.

    Attributes
    ----------
    residual, tangent
        Derivative of the potential Π by the state; its second derivative at given growth, which
        is symmetric.
    volume, volume_gradient
        Enclosed volume in µm³; derivative of the enclosed volume per 2π by the state.
    pressure_force
        Minus the derivative of the residual by the pressure, less `volume_gradient`, if the upper
        edge is free; otherwise None, because the two are the same.
    consistent_tangent, stage_force
        Derivatives of the residual by the state and by the stage's length with growth updated.
    dissipation
        Dissipation of growth (12) in µm³ MPa/min.
    """

    def __init__(
        self,
        reference: Reference,
        section: Section,
        w: Any,
        deformation: Deformation,
        pressure: Any,
        growth: GrowthState | None,
    ) -> None:
        self._reference, self._section, self._w = reference, section, w
        self._deformation, self._pressure = deformation, pressure
        self._dS, R = reference.measure(), deformation.R
        v, dw = ufl.TestFunction(w.function_space), ufl.TrialFunction(w.function_space)
        d_E = ufl.derivative(deformation.strain, w, v)
        D_E = ufl.derivative(deformation.strain, w, dw)
        dD_E = ufl.derivative(d_E, w, dw)
        parts_of = {ELASTIC: resultants(section, deformation, [])}
        eps_g: list[Any] = []
        if growth is not None:
            eps_g = [ufl.variable(growth.strain(j)) for j in range(len(deformation.eps))]
            parts_of[GROWING] = resultants(section, deformation, eps_g)
        residual, tangent = 0, 0
        for tag, parts in parts_of.items():
            dS, N = self._dS(tag), reduce(add, parts)
            rest = ufl.derivative(self._lagrangian() * dS, w, v)
            residual += ufl.dot(N, d_E) * R * dS + rest
            tangent += ufl.dot(d_E, ufl.diff(N, deformation.E) * D_E) * R * dS
            tangent += ufl.dot(N, dD_E) * R * dS
            tangent += ufl.derivative(rest, w, dw)
        enclosed = deformation.enclosed * self._dS
        # Pressure does not act on the opening of an edge that moves along the axis, although the
        # enclosed volume depends on it. This correction has no potential.
        opening = self._opening(v)
        self.pressure_force = None
        if opening is not None:
            residual += pressure * opening
            tangent += ufl.derivative(pressure * opening, w, dw)
            self.pressure_force = dx.compile_form(opening - ufl.derivative(enclosed, w, v))
        self.residual = dx.compile_form(residual)
        self.tangent = dx.compile_form(tangent)
        self.volume_gradient = dx.compile_form(ufl.derivative(enclosed, w, v))
        self.volume = dx.compile_form(2 * np.pi * enclosed)
        self.consistent_tangent = self.stage_force = self.dissipation = None
        if growth is not None:
            by_growth = [ufl.diff(N, g) for N, g in zip(parts_of[GROWING], eps_g, strict=True)]
            dN_dE, dN_dstage = self._through_growth(growth, by_growth)
            dS = self._dS(GROWING)
            tangent += ufl.dot(d_E, dN_dE * D_E) * R * dS
            self.consistent_tangent = dx.compile_form(tangent)
            self.stage_force = dx.compile_form(ufl.dot(d_E, dN_dstage) * R * dS)
            self.dissipation = self._compile_dissipation(growth)

    def update(self) -> None:
        """Update `consistent_tangent` to the trial state."""
        self._dN_dE.update()

    def update_stage_force(self) -> None:
        """Update `stage_force`, which only paths need, to the trial state."""
        self._dN_dstage.update()

    def set_response(self, by_strain: Array) -> None:
        """Update `consistent_tangent`, where this response of growth is known.

        `by_strain` is the derivative of the resultants by the strains through the growth update at
        the points of the growing elements, shape ``(points, strains, strains)``.
        """
        self._dN_dE.set(by_strain)

    def _lagrangian(self) -> Any:
        """Return the density of Π without strain energy: shear and pressure."""
        wall, pressure = self._deformation, self._pressure
        if wall.Q is None:
            return -pressure * wall.enclosed
        shear = (wall.Q * wall.gamma - wall.Q**2 * self._section.compliance / 2) * wall.R
        return shear - pressure * wall.enclosed

    def _opening(self, v: Any) -> Any:
        """Return the work of unit pressure on the opening of a free upper edge, if there is one."""
        reference = self._reference
        if reference.discretisation.ends[1] != "free":
            return None
        tags = dx.end_tag(reference.mesh, reference.discretisation.curve.length)
        shell = self._deformation.Q is not None
        motion, change = (ufl.split(f)[0] if shell else f for f in (self._w, v))
        ds = ufl.Measure("ds", domain=reference.mesh, subdomain_data=tags)
        return (reference.edge_radius + motion[0]) ** 2 / 2 * change[AXIAL] * ds(1)

    def _through_growth(self, growth: GrowthState, by_growth: list[Any]) -> tuple[Any, Any]:
        """Return the resultants' derivatives by strain and by stage through the growth update.

        They are evaluated once for each tangent and enter its form as 4 by 4 and 4 numbers, which
        compiles much faster than their expressions.
        """
        wall, points = self._deformation, self._reference.growing_points
        changes = list(zip(by_growth, growth.by_strain, wall.eps, strict=True))
        D = reduce(add, [N_g * g_eps * ufl.diff(eps, wall.E) for N_g, g_eps, eps in changes])
        d = reduce(add, [N_g * g_a for N_g, g_a in zip(by_growth, growth.by_stage, strict=True)])
        n = len(wall.strain)
        self._dN_dE = EvaluatedFunction(points, [D[i, j] for i in range(n) for j in range(n)])
        self._dN_dstage = EvaluatedFunction(points, [d[i] for i in range(n)])
        f = self._dN_dE.function
        matrix = ufl.as_matrix([[f[n * i + j] for j in range(n)] for i in range(n)])
        return matrix, self._dN_dstage.function

    def _compile_dissipation(self, growth: GrowthState) -> Any:
        total = 0
        points = zip(growth.wall_points, growth.rates, self._section.weights, strict=True)
        for point, rate, weight in points:
            dV = weight * self._deformation.R
            total += growth_laws.dissipation(point, rate) * dV
        return dx.compile_form(2 * np.pi * total * self._dS(GROWING))
