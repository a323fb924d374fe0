"""The inverse problem: find the unloaded meridian whose equilibrium under a pressure is an outline.

A fixed point, accelerated by Anderson's method: the displacement from an assumed meridian to its
equilibrium is the next one to be taken off the outline. Each equilibrium starts from the outline,
so that the branch is its own even close to a limit point. If the whole pressure fails, or leads to
an unstable equilibrium such as a folded wall, it is raised in steps, and the displacement is
extrapolated from one to the next.

References
----------
D. G. Anderson, Iterative procedures for nonlinear integral equations, J. ACM 12 (1965) 547-560.
M. Sellier, An iterative method for the inverse elasto-static problem, J. Fluids Struct. 27 (2011)
1461-1470 (the fixed point).
"""

import warnings
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _dolfinx as dx
from ..geometry import Array, Discretisation, Parametric, curve_through, displaced
from ..mechanics import Shell
from .equilibrium import Equilibrium, EquilibriumError
from .stability import Stability

_MEMORY = 6  # displacements that Anderson's method combines
_MOST, _MOST_BETWEEN = 40, 20  # equilibria at the pressure, and at one between
_FINALLY = 1e-3  # of the distance that is enough: then differences of runs are smooth, too
_BETWEEN = 1e-3  # of the radius: distance that is good enough at a pressure between
_QUICK = 8  # equilibria after which the next step of the pressure is longer
_LONGER, _SHORTER = 1.5, 0.5
_SMALLEST = 1 / 64  # step, in parts of the pressure


class InverseShape(NamedTuple):
    """The displacement from the unloaded meridian to an outline.

    Attributes
    ----------
    t, displacement
        Parameters of the outline, shape ``(n,)``, and `(u_r, u_z)` in µm there, ``(n, 2)``.
    distance
        Largest distance of the equilibrium from the outline in µm.
    """

    t: Array
    displacement: Array
    distance: float


class InversionError(RuntimeError):
    """No unloaded shape was found; `part` of the pressure was reached, at some `distance` in µm."""

    def __init__(self, part: float, distance: float) -> None:
        super().__init__(f"stopped at {part:.3g} of the pressure")
        self.part, self.distance = part, distance


class _LostError(Exception):
    """An equilibrium farther from the outline than its size."""


class OutlineInversion:
    """An outline, and the wall that is to be inflated to it, on one rank.

    Parameters
    ----------
    outline
        The meridian under pressure.
    t
        Parameters of the outline at the ends of the elements, increasing.
    mesh_on
        Returns elements on an assumed meridian, which has the parameter of the outline.
    shell_on
        Returns the unloaded shell on them; it may be the same one, reset.
    tolerance
        Norm of the residual in µN that counts as zero.
    """

    def __init__(
        self,
        outline: Parametric,
        t: Array,
        mesh_on: Callable[[Parametric], Discretisation],
        shell_on: Callable[[Discretisation], Shell],
        tolerance: float,
    ) -> None:
        self._outline, self._mesh_on, self._shell_on = outline, mesh_on, shell_on
        self._tolerance, self._vertices = tolerance, t
        mesh = mesh_on(outline)
        lower, upper = mesh.ends
        self._poles = lower == "pole", upper == "pole"
        self._shell = shell_on(mesh)
        self._t = self._parameters(outline, self._shell)
        places = outline.point(self._t, 0)
        self._radius, self._size = float(places[0].max()), float(max(map(np.ptp, places)))
        self._equilibria, self._distance = 0, np.inf

    def solve(self, pressure: float, distance: float) -> InverseShape:
        """Find the unloaded meridian for a pressure in MPa, to a distance in µm.

        Raises
        ------
        InversionError
            If there is none, or it was not found.
        """
        found, step = [(0.0, np.zeros((len(self._t), 2)))], 1.0
        while (reached := found[-1][0]) < 1:
            part = min(1.0, reached + step)
            enough = distance if part == 1 else max(distance, _BETWEEN * self._radius)
            before, guess = self._equilibria, _extrapolated(found[-3:], part)
            displacement = self._fixed_point(guess, part * pressure, enough, part == 1)
            if displacement is None:
                step *= _SHORTER
                if step < _SMALLEST:
                    raise InversionError(reached, self._distance)
                continue
            found.append((part, displacement))
            if self._equilibria - before < _QUICK:
                step *= _LONGER
        return InverseShape(self._t, found[-1][1], self._distance)

    def _fixed_point(
        self, guess: Array, pressure: float, enough: float, last: bool
    ) -> Array | None:
        """Return the displacement that is its own equilibrium's; None if it is not found."""
        from scipy.linalg import LinAlgWarning  # late, as few scenes need it
        from scipy.optimize import root

        best = np.inf, guess

        def change(flat: Array) -> Array:
            nonlocal best
            assumed = flat.reshape(-1, 2)
            change = self._inflated(assumed, pressure) - assumed
            distance = float(np.hypot(*change.T).max())
            if distance > self._size:
                raise _LostError
            best = min(best, (distance, assumed.copy()), key=lambda pair: pair[0])
            return np.ravel(change)

        stop = _FINALLY * enough if last else enough
        options = {
            "fatol": stop / np.sqrt(2),
            "maxiter": _MOST if last else _MOST_BETWEEN,
            "line_search": None,
            "jac_options": {"alpha": 1.0, "M": _MEMORY},
        }
        try:
            with warnings.catch_warnings(), np.errstate(invalid="ignore"):
                warnings.simplefilter("error", LinAlgWarning)  # only round-off is left to combine
                root(change, guess.ravel(), method="anderson", options=options)
        except (_LostError, EquilibriumError, LinAlgWarning, np.linalg.LinAlgError):
            pass
        self._distance, displacement = best
        good = self._distance <= enough and self._is_stable(displacement, pressure)
        return displacement if good else None

    def _is_stable(self, assumed: Array, pressure: float) -> bool:
        self._inflated(assumed, pressure)  # as before, hence found
        with Stability(self._shell) as stability:
            return stability.negative_modes() == 0

    def _inflated(self, assumed: Array, pressure: float) -> Array:
        """Return the displacement to the equilibrium of a meridian, at the outline's parameters."""
        self._equilibria += 1
        meridian = displaced(self._outline, self._t, -assumed, self._poles)
        self._shell = shell = self._shell_on(self._mesh_on(meridian))
        curve = shell.discretisation.curve
        S, dofs = _nodes(shell)
        t = self._parameters(meridian, shell)
        r_t, z_t = self._outline.point(t, 1)
        rotation = np.arctan2(z_t, r_t) - curve.angle(S)
        rotation -= 2 * np.pi * np.rint(rotation / (2 * np.pi))
        start = np.column_stack(
            [*np.subtract(self._outline.point(t, 0), (curve.radius(S), curve.height(S))),
             rotation / shell.rotation]
        )  # fmt: skip
        motion = shell.w.x.array
        motion[dofs] = start[:, : dofs.shape[1]]
        motion[shell.constrained] = 0
        shell.pressure.value = pressure
        with Equilibrium(shell, self._tolerance) as equilibrium:
            equilibrium.solve()
        found = motion[dofs[:, :2]] + np.column_stack([curve.radius(S), curve.height(S)])
        found -= np.column_stack(meridian.point(t, 0))  # elements may be straight
        return np.column_stack(curve_through(t, found, self._poles).point(self._t, 0))

    def _parameters(self, meridian: Parametric, shell: Shell) -> Array:
        """Return the parameters of the nodes of a shell, the ends exactly."""
        S, _ = _nodes(shell)
        along = meridian.arc_length(self._vertices)
        t = meridian.parameter(np.interp(S, shell.discretisation.nodes, along))
        t[[0, -1]] = 0.0, meridian.end
        return t


def _nodes(shell: Shell) -> tuple[Array, NDArray[np.int32]]:
    """Return arc length and DOFs of the nodes, from the lower to the upper end."""
    S, dofs = dx.node_dofs(shell.space)
    order = np.argsort(S)
    return S[order], dofs[order]


def _extrapolated(found: Sequence[tuple[float, Array]], part: float) -> Array:
    """Return the displacement at a part of the pressure by the polynomial through others."""
    total = np.zeros_like(found[0][1])
    for known, displacement in found:
        factors = [(part - other) / (known - other) for other, _ in found if other != known]
        total += np.prod(factors) * displacement
    return total
