"""Residual and tangents of the wall, derived from its potential by UFL."""

from __future__ import annotations

from functools import reduce
from operator import add
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from .. import _dolfinx as dx
from . import growth_laws
from .deformation import Deformation
from .fields import PointField
from .growth_state import GrowthState
from .hyperelasticity import Material
from .reference import AXIAL, ELASTIC, GROWING, Reference

Array = NDArray[np.float64]


class Forms:
    """Compiled forms of a wall.

    The energy enters through its derivatives by the membrane and bending strains: the stress
    resultants `(N1, N2, M1, M2)` and their tangent. These are the forms of `ufl.derivative` on
    the whole potential, in a third of the operations.

    Parameters
    ----------
    reference, w, deformation
        The unloaded wall, the trial state and its strains.
    pressure
        Turgor in MPa, a constant.
    material, growth
        Material of the wall; its growth strains, or None.
    weights
        Weights of the through-thickness integration points, each times `h/2`, in UFL.
    compliance
        `1/(κ μ h)`, in UFL.

    Attributes
    ----------
    residual, tangent
        Derivative of the potential Π by the state; its second derivative at given growth, which
        is symmetric.
    volume, volume_gradient
        Enclosed volume in µm³; derivative of the enclosed volume per 2π by the state.
    pressure_force
        Minus the derivative of the residual by the pressure, less `volume_gradient`, where an
        edge is free; else None: the two are the same.
    consistent_tangent, stage_force
        Derivatives of the residual by the state and by the stage's length, when growth follows
        the strain in its stage; None for an elastic wall.
    dissipation
        Dissipation of growth (12) in µm³ MPa/min; None for an elastic wall.
    """

    def __init__(
        self,
        reference: Reference,
        w: Any,
        deformation: Deformation,
        pressure: Any,
        material: Material,
        growth: GrowthState | None,
        weights: list[Any],
        compliance: Any,
    ) -> None:
        self._reference, self._w, self._deformation = reference, w, deformation
        self._pressure, self._material, self._weights = pressure, material, weights
        self._compliance, self._dS = compliance, reference.measure()
        space, self._R = w.function_space, deformation.R
        v, dw = ufl.TestFunction(space), ufl.TrialFunction(space)
        d_E = ufl.derivative(deformation.strain, w, v)
        D_E = ufl.derivative(deformation.strain, w, dw)
        dD_E = ufl.derivative(d_E, w, dw)
        residual, tangent = 0, 0
        elastic = self._resultants([])
        eps_g: list[Any] = []
        if growth is not None:
            eps_g = [ufl.variable(growth.strain(j)) for j in range(len(deformation.eps))]
        growing = self._resultants(eps_g)
        regions = [(ELASTIC, elastic), (GROWING, growing)]
        for tag, parts in regions[: 1 if growth is None else 2]:
            dS, resultants = self._dS(tag), reduce(add, parts)
            rest = ufl.derivative(self._lagrangian() * dS, w, v)
            residual += ufl.dot(resultants, d_E) * self._R * dS + rest
            tangent += ufl.dot(d_E, ufl.diff(resultants, deformation.E) * D_E) * self._R * dS
            tangent += ufl.dot(resultants, dD_E) * self._R * dS
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
            by_growth = [ufl.diff(part, g) for part, g in zip(growing, eps_g, strict=True)]
            followed, lengthened = self._follow(growth, by_growth)
            dS = self._dS(GROWING)
            tangent += ufl.dot(d_E, followed * D_E) * self._R * dS
            self.consistent_tangent = dx.compile_form(tangent)
            self.stage_force = dx.compile_form(ufl.dot(d_E, lengthened) * self._R * dS)
            self.dissipation = self._compile_dissipation(growth)

    def update(self) -> None:
        """Update `consistent_tangent` and `stage_force` to the trial state."""
        self._followed.update()
        self._lengthened.update()

    def _lagrangian(self) -> Any:
        """Return the density of Π without strain energy: shear and pressure."""
        wall, pressure = self._deformation, self._pressure
        if wall.Q is None:
            return -pressure * wall.enclosed
        shear = (wall.Q * wall.gamma - wall.Q**2 * self._compliance / 2) * self._R
        return shear - pressure * wall.enclosed

    def _resultants(self, eps_g: list[Any]) -> list[Any]:
        """Return the resultants' parts of each integration point; `eps_g` is empty if elastic."""
        parts = []
        for j, (weight, eps) in enumerate(zip(self._weights, self._deformation.eps, strict=True)):
            energy = weight * self._material.energy(eps, eps_g[j] if eps_g else None)
            parts.append(ufl.diff(energy, self._deformation.E))
        return parts

    def _opening(self, v: Any) -> Any:
        """Return the work of unit pressure on the opening of a free upper edge, if there is one."""
        reference = self._reference
        if reference.discretisation.ends[1] != "free":
            return None
        curve = reference.discretisation.curve
        tags = dx.end_tag(reference.mesh, curve.length)
        R = reference.constant(float(curve.radius(np.array([curve.length]))[0]))
        shell = self._deformation.Q is not None
        motion, change = (ufl.split(f)[0] if shell else f for f in (self._w, v))
        ds = ufl.Measure("ds", domain=reference.mesh, subdomain_data=tags)
        return (R + motion[0]) ** 2 / 2 * change[AXIAL] * ds(1)

    def _follow(self, state: GrowthState, by_growth: list[Any]) -> tuple[Any, Any]:
        """Return the resultants' derivatives by strain and by stage through the growth update.

        They are evaluated once for each tangent, in the growing elements, and enter its form as
        4 by 4 and 4 numbers, which compiles much faster than their expressions.
        """
        changes = list(zip(by_growth, state.by_strain, self._deformation.eps, strict=True))
        E = self._deformation.E
        D = reduce(add, [N_g * g_eps * ufl.diff(eps, E) for N_g, g_eps, eps in changes])
        d = reduce(add, [N_g * g_a for N_g, g_a in zip(by_growth, state.by_stage, strict=True)])
        reference = self._reference
        place = (reference.mesh, reference.growing_elements, reference.degree)
        n = len(self._deformation.strain)
        self._followed = PointField(*place, [D[i, j] for i in range(n) for j in range(n)])
        self._lengthened = PointField(*place, [d[i] for i in range(n)])
        f = self._followed.function
        matrix = ufl.as_matrix([[f[n * i + j] for j in range(n)] for i in range(n)])
        return matrix, self._lengthened.function

    def _compile_dissipation(self, state: GrowthState) -> Any:
        total = 0
        for point, rate, weight in zip(state.points, state.rates, self._weights, strict=True):
            dV = weight * self._R
            total += growth_laws.dissipation(point, rate) * dV
        return dx.compile_form(2 * np.pi * total * self._dS(GROWING))
