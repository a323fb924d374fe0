"""Decay length of bending at the clamped edge of a cylinder and of a hemisphere.

S. Timoshenko and S. Woinowsky-Krieger, Theory of plates and shells, 1959, chapters 15 and 16: under
pressure the outward displacement over that far from the edge is 1 - exp(-x/l) (cos x/l + sin x/l)
with the length l = √(R h)/(3 (1 - ν²))^¼. For the sphere this is Geckeler's approximation, the
first term in √(h/R).
"""

from __future__ import annotations

import numpy as np
from benchmark import Row, figure_axes, show
from scipy.optimize import curve_fit

from fenics_yeast import Scene, simulate

YOUNG, POISSON, R = 1000.0, 0.3, 1.0
SHAPES = {
    "cylinder": f'{{ shape = "cylinder", diameter = {2 * R}, length = {2 * R} }}',
    "sphere": f'{{ shape = "cap", radius = {R}, half_angle = 90 }}',
}
TOLERANCE = {"cylinder": 1e-3, "sphere": 0.02}


def decay(x: np.ndarray, length: float, far: float) -> np.ndarray:
    return far * (1 - np.exp(-x / length) * (np.cos(x / length) + np.sin(x / length)))


def published(h: float) -> float:
    return np.sqrt(R * h) / (3 * (1 - POISSON**2)) ** 0.25


def edge(shape: str, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return distance from the edge and displacement away from the axis."""
    pressure = 1e-6 * YOUNG * h / R  # small: linear
    scene = Scene.from_toml(f"""
    cell = {SHAPES[shape]}
    wall = {{ law = "linear", thickness = {h}, young_modulus = {YOUNG}, poisson_ratio = {POISSON} }}
    turgor = {{ pressure = {pressure} }}
    numerics = {{ elements = 60, order = 4, thickness_points = 2 }}
    """)
    wall = simulate(scene).profiles.all[-1]
    near = wall.S < 5 * published(h)
    radius = R if shape == "cylinder" else R * np.cos(wall.S / R)
    return wall.S[near], (wall.r - radius)[near]


def rows() -> list[Row]:
    found = []
    for shape, tolerance in TOLERANCE.items():
        for h in (0.01, 0.001):
            x, u = edge(shape, h)
            start = published(h), u[-1]
            length = curve_fit(decay, x / start[0], u / start[1], p0=(1, 1))[0][0] * start[0]
            what = f"decay length of a {shape}, h/R = {h:g}"
            # The next term of the sphere is of the order √(h/R).
            share = tolerance if shape == "cylinder" else tolerance * np.sqrt(h / 0.001)
            found.append(Row.near(what, length, published(h), share))
    return found


def main() -> None:
    show(rows())
    with figure_axes("edge_bending") as axes:
        for shape, colour in (("cylinder", "#0072b2"), ("sphere", "#d55e00")):
            x, u = edge(shape, 0.001)
            axes.plot(x / published(0.001), u / u[-1], "o", ms=3, color=colour, label=shape)
        x = np.linspace(0, 5, 200)
        axes.plot(x, decay(x, 1, 1) / decay(5.0, 1, 1), color="0.6", label="theory")
        axes.set(xlabel="distance from the edge / l", ylabel="displacement / far-field value")


if __name__ == "__main__":
    main()
