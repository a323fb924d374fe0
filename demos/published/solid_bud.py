"""An elastic bud: a soft cap on a stiff sphere under turgor, as a shell and as a solid.

The reference is the same wall as an axisymmetric solid, meshed through its thickness:
incompressible neo-Hookean, quadratic displacements, linear pressures, turgor on its inner face.
Volumes are those enclosed by the mid-surface. The shell's error for thick walls is fitted by powers
of h/R. (The face on which turgor acts makes no difference, because the wall is incompressible.)
"""

from __future__ import annotations

import numpy as np
import ufl
from benchmark import Row, figure_axes, show
from solid import Solid

from fenics_yeast import Scene, simulate

R, MU, SOFT, ANGLE = 2.5, 40.0, 0.25, 40.0
LOAD = 0.12  # p R/(μ h)
RATIOS = np.array([1 / 10, 1 / 20, 1 / 40, 1 / 80])


def shell(h: float) -> float:
    """Return V/V0 - 1 of the shell."""
    scene = Scene.from_toml(f"""
    cell = {{ shape = "sphere", diameter = {2 * R} }}
    turgor = {{ pressure = {LOAD * MU * h / R} }}
    numerics = {{ elements = 60, order = 4 }}
    [wall]
    thickness = {h}
    shear_modulus = {MU}
    zone = [{{ pole = "top", half_angle = {ANGLE}, modulus_factor = {SOFT} }}]
    """)
    return float(simulate(scene).history.volume_ratio[-1] - 1)


def stops(h: float) -> np.ndarray:
    """Return the ends of elements along the meridian, graded towards the edge of the soft cap."""
    length, edge = np.pi * R, np.pi * R * (1 - ANGLE / 180)

    def part(width: float, n: int) -> np.ndarray:
        """Return distances from the edge; elements near it are a part of the thickness long."""
        x = np.linspace(0, 1, n + 1)
        a = np.arcsinh(width / h)
        return width * np.sinh(a * x) / np.sinh(a)

    below, above = part(edge, 36), part(length - edge, 22)
    return np.concatenate([edge - below[::-1], edge + above[1:]])


def solid(h: float) -> float:
    """Return V/V0 - 1 within the mid-surface of the solid."""
    edge = np.pi * R * (1 - ANGLE / 180)

    def sphere(S):
        return R * ufl.sin(S / R), -R * ufl.cos(S / R), S / R

    def energy(F, S):
        mu = ufl.conditional(ufl.gt(S, edge), SOFT * MU, MU)
        return mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(ufl.det(F))  # no multiplier at rest

    wall = Solid(sphere, stops(h), h, energy, incompressible=True)
    poles = [
        wall.hold(0, lambda x, S=S: np.isclose(x[0], S, atol=1e-6 * h)) for S in (0, wall.length)
    ]
    foot = wall.hold(1, lambda x: np.isclose(x[0], 0) & (abs(x[1]) < 1e-6 * h))
    solve = wall.solver([*poles, foot])
    for part in (0.25, 0.5, 0.75, 1.0):
        wall.pressure.value = part * LOAD * MU * h / R
        solve()
    return wall.middle_volume() / (4 / 3 * np.pi * R**3) - 1


def errors() -> np.ndarray:
    """Return the relative errors of V/V0 - 1 of the shell at each h/R."""
    return np.array([shell(ratio * R) / solid(ratio * R) - 1 for ratio in RATIOS])


def fit(found: np.ndarray) -> np.ndarray:
    """Return the coefficients of (h/R)⁰, (h/R)¹, (h/R)² in the error."""
    return np.polynomial.polynomial.polyfit(RATIOS, found, 2)


def rows(found: np.ndarray | None = None) -> list[Row]:
    found = errors() if found is None else found
    table = [Row("error of V/V0 - 1 in the limit h/R = 0", fit(found)[0], 0.0, -2e-4, 2e-4)]
    for ratio, error in zip(RATIOS, found, strict=True):
        table.append(Row(f"error, h/R = {ratio:g}", error, 0.0, -0.11 * ratio, 0.11 * ratio))
    return table


def main() -> None:
    found = errors()
    show(rows(found))
    constant, first, second = fit(found)
    print(f"error of the shell: {constant:.1e} + {first:.3f} h/R + {second:.3f} (h/R)²")
    with figure_axes("solid_bud") as axes:
        axes.loglog(RATIOS, found, "o", color="#0072b2", label="shell, compared with solid")
        x = np.geomspace(RATIOS[-1], RATIOS[0], 100)
        label = f"{first:.2f} h/R + {second:.2f} (h/R)²"
        axes.loglog(x, constant + first * x + second * x**2, color="0.6", label=label)
        axes.set(xlabel="h / R", ylabel="error of V/V₀ - 1")
        axes.set_xticks(RATIOS, [f"1/{1 / ratio:.0f}" for ratio in RATIOS])
        axes.minorticks_off()


if __name__ == "__main__":
    main()
