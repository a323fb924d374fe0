"""A sphere compressed by two opposite point forces, F = 4 E h²/(R √(3 (1 - ν²))) u at each.

E. Reissner, Stresses and small displacements of shallow spherical shells, J. Math. Phys. 25, 1946,
80-85 and 279-300. The theory is the limit of a thin shell; the difference decreases as h/R and
h/R ln(h/R), the next terms for the whole sphere.
"""

from __future__ import annotations

import numpy as np
from benchmark import Row, figure_axes, show

from fenics_yeast import Scene, simulate

YOUNG, POISSON, R = 1000.0, 0.3, 1.0
RATIOS = np.array([1 / 25, 1 / 50, 1 / 100, 1 / 200])


def relative_stiffness(h: float) -> float:
    """Return the stiffness at one pole over the published one."""
    published = 4 * YOUNG * h**2 / (R * np.sqrt(3 * (1 - POISSON**2)))
    scene = Scene.from_toml(f"""
    cell = {{ shape = "sphere", diameter = {2 * R} }}
    wall = {{ law = "linear", thickness = {h}, young_modulus = {YOUNG}, poisson_ratio = {POISSON} }}
    turgor = {{ pressure = 0 }}
    load = {{ point_force = {-1e-4 * h * published} }}
    numerics = {{ elements = 60, order = 4, thickness_points = 2 }}
    """)
    row = simulate(scene).history.rows[-1]
    return 2 * row.force_uN / row.displacement_um / published


def rows(found: np.ndarray | None = None) -> list[Row]:
    found = np.array([relative_stiffness(h) for h in RATIOS]) if found is None else found
    terms = np.column_stack([np.ones_like(RATIOS), RATIOS, RATIOS * np.log(RATIOS)])
    limit = np.linalg.lstsq(terms, found, rcond=None)[0][0]
    table = [Row.near("stiffness / theirs, h/R to 0", limit, 1.0, 1e-3)]
    for ratio, value in zip(RATIOS, found, strict=True):
        table.append(Row.near(f"stiffness / theirs, h/R = {ratio:g}", value, 1.0, 2 * ratio))
    return table


def main() -> None:
    found = np.array([relative_stiffness(h) for h in RATIOS])
    show(rows(found))
    with figure_axes("point_load") as axes:
        axes.plot(RATIOS, found, "o-", color="#0072b2", label="shell")
        axes.axhline(1, color="0.6", label="Reissner")
        axes.set(xlabel="h / R", ylabel="stiffness / Reissner's", xlim=(0, None))


if __name__ == "__main__":
    main()
