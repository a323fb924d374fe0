"""A clamped round plate under pressure at large deflection, its edge immovable, ν = 0.3.

S. Way's problem (Trans. ASME 56, 1934, 627-636), von Kármán's plate theory solved to the digits
given: deflection of the middle over the thickness for Q = q a⁴/(E h⁴). The theory is the limit of
a thin shell; here a/h = 67.
"""

from __future__ import annotations

import numpy as np
from benchmark import Row, figure_axes, show

from fenics_yeast import Scene, simulate

YOUNG, A, H = 1e4, 1.0, 0.015
TABLE = {1: 0.16803, 2: 0.32284, 3: 0.45884, 10: 1.05196, 20: 1.49379, 50: 2.198, 100: 2.856}

SCENE = Scene.from_toml(f"""
title = "Clamped plate"
cell = {{ shape = "disc", diameter = {2 * A}, edge = "clamped" }}
wall = {{ law = "linear", thickness = {H}, young_modulus = {YOUNG}, poisson_ratio = 0.3 }}
turgor = {{ pressure = 0 }}
path = {{ until = {{ pressure = 1 }}, control = "pressure", steps = 10 }}
numerics = {{ elements = 16, order = 3, thickness_points = 2 }}
""")


def deflection(Q: float) -> float:
    """Return the deflection of the middle over the thickness."""
    scene = SCENE.with_values({"path.until.pressure": Q * YOUNG * (H / A) ** 4})
    return float(simulate(scene).history.pole_height_um[-1] / H)


def rows() -> list[Row]:
    return [Row.near(f"w/h at Q = {Q}", deflection(Q), w, 1e-4) for Q, w in TABLE.items()]


def main() -> None:
    found = rows()
    show(found)
    with figure_axes("clamped_plate") as axes:
        Q = np.array(list(TABLE))
        axes.plot(Q, [row.found for row in found], color="#0072b2", label="shell, a/h = 67")
        axes.plot(Q, list(TABLE.values()), "o", color="#d55e00", label="von Kármán")
        axes.plot(Q[:3], Q[:3] * 3 * (1 - 0.09) / 16, "--", color="0.6", label="linear")
        axes.set(xlabel="q a⁴ / (E h⁴)", ylabel="deflection / thickness")


if __name__ == "__main__":
    main()
