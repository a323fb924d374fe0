"""A capsule and a spheroid that grow everywhere, compared with a second program in NumPy.

The second program shares no code with the package: two-node elements with one point each, forces
derived by hand, tangents by complex steps, a penalty on the shear strain instead of its multiplier,
and the classical Runge-Kutta method for growth. Its V/V0 is extrapolated from two meshes by its
order, 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from benchmark import Row, figure_axes, show
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from fenics_yeast import Scene, simulate

MU, H, KAPPA, PRESSURE, THRESHOLD, TIME = 40.0, 0.1, 1000.0, 0.15, 1.0, 45.0
DIAMETER, LENGTH, END = 4.0, 7.0, 5.0
Array = np.ndarray


@dataclass(frozen=True)
class Places:
    """Nodes of a meridian by arc length, and R, Φ, Φ' at the midpoints of its elements."""

    S: Array
    R: Array
    Phi: Array
    bend: Array


def capsule(n: int) -> Places:
    a, side = DIAMETER / 2, LENGTH - DIAMETER
    arc = np.linspace(0, np.pi * a / 2, n // 3 + 1)
    bar = arc[-1] + np.linspace(0, side, n // 3 + 1)
    S = np.concatenate([arc, bar[1:], bar[-1] + arc[1:]])
    middle = (S[1:] + S[:-1]) / 2
    below, above = middle < arc[-1], middle > bar[-1]
    Phi = np.where(below, middle, np.where(above, middle - side, arc[-1])) / a
    return Places(S, a * np.sin(Phi), Phi, np.where(below | above, 1 / a, 0.0))


def spheroid(n: int) -> Places:
    a, c = DIAMETER / 2, LENGTH / 2
    t = np.linspace(0, np.pi, 200_001)
    speed = np.hypot(a * np.cos(t), c * np.sin(t))
    along = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(t))])
    S = np.linspace(0, along[-1], n + 1)
    t = np.interp((S[1:] + S[:-1]) / 2, along, t)
    speed = np.hypot(a * np.cos(t), c * np.sin(t))
    Phi = np.arctan2(c * np.sin(t), a * np.cos(t))
    return Places(S, a * np.sin(t), Phi, a * c / speed**3)


class Wall:
    """Two-node elements of a growing wall; the state holds `u_r, u_z, β` of each node."""

    def __init__(self, places: Places) -> None:
        self.places, self.L = places, np.diff(places.S)
        n = len(self.L)
        self.u = np.zeros(3 * (n + 1))
        self.zeta, self.weights = np.polynomial.legendre.leggauss(3)
        self.grown = np.zeros((3, 2, n))  # at each through-thickness integration point
        self.dofs = 3 * np.arange(n)[:, None] + np.arange(6)
        # Derivatives of r, r', z', ψ, ψ' by the six DOFs of an element.
        self.by = np.zeros((n, 5, 6))
        for row, i, kind in ((0, 0, 0), (1, 0, 1), (2, 1, 1), (3, 2, 0), (4, 2, 1)):
            ends = np.array([-1.0, 1.0]) / self.L[:, None] if kind else np.full((n, 2), 0.5)
            self.by[:, row, i], self.by[:, row, i + 3] = ends.T
        constrained = [0, 1, 2, 3 * n, 3 * n + 2]
        self.free = np.setdiff1d(np.arange(3 * (n + 1)), constrained)

    def measures(self, u: Array) -> Array:
        """Return `r, r', z', ψ, ψ'` of each element, shape ``(5, n)``."""
        p = self.places
        reference = np.array([p.R, np.cos(p.Phi), np.sin(p.Phi), p.Phi, p.bend])
        return reference + np.einsum("nij,nj->in", self.by, u[self.dofs])

    def strains(self, s: Array, j: int) -> tuple[Array, Array]:
        """Return `λ1², λ2²` at an integration point."""
        p, xi = self.places, self.zeta[j] * H / 2
        r, a, b, psi, psi_S = s
        one = (a * np.cos(psi) + b * np.sin(psi)) * psi_S - p.bend
        two = (r * np.sin(psi) / p.R - np.sin(p.Phi)) / p.R
        return a**2 + b**2 + 2 * xi * one, (r / p.R) ** 2 + 2 * xi * two

    def stresses(self, s: Array, j: int, grown: Array) -> tuple[Array, Array, Array, Array]:
        """Return `λ1², λ2²` and the neo-Hookean Kirchhoff stresses."""
        A, B = self.strains(s, j)
        e, f = np.log(A) / 2 - grown[j, 0], np.log(B) / 2 - grown[j, 1]
        across = np.exp(-2 * (e + f))
        return A, B, MU * (np.exp(2 * e) - across), MU * (np.exp(2 * f) - across)

    def forces(self, s: Array, grown: Array, pressure: float) -> Array:
        """Return the derivatives of the potential by `r, r', z', ψ, ψ'`, shape ``(5, n)``."""
        R = self.places.R
        r, a, b, psi, psi_S = s
        N1 = N2 = M1 = M2 = 0
        for j, weight in enumerate(self.weights):
            A, B, one, two = self.stresses(s, j, grown)
            one, two, xi = weight * H / 2 * one / A, weight * H / 2 * two / B, self.zeta[j] * H / 2
            N1, N2, M1, M2 = N1 + one, N2 + two, M1 + xi * one, M2 + xi * two
        sin, cos = np.sin(psi), np.cos(psi)
        Q = KAPPA * MU * H * (a * sin - b * cos)
        return np.array([
            N2 * r / R + M2 * sin / R - pressure * r * b,
            R * (N1 * a + M1 * cos * psi_S + Q * sin),
            R * (N1 * b + M1 * sin * psi_S - Q * cos) - pressure * r**2 / 2,
            R * (M1 * (b * cos - a * sin) * psi_S + Q * (a * cos + b * sin)) + M2 * r * cos / R,
            R * M1 * (a * cos + b * sin),
        ])  # fmt: skip

    def settle(self, grown: Array, pressure: float) -> None:
        """Solve for equilibrium at given growth by Newton's method."""
        for _ in range(30):
            s = self.measures(self.u).astype(complex)
            force = self.forces(s.real, grown, pressure)
            tangent = np.empty((len(self.L), 5, 5))
            for i in range(5):
                s[i] += 1e-30j
                tangent[:, :, i] = self.forces(s, grown, pressure).imag.T / 1e-30
                s[i] = s[i].real
            f = np.zeros_like(self.u)
            np.add.at(f, self.dofs, np.einsum("nij,in,n->nj", self.by, force, self.L))
            K = np.einsum("nik,nij,njl,n->nkl", self.by, tangent, self.by, self.L)
            rows = np.repeat(self.dofs, 6, axis=1)
            columns = np.tile(self.dofs, 6)
            size = len(self.u)
            K = coo_matrix((K.ravel(), (rows.ravel(), columns.ravel())), (size, size)).tocsc()
            step = spsolve(K[self.free][:, self.free], f[self.free])
            self.u[self.free] -= step
            if abs(step).max() < 1e-10:
                return
        raise RuntimeError("no equilibrium")

    def rate(self, grown: Array) -> Array:
        """Return the rates of the growth strains in equilibrium, equation (13)."""
        self.settle(grown, PRESSURE)
        s, rates = self.measures(self.u), np.empty_like(grown)
        for j in range(3):
            A, B, one, two = self.stresses(s, j, grown)
            size = np.hypot(one, two)
            excess = np.maximum(size / (np.sqrt(A * B) * THRESHOLD) - 1, 0) / TIME
            rates[j] = excess * one / size, excess * two / size
        return rates

    def grow(self, end: float, steps: int) -> None:
        """Take classical Runge-Kutta steps."""
        dt = end / steps
        for _ in range(steps):
            k1 = self.rate(self.grown)
            k2 = self.rate(self.grown + dt / 2 * k1)
            k3 = self.rate(self.grown + dt / 2 * k2)
            k4 = self.rate(self.grown + dt * k3)
            self.grown = self.grown + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        self.settle(self.grown, PRESSURE)

    def volume(self) -> float:
        r, _, b, _, _ = self.measures(self.u)
        return float(np.pi * (r**2 * b * self.L).sum())


def reference(places: Callable[[int], Places], n: int = 150, steps: int = 10) -> float:
    """Return V/V0, extrapolated from n and 2 n elements."""
    ratios = []
    for elements in (n, 2 * n):
        wall = Wall(places(elements))
        unloaded = wall.volume()
        for part in (0.25, 0.5, 0.75, 1.0):
            wall.settle(wall.grown, part * PRESSURE)
        wall.grow(END, steps)
        ratios.append(wall.volume() / unloaded)
    return (4 * ratios[1] - ratios[0]) / 3


def scene(shape: str) -> Scene:
    key = "length" if shape == "capsule" else "height"
    return Scene.from_toml(f"""
    title = "{shape}"
    cell = {{ shape = "{shape}", diameter = {DIAMETER}, {key} = {LENGTH} }}
    wall = {{ thickness = {H}, shear_modulus = {MU} }}
    turgor = {{ pressure = {PRESSURE}, ramp = 0 }}
    run = {{ end = {END} }}
    [growth]
    zone = {{ pole = "top", half_angle = 180 }}
    threshold = {THRESHOLD}
    time = {TIME}
    [numerics]
    elements = 48
    thickness_points = 3
    shear_penalty = {KAPPA}
    tolerance = 1e-6
    """)


def rows() -> list[Row]:
    found = []
    for shape, places in (("capsule", capsule), ("spheroid", spheroid)):
        ours = simulate(scene(shape)).history.volume_ratio[-1]
        found.append(Row.near(f"V/V0 of a {shape} at {END:g} min", ours, reference(places), 2e-6))
    return found


def main() -> None:
    show(rows())
    with figure_axes("growing_shapes") as axes:
        for shape, colour in (("capsule", "#0072b2"), ("spheroid", "#d55e00")):
            history = simulate(scene(shape)).history
            axes.plot(history.time_min, history.volume_ratio, color=colour, label=shape)
        axes.set(xlabel="time (min)", ylabel="volume V/V₀")


if __name__ == "__main__":
    main()
