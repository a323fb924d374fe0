"""The table `[cell]`: shapes, their sizes, and contours read from a file beside the scene."""

import numpy as np
import pytest
from support.scenes import BALLOON
from support.shapes import SHAPES, ellipse

from fenics_yeast.scene import Cell, Scene, SceneError


@pytest.fixture
def contour(tmp_path):
    """Write a contour beside a scene of a wall around it; return the scene's file."""

    def write(r, z, tolerance: float = 1e-4):
        rows = "\n".join(f"{x!r},{y!r}" for x, y in zip(map(float, r), map(float, z), strict=True))
        (tmp_path / "contour.csv").write_text(f"r,z\n{rows}\n")
        cell = f'shape = "profile"\nfile = "contour.csv"\ntolerance = {tolerance}'
        scene = tmp_path / "traced.toml"
        text = BALLOON.replace('shape = "sphere"\ndiameter = 5', cell)
        scene.write_text(text.replace("thickness = 0.1", "thickness = 0.05"))
        return scene

    return write


def test_the_points_of_a_contour_are_smoothed_to_its_tolerance(contour):
    r, z = ellipse(80)
    loose, tight = (Scene.load(contour(r, z, t)).cell.curve for t in (0.02, 0.0))
    exact = Cell(**SHAPES["spheroid"]).curve.length
    assert tight.length == pytest.approx(exact, rel=1e-7)
    assert loose.length != tight.length
    assert loose.length == pytest.approx(exact, rel=5e-3)


def test_a_scene_with_a_contour_needs_no_other_file(contour, tmp_path):
    path = contour(*ellipse(40))
    scene = Scene.load(path)
    (tmp_path / "contour.csv").unlink()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "scene.toml").write_text(scene.to_toml())
    again = Scene.load(elsewhere / "scene.toml")
    assert again == scene and hash(again) == hash(scene)
    assert again.with_values({"wall.thickness": 0.06}).cell == scene.cell


def test_a_file_that_is_no_contour_is_reported_on_one_line(contour, tmp_path):
    path = contour(*(p[5:] for p in ellipse(60)))
    start = f'{path}: cell.file = "contour.csv": '
    with pytest.raises(SceneError) as caught:
        Scene.load(path)
    assert str(caught.value).startswith(f"{start}the contour is open: its first point is 0.5")
    (tmp_path / "contour.csv").unlink()
    with pytest.raises(SceneError) as caught:
        Scene.load(path)
    assert str(caught.value) == f"{start}no such file beside the scene: {tmp_path / 'contour.csv'}"


def test_points_that_are_no_contour_are_reported_on_one_line():
    profile = SHAPES["profile"]
    with pytest.raises(SceneError, match=r"^Cell: r = \[.*\]: the contour runs from top"):
        Cell(**profile | {"r": profile["r"][::-1], "z": profile["z"][::-1]})
    with pytest.raises(SceneError, match=r"^Cell: z = \[1.0\]: expected 60 heights, one"):
        Cell(**profile | {"z": [1.0]})


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"shape": "cube"}, 'shape = "cube": expected one of "sphere", "spheroid", "capsule", "pr'),
        ({"diameter": 5.0}, 'shape is missing: expected one of "sphere"'),
        ({"shape": "spheroid", "diameter": 5.0}, "height is missing: expected a length > 0"),
        ({"shape": "capsule", "diameter": 5.0, "length": 4.0}, "> the diameter (5 µm)"),
        ({"shape": "disc", "diameter": 5.0, "edge": "glued"}, 'edge = "glued": expected one of "c'),
        ({"shape": "disc", "radius": 5.0},
         'radius = 5.0: not a key of shape = "disc"; remove it (keys: shape, diameter, edge)'),
        ({"shape": "cap", "radius": 5.0, "half_angel": 4.0}, "did you mean cell.half_angle?"),
        (SHAPES["capsule"] | {"height": 1.0},
         'height = 1.0: not a key of shape = "capsule"; remove it (keys: shape, diameter, length)'),
        ({"shape": "profile"}, "file is missing"),
        (SHAPES["cone"] | {"inner_diameter": 9.0}, "< the outer diameter (8 µm)"),
    ],
)  # fmt: skip
def test_malformed_shapes_are_reported_on_one_line(values, said):
    with pytest.raises(SceneError) as caught:
        Cell(**values)
    message = str(caught.value)
    assert message.startswith("Cell: ") and said in message and len(message.splitlines()) == 1


def test_a_wall_is_thinner_than_the_least_radius_of_its_cell():
    cell = Cell(shape="spheroid", diameter=2.0, height=10.0)
    values = {"cell": cell, "wall.thickness": 0.25}
    with pytest.raises(SceneError, match=r"least radius \(0.2 µm\)"):
        Scene.from_toml(BALLOON).with_values(values)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_has_a_meridian_of_its_size(shape):
    cell = Cell(**SHAPES[shape])
    S = np.linspace(0, cell.curve.length, 501)
    assert cell.curve.radius(S).max() == pytest.approx(
        cell.radius * (np.sin(np.pi / 9) if shape == "cap" else 1), rel=1e-3
    )
    assert cell.least_radius <= cell.radius
    assert cell.closed == (shape in ("sphere", "spheroid", "capsule", "profile"))
