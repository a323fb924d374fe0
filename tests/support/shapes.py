"""A cell of every shape, by the keys of its table `[cell]`."""

from typing import Any

import numpy as np

from fenics_yeast.geometry import Curve, Parametric

SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {"diameter": 5.0},
    "spheroid": {"diameter": 4.0, "height": 7.0},
    "capsule": {"diameter": 4.0, "length": 11.0},
    "cap": {"radius": 10.0, "half_angle": 20.0},
    "disc": {"diameter": 4.0},
    "cone": {"outer_diameter": 8.0, "inner_diameter": 3.0, "height": 1.0},
    "cylinder": {"diameter": 4.0, "length": 9.0},
}


def ellipse(n: int, a: float = 2.0, c: float = 3.5) -> tuple[np.ndarray, np.ndarray]:
    """Return `(r, z)` of points on the meridian of the spheroid above."""
    t = np.linspace(0, np.pi, n)
    return a * np.sin(t), -c * np.cos(t)


SHAPES["profile"] = {
    **dict(zip("rz", (x.tolist() for x in ellipse(60)), strict=True)),
    "tolerance": 1e-5,
}
SHAPES = {shape: {"shape": shape, **keys} for shape, keys in SHAPES.items()}


def parametric(curve: Curve) -> Parametric:
    """Return any meridian with its arc length as the parameter."""

    def point(S: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
        if order == 0:
            return curve.radius(S), curve.height(S)
        angle, bend = curve.angle(S), curve.curvature(S)
        if order == 1:
            return np.cos(angle), np.sin(angle)
        return -bend * np.sin(angle), bend * np.cos(angle)

    return Parametric(point, curve.length)
