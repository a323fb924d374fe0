"""Buckling with waves around the axis: rings, spheres, cylinders, clamped caps and a capsule.

Ring: (n² - 1) E h³/(12 (1 - ν²) R³), sphere: 2 E (h/R)²/√(3 (1 - ν²)), from which the difference
falls with h/R: S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 1961. Cylinders between
simple ends: W. Flügge, Stresses in Shells, 1960, whose equations are solved here. Clamped shallow
caps, ν = 1/3: N.-C. Huang, Unsymmetrical buckling of thin shallow spherical shells, J. Appl. Mech.
31 (1964) 447-457. Capsule: values of a prototype of ours, none are published.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from benchmark import Row, figure_axes, show

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import buckling_modes, build_shell
from fenics_yeast.solve import Equilibrium, WaveModes

HUANG = {6: (2, 0.775), 7: (3, 0.760), 8: (4, 0.766), 10: (5, 0.776)}  # λ: waves, p/p0
CAPSULE = {"Ogden": 0.0087192, "linear": 0.0073918}  # MPa
WALLS = {
    "Ogden": "thickness = 0.1, shear_modulus = 40",
    "linear": 'thickness = 0.1, law = "linear", young_modulus = 120, poisson_ratio = 0.3',
}


def first(cell: str, wall: str, until: float, elements: int) -> tuple[int, float]:
    """Return waves and external pressure in MPa at the first bifurcation of a wall."""
    scene = Scene.from_toml(f"""
    cell = {{ {cell} }}
    wall = {{ {wall} }}
    path = {{ until = {{ pressure = {until} }}, steps = 30, stop_at_bifurcation = true }}
    numerics = {{ elements = {elements}, thickness_points = 2 }}
    """)
    found = simulate(scene).bifurcation
    assert found is not None
    return found.waves, -found.pressure_MPa


def linear(thickness: float, young: float, poisson: float) -> str:
    return (
        f'thickness = {thickness}, law = "linear", young_modulus = {young}, '
        f"poisson_ratio = {poisson}"
    )


def ring() -> Row:
    young, poisson, radius, thickness = 1000.0, 0.3, 100.0, 0.5
    classical = 3 * young * thickness**3 / (12 * (1 - poisson**2) * radius**3)
    cell = f'shape = "cylinder", diameter = {2 * radius}, length = 100, edge = "guided"'
    _, found = first(cell, linear(thickness, young, poisson), -1.3 * classical, 8)
    return Row.near("ring, n = 2, p/p classical", found / classical, 1.0, 1e-4)


def spheres() -> list[Row]:
    rows = []
    for ratio, elements, allowed in ((0.02, 60, 0.02), (0.005, 120, 0.005)):
        classical = 2 * 120.0 * ratio**2 / np.sqrt(3 * (1 - 0.3**2))
        wall = linear(2.5 * ratio, 120.0, 0.3)
        _, found = first('shape = "sphere", diameter = 5', wall, -1.2 * classical, elements)
        what = f"sphere, h/R = {ratio:g}, p/p classical"
        rows.append(Row.near(what, found / classical, 1.0, allowed))
    return rows


def fluegge(young: float, nu: float, radius: float, h: float, length: float, n: int) -> float:
    """Return the external pressure in MPa at which a cylinder between simple ends buckles.

    Flügge's equations of a cylinder with n waves around and half a wave along the axis, under
    lateral pressure p and axial compression: ν p R per length where the ends keep their distance.
    """
    k, x = h**2 / (12 * radius**2), np.pi * radius / length
    n2, x2 = n**2, x**2
    row_1 = [
        -x2 - (1 - nu) / 2 * n2 * (1 + k),
        (1 + nu) / 2 * x * n,
        nu * x + k * (x**3 - (1 - nu) / 2 * x * n2),
    ]
    row_2 = [
        (1 + nu) / 2 * x * n,
        -n2 - (1 - nu) / 2 * x2 * (1 + 3 * k),
        -n - k * (3 - nu) / 2 * x2 * n,
    ]
    row_3 = [-row_1[2], -row_2[2], 1 + k * ((x2 + n2) ** 2 - 2 * n2 + 1)]
    load = np.array([[n2, 0, x], [0, n2, n], [-x, -n, -n2]]) + nu * np.diag([x2, x2, -x2])
    q = scipy.linalg.eigvals([row_1, row_2, row_3], -load).real
    return float(q[q > 0].min() * young * h / (1 - nu**2) / radius)


def cylinders() -> list[Row]:
    """Guided ends are planes of symmetry: half a wave between them is one between simple ends.

    With as many waves around the axis, the mode of a ring comes before. Flügge neglects h/R.
    """
    young, nu, radius, length, rows = 1000.0, 0.3, 100.0, 150.0, []
    for h, waves in ((1.0, (4, 5, 6)), (0.25, (6, 7, 8))):
        shell = build_shell(
            Scene.from_toml(f"""
            cell = {{ shape = "cylinder", diameter = 200, length = {length}, edge = "guided" }}
            wall = {{ {linear(h, young, nu)} }}
            turgor = {{ pressure = 0 }}
            numerics = {{ elements = 24, thickness_points = 2 }}
            """)
        )
        with Equilibrium(shell, 1e-9 * h**2) as equilibrium, WaveModes(shell) as modes:
            for n in waves:
                published = fluegge(young, nu, radius, h, length, n)
                below, above = 0.95 * published, 1.05 * published
                while above - below > 1e-5 * above:
                    shell.pressure.value = -(below + above) / 2
                    equilibrium.solve()
                    falls = modes.negative_modes(n) > 1
                    below, above = (below, (below + above) / 2) if falls else (
                        (below + above) / 2, above
                    )  # fmt: skip
                what = f"cylinder, h/R = {h / radius:g}, n = {n}, p/p Flügge"
                rows.append(Row.near(what, (below + above) / 2 / published, 1.0, h / radius))
    return rows


def caps() -> list[Row]:
    young, poisson, radius = 1000.0, 1 / 3, 1000.0
    root = np.sqrt(3 * (1 - poisson**2))
    classical = 2 * young / radius**2 / root
    rows = []
    for shape, (waves, published) in HUANG.items():
        angle = np.degrees(np.arccos(1 - shape**2 / (4 * root) / radius))
        cell = f'shape = "cap", radius = {radius}, half_angle = {angle}'
        n, found = first(cell, linear(1.0, young, poisson), -classical, 30)
        rows.append(Row.near(f"cap, λ = {shape}, waves", n, waves, 0.0))
        rows.append(Row.near(f"cap, λ = {shape}, p/p0", found / classical, published, 0.01))
    return rows


def capsules() -> list[Row]:
    rows = []
    for name, published in CAPSULE.items():
        cell = 'shape = "capsule", diameter = 5, length = 15'
        n, found = first(cell, WALLS[name], -0.02, 40)
        rows.append(Row.near(f"capsule, {name} wall, waves", n, 3, 0.0))
        rows.append(Row.near(f"capsule, {name} wall, MPa", found, published, 1e-4))
    return rows


def rows() -> list[Row]:
    return [ring(), *spheres(), *cylinders(), *caps(), *capsules()]


def main() -> None:
    show(rows())
    with figure_axes("circumferential") as axes:
        for name, wall in WALLS.items():
            scene = Scene.from_toml(f"""
            cell = {{ shape = "capsule", diameter = 5, length = 15 }}
            wall = {{ {wall} }}
            turgor = {{ pressure = 0 }}
            numerics = {{ elements = 40, thickness_points = 2 }}
            path = {{ until = {{ pressure = -0.01 }} }}
            """)
            modes = list(buckling_modes(scene, range(1, 9)))
            axes.semilogy(
                [mode.waves for mode in modes],
                [-1e3 * (mode.pressure or np.nan) for mode in modes],
                "o-",
                label=f"capsule, {name} wall",
            )
        axes.set(xlabel="waves around the axis", ylabel="critical external pressure (kPa)")


if __name__ == "__main__":
    main()
