"""A flat neo-Hookean membrane with a fixed rim, inflated beyond its limit point.

Membrane theory leads to ordinary differential equations (J. E. Adkins and R. S. Rivlin, Phil.
Trans. R. Soc. A 244, 1952, 505-531), which were integrated to 1e-11. The table has p R/(μ h) and
the height of the pole over the radius by the stretch at the pole.
"""

from __future__ import annotations

import numpy as np
from benchmark import Row, figure_axes, show

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import Result

MU, H, R = 40.0, 0.01, 1.0
TABLE = {
    1.05: (0.234941, 0.274093),
    1.1: (0.527782, 0.383472),
    1.5: (1.643582, 0.798789),
    3.0: (1.807922, 1.488846),
}
LIMIT = 1.87917, 2.196  # p R/(μ h) and the stretch at the pole

SCENE = Scene.from_toml(f"""
title = "Flat membrane"
cell = {{ shape = "disc", diameter = {2 * R} }}
wall = {{ thickness = {H}, shear_modulus = {MU}, bending = false }}
turgor = {{ pressure = 0 }}
path = {{ until = {{ volume_ratio = 2.6 }}, steps = 250 }}
numerics = {{ elements = 40, order = 4, grading = "uniform" }}
""")


def inflated() -> Result:
    """Return the path from the plane, where the membrane has no stiffness, past the limit point."""
    return simulate(SCENE)


def rows(result: Result | None = None) -> list[Row]:
    """Compare the loads of the path at the published heights."""
    history = (result or inflated()).history
    height, load = history.pole_height_um / R, history.pressure_MPa * R / (MU * H)
    found = []
    for stretch, (published, rise) in TABLE.items():
        here = _cubic(rise, height, load)
        found.append(Row.near(f"p R/μh at the rise {rise} (λ0 = {stretch})", here, published, 1e-5))
    i = int(np.argmax(load))
    near = slice(i - 3, i + 4)
    quartic = np.polynomial.Polynomial.fit(history.volume_ratio[near], load[near], 4)
    volumes = np.linspace(history.volume_ratio[i - 2], history.volume_ratio[i + 2], 10_001)
    top = volumes[np.argmax(quartic(volumes))]
    found.append(Row.near("p R/μh of the limit point", quartic(top), LIMIT[0], 1e-5))
    at_limit = simulate(SCENE.with_values({"path.until": {"volume_ratio": float(top)}}))
    # At the quadrature point next to the pole.
    stretch = np.exp(at_limit.profiles.all[-1].strain[-1, 0, 0])
    found.append(Row.near("stretch of the pole there", stretch, LIMIT[1], 1e-3))
    return found


def _cubic(x: float, xs: np.ndarray, ys: np.ndarray) -> float:
    """Interpolate at x by a cubic through the four nearest points."""
    i = int(np.clip(np.searchsorted(xs, x), 2, len(xs) - 2))
    near = slice(i - 2, i + 2)
    return float(np.polyval(np.polyfit(xs[near] - x, ys[near], 3), 0.0))


def main() -> None:
    result = inflated()
    show(rows(result))
    with figure_axes("membrane_disc") as axes:
        load = result.history.pressure_MPa * R / (MU * H)
        axes.plot(result.history.pole_height_um / R, load, color="#0072b2", label="membrane")
        heights, loads = [rise for _, rise in TABLE.values()], [load for load, _ in TABLE.values()]
        axes.plot(heights, loads, "o", color="#d55e00", label="ordinary differential equations")
        axes.set(xlabel="height of the pole / R", ylabel="p R / (μ h)")


if __name__ == "__main__":
    main()
