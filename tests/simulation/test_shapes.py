"""Walls of every shape: unloaded volumes and stresses under turgor."""

import numpy as np
import pytest
from support.shapes import SHAPES

from fenics_yeast import Scene, simulate
from fenics_yeast import _dolfinx as dx
from fenics_yeast.scene import Cell
from fenics_yeast.simulation import build_shell, discretise

CELLS = {shape: Cell(**keys) for shape, keys in SHAPES.items()}


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        ("spheroid", 4 / 3 * np.pi * 2**2 * 3.5),
        ("profile", 4 / 3 * np.pi * 2**2 * 3.5),
        ("capsule", 4 / 3 * np.pi * 2**3 + np.pi * 2**2 * 7),
        ("cap", np.pi * 1000 / 3 * (2 + np.cos(np.pi / 9)) * (1 - np.cos(np.pi / 9)) ** 2),
        ("disc", 0.0),
        ("cone", np.pi / 3 * (4**2 + 4 * 1.5 + 1.5**2)),
        ("cylinder", np.pi * 2**2 * 9),
    ],
)
def test_unloaded_walls_are_in_equilibrium_and_enclose_their_volume(elastic_scene, shape, volume):
    scene = elastic_scene.with_values({"cell": CELLS[shape], "numerics.elements": 24})
    shell = build_shell(scene)
    assert shell.volume() == pytest.approx(volume, rel=1e-6, abs=1e-12)
    np.testing.assert_allclose(dx.fem.assemble_vector(shell.forms.residual).array, 0, atol=1e-13)


def test_joints_of_a_capsule_are_nodes(elastic_scene):
    for grading in ("uniform", "graded"):
        values = {"cell": CELLS["capsule"], "numerics.grading": grading, "numerics.elements": 17}
        cut = discretise(elastic_scene.with_values(values))
        assert len(cut.nodes) == 18
        for joint in cut.curve.joints:
            assert abs(cut.nodes - joint).min() < 1e-12


def membrane_stress(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    result = simulate(scene)
    assert result.status == "finished"
    wall = result.profiles.all[-1]
    mean = np.polynomial.legendre.leggauss(len(wall.xi))[1] / 2
    return wall.S_points, *(np.tensordot(wall.stress, mean, axes=([1], [0])).T)


def test_a_capsule_carries_twice_the_stress_around_its_side(elastic_scene):
    """σ1 = p R/2h everywhere, σ2 = p R/h on the side, p R/2h on the caps, away from the joints."""
    values = {"cell": CELLS["capsule"], "wall.thickness": 0.02, "wall.shear_modulus": 4e4,
              "numerics.elements": 60, "numerics.grading": "graded"}  # fmt: skip
    S, s1, s2 = membrane_stress(elastic_scene.with_values(values))
    p, R, h = 0.20265, 2.0, 0.02
    away = abs(S - np.pi * R / 2) > 1.2
    away &= abs(S - np.pi * R / 2 - 7) > 1.2
    side = (S > np.pi * R / 2) & (S < np.pi * R / 2 + 7)
    np.testing.assert_allclose(s1[away], p * R / (2 * h), rtol=2e-3)
    np.testing.assert_allclose(s2[away & side], p * R / h, rtol=2e-3)
    np.testing.assert_allclose(s2[away & ~side], p * R / (2 * h), rtol=2e-3)


@pytest.mark.parametrize("shape", ["spheroid", "profile"])
def test_membrane_stresses_of_a_spheroid_are_those_of_the_closed_form(elastic_scene, shape):
    """σ1 = p R2/2h, σ2 = σ1 (2 - R2/R1), R1 and R2 the radii of curvature."""
    values = {"cell": CELLS[shape], "wall.thickness": 0.02, "wall.shear_modulus": 4e4,
              "numerics.elements": 40}  # fmt: skip
    S, s1, s2 = membrane_stress(elastic_scene.with_values(values))
    curve = CELLS["spheroid"].curve
    R2 = curve.radius(S) / np.sin(curve.angle(S))
    expected = 0.20265 * R2 / (2 * 0.02)
    np.testing.assert_allclose(s1, expected, rtol=3e-3)
    np.testing.assert_allclose(s2, expected * (2 - R2 * curve.curvature(S)), rtol=3e-3)
