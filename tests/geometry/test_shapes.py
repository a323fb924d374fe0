"""Reference meridians of all shapes, contours, and what a wall of each shape does under turgor."""

import numpy as np
import pytest
from scipy.special import ellipe

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast.geometry.intervals import polar_extent
from fenics_yeast.scene import Cell
from fenics_yeast.simulation.discretise import discretise

SHAPES = {
    "sphere": {"diameter": 5.0},
    "spheroid": {"diameter": 4.0, "height": 7.0},
    "capsule": {"diameter": 4.0, "length": 11.0},
    "cap": {"radius": 10.0, "half_angle": 20.0},
    "disc": {"diameter": 4.0},
    "cone": {"outer_diameter": 8.0, "inner_diameter": 3.0, "height": 1.0},
    "cylinder": {"diameter": 4.0, "length": 9.0},
}
CLOSED = ("sphere", "spheroid", "capsule", "profile")


def ellipse(n: int, a: float = 2.0, c: float = 3.5) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(0, np.pi, n)
    return a * np.sin(t), -c * np.cos(t)


@pytest.fixture
def contour(tmp_path):
    """Write a contour beside a scene of a wall around it; gives the scene's file."""

    def write(r, z, tolerance: float = 1e-4):
        rows = "\n".join(f"{x!r},{y!r}" for x, y in zip(map(float, r), map(float, z), strict=True))
        (tmp_path / "contour.csv").write_text(f"# traced by hand\nr,z\n{rows}\n")
        scene = tmp_path / "traced.toml"
        scene.write_text(
            f"""
            [cell]
            shape = "profile"
            file = "contour.csv"
            tolerance = {tolerance}
            [wall]
            thickness = 0.05
            shear_modulus = 40
            [turgor]
            pressure = 0.2
            """
        )
        return scene

    return write


def make(shape: str):
    if shape == "profile":
        r, z = ellipse(60)
        return Cell(shape=shape, r=r.tolist(), z=z.tolist(), tolerance=1e-5)
    return Cell(shape=shape, **SHAPES[shape])


@pytest.mark.parametrize("shape", [*SHAPES, "profile"])
def test_angle_and_curvature_are_derivatives_by_arc_length(shape):
    """R' = cos Φ, Z' = sin Φ and Φ' by differences, away from the joints."""
    curve = make(shape).curve
    S, step = np.linspace(0.01, 0.99, 57) * curve.length, 1e-5
    S = S[[all(abs(s - joint) > 2 * step for joint in curve.joints) for s in S]]

    def slope(function):
        return (function(S + step) - function(S - step)) / (2 * step)

    np.testing.assert_allclose(slope(curve.radius), np.cos(curve.angle(S)), atol=2e-9)
    np.testing.assert_allclose(slope(curve.height), np.sin(curve.angle(S)), atol=2e-9)
    np.testing.assert_allclose(slope(curve.angle), curve.curvature(S), atol=1e-7)
    for joint in curve.joints:  # the curvature jumps, the angle does not
        sides = np.array([joint - 1e-9, joint + 1e-9])
        assert abs(np.diff(curve.curvature(sides))[0]) > 0.1
        assert abs(np.diff(curve.angle(sides))[0]) < 1e-8


@pytest.mark.parametrize("shape", CLOSED)
def test_closed_meridians_are_smooth_at_their_poles(shape):
    curve = make(shape).curve
    ends = np.array([0.0, curve.length])
    np.testing.assert_allclose(curve.radius(ends), 0, atol=1e-12)
    np.testing.assert_allclose(curve.angle(ends), [0, np.pi], atol=1e-9)
    near = np.array([1e-4, curve.length - 1e-4])  # odd in S: R = S + O(S³)
    np.testing.assert_allclose(curve.radius(near), 1e-4, rtol=1e-7)


def test_length_of_an_ellipse_is_the_elliptic_integral():
    curve = make("spheroid").curve
    assert curve.length == pytest.approx(2 * 3.5 * ellipe(1 - (2 / 3.5) ** 2), rel=1e-13)


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
def test_unloaded_walls_rest_and_enclose_their_volume(elastic_scene, shape, volume):
    from fenics_yeast import _dolfinx as dx
    from fenics_yeast.simulation import build_shell

    scene = elastic_scene.with_values({"cell": make(shape), "numerics.elements": 24})
    shell = build_shell(scene)
    assert shell.volume() == pytest.approx(volume, rel=1e-6, abs=1e-12)
    np.testing.assert_allclose(dx.fem.assemble_vector(shell.forms.residual).array, 0, atol=1e-13)


def test_joints_are_nodes(elastic_scene):
    for grading in ("uniform", "graded"):
        values = {"cell": make("capsule"), "numerics.grading": grading, "numerics.elements": 17}
        cut = discretise(elastic_scene.with_values(values))
        assert len(cut.nodes) == 18
        for joint in cut.curve.joints:
            assert abs(cut.nodes - joint).min() < 1e-12


@pytest.mark.parametrize("shape", CLOSED)
def test_a_polar_cap_is_seen_from_the_middle_of_the_axis(shape):
    curve = make(shape).curve
    middle = curve.height(np.array([0.0, curve.length])).mean()
    for angle in (0.3, 1.0, 2.0, np.pi):
        for pole, sign in (("bottom", -1), ("top", 1)):
            S = np.array([polar_extent(curve, pole, angle)])
            height = sign * (curve.height(S) - middle)
            assert np.arctan2(curve.radius(S), height)[0] == pytest.approx(angle, abs=1e-6)


# --- contours ---------------------------------------------------------------------------------


def test_a_noisy_contour_is_smoothed_to_the_stated_tolerance(contour):
    r, z = ellipse(200)
    noise = np.random.default_rng(3).normal(scale=0.02, size=(2, 200))
    noise[0, [0, -1]] = 0
    scene = Scene.load(contour(r + noise[0], z + noise[1], tolerance=0.03))
    curve = scene.cell.curve
    S = np.linspace(0, curve.length, 400)
    away = (curve.radius(S) / 2) ** 2 + (curve.height(S) / 3.5) ** 2 - 1
    assert abs(away).max() < 0.03
    assert curve.curvature(S).min() > 0.05  # an ellipse's least curvature is 0.16
    exact = make("spheroid").curve
    assert curve.length == pytest.approx(exact.length, rel=5e-3)


def test_a_contour_without_noise_is_the_curve_itself(contour):
    curve = Scene.load(contour(*ellipse(80), tolerance=0)).cell.curve
    exact = make("spheroid").curve
    S = np.linspace(0, 1, 50)
    assert curve.length == pytest.approx(exact.length, rel=1e-7)
    found, wanted = (c.curvature(S * c.length) for c in (curve, exact))
    np.testing.assert_allclose(found, wanted, rtol=2e-4)


def test_a_scene_with_a_contour_stands_alone(contour, tmp_path):
    path = contour(*ellipse(40))
    scene = Scene.load(path)
    (tmp_path / "contour.csv").unlink()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "scene.toml").write_text(scene.to_toml())
    again = Scene.load(elsewhere / "scene.toml")
    assert again == scene and hash(again) == hash(scene)
    assert again.with_values({"wall.thickness": 0.06}).cell == scene.cell


SQUARE = ([0, 1, 2, 2, 2, 2, 2, 1, 0], [0, 0, 0, 1, 2, 3, 4, 4, 4])


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([p[5:] for p in ellipse(60)], "is open: its first point lies 0.5"),
        ([p[:-3] for p in ellipse(60)], "is open: its last point"),
        ([p[::-1] for p in ellipse(60)], "is unordered: it runs from top to bottom"),
        ([np.r_[p[:20], p[40:20:-1], p[40:]] for p in ellipse(60)], "crosses itself near r = "),
        ([p[np.r_[0, np.random.default_rng(1).permutation(58) + 1, 59]] for p in ellipse(60)],
         "crosses itself"),
        ([np.r_[p[:30], [-0.3, 0.1][i], p[30:]] for i, p in enumerate(ellipse(60))],
         "meets the axis near r = -0.3"),
        ([np.interp(np.linspace(0, 8, 81), range(9), x) for x in SQUARE], "is kinked near r = 2"),
        ([p[::20] for p in ellipse(60)], "has 3 points; from 8"),
    ],
)  # fmt: skip
def test_contours_that_are_none_are_told_in_one_line(contour, points, said):
    path = contour(*points, tolerance=1e-3)
    with pytest.raises(SceneError) as caught:
        Scene.load(path)
    message = str(caught.value)
    assert message.startswith(f'{path}: cell.file = "contour.csv": the contour ')
    assert said in message and len(message.splitlines()) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "no such file beside the scene"),
        ("", 'heading "r,z"'),
        ("r,z\n", "no points"),
        ("x,y\n1,2\n", 'heading "r,z"'),
        ("r,z\n0,1\n0;2\n", "line 3 has no two numbers"),
        ("r,z\n0,nan\n", "line 2 is not finite"),
    ],
)
def test_files_that_are_no_contours_are_told_in_one_line(contour, tmp_path, text, said):
    path = contour(*ellipse(20))
    if text is None:
        (tmp_path / "contour.csv").unlink()
    else:
        (tmp_path / "contour.csv").write_text(text)
    with pytest.raises(SceneError, match=r'cell.file = "contour.csv": ') as caught:
        Scene.load(path)
    assert said in str(caught.value) and len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"shape": "cube"}, 'shape = "cube": allowed: "sphere", "spheroid", "capsule", "profile"'),
        ({"diameter": 5.0}, 'shape is missing: allowed: "sphere"'),
        ({"shape": "spheroid", "diameter": 5.0}, "height is missing: a length greater than 0"),
        ({"shape": "capsule", "diameter": 5.0, "length": 4.0}, "greater than the diameter (5 µm)"),
        ({"shape": "disc", "diameter": 5.0, "edge": "glued"}, 'edge = "glued": allowed: "clamped"'),
        ({"shape": "disc", "radius": 5.0}, "diameter is missing"),
        ({"shape": "cap", "radius": 5.0, "half_angel": 4.0}, "half_angle is missing"),
        ({"shape": "capsule", "diameter": 5.0, "length": 9.0, "height": 1.0},
         "height = 1.0: unknown key; known here: shape, diameter, length"),
        ({"shape": "profile"}, "file is missing"),
        ({**SHAPES["cone"], "shape": "cone", "inner_diameter": 9.0}, "less than the outer"),
    ],
)  # fmt: skip
def test_shapes_that_are_none_are_told_in_one_line(values, said):
    with pytest.raises(SceneError) as caught:
        Cell(**values)
    message = str(caught.value)
    assert message.startswith("Cell: ") and said in message and len(message.splitlines()) == 1


def test_thickness_is_held_against_the_least_radius(elastic_scene):
    with pytest.raises(SceneError, match=r"least radius \(0.2 µm\)"):
        cell = Cell(shape="spheroid", diameter=2.0, height=10.0)
        elastic_scene.with_values({"cell": cell, "wall.thickness": 0.25})


# --- walls under turgor -----------------------------------------------------------------------


def membrane_stress(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    result = simulate(scene)
    assert result.status == "finished"
    wall = result.profiles.all[-1]
    mean = np.polynomial.legendre.leggauss(len(wall.xi))[1] / 2
    return wall.S_points, *(np.tensordot(wall.stress, mean, axes=([1], [0])).T)


def test_a_capsule_carries_twice_the_stress_around_its_side(elastic_scene):
    """σ1 = p R/2h everywhere, σ2 = p R/h on the side, p R/2h on the caps, away from the joints."""
    values = {"cell": make("capsule"), "wall.thickness": 0.02, "wall.shear_modulus": 4e4,
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
def test_membrane_stresses_of_a_spheroid(elastic_scene, shape):
    """σ1 = p R2/2h, σ2 = σ1 (2 - R2/R1), R1 and R2 the radii of curvature."""
    values = {"cell": make(shape), "wall.thickness": 0.02, "wall.shear_modulus": 4e4,
              "numerics.elements": 40}  # fmt: skip
    S, s1, s2 = membrane_stress(elastic_scene.with_values(values))
    curve = make("spheroid").curve
    R2 = curve.radius(S) / np.sin(curve.angle(S))
    expected = 0.20265 * R2 / (2 * 0.02)
    np.testing.assert_allclose(s1, expected, rtol=3e-3)
    np.testing.assert_allclose(s2, expected * (2 - R2 * curve.curvature(S)), rtol=3e-3)
