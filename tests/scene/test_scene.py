"""Scenes: units, defaults and presets, TOML in and out, changes of values."""

import dataclasses
import pickle
from decimal import Decimal

import numpy as np
import pytest
from pydantic import ValidationError
from support.scenes import BALLOON, BUD

from fenics_yeast.scene import (
    PRESETS,
    Cell,
    Growth,
    Numerics,
    Run,
    Scene,
    SceneError,
    Turgor,
    Wall,
    Zone,
    units,
)


@pytest.fixture
def bud() -> Scene:
    return Scene.from_toml(BUD, source="bud.toml")


def test_every_key_of_the_documented_scene_is_read(bud):
    assert bud == Scene(
        title="S. cerevisiae bud",
        cell=Cell(shape="sphere", diameter=5.0),
        wall=Wall(thickness=0.1, shear_modulus=40.0, ogden_exponent=2.0),
        turgor=Turgor(pressure=0.20265, ramp=0.01),
        growth=Growth(zone=Zone(pole="top", half_angle=24.0), threshold=1.0, time=45.0),
        run=Run(end=90.0, save=(40.0, 70.0, 90.0)),
        numerics=Numerics(
            preset="default",
            elements=480,
            order=1,
            grading="uniform",
            geometry="conical",
            thickness_points=3,
            shear_penalty=1000.0,
            integrator="backward-euler",
            step=0.2,
            tolerance=1e-4,
        ),
    )
    assert bud.cell.radius == 2.5


def test_a_scene_needs_only_cell_wall_and_turgor():
    scene = Scene.from_toml(BALLOON)
    assert scene.growth is None
    assert scene.run is None
    assert scene.wall.ogden_exponent == 2.0
    assert scene.turgor.ramp == 0.01
    of_scene = {"elements", "thickness_points", "thickness_rule"}
    assert scene.numerics.model_dump(exclude=of_scene) == Numerics().model_dump(exclude=of_scene)
    assert scene.name == "scene"


@pytest.mark.parametrize(
    ("key", "text", "expected"),
    [
        ("cell.diameter", "5 um", 5.0),
        ("cell.diameter", "5 µm", 5.0),  # micro sign
        ("cell.diameter", "5 μm", 5.0),  # Greek mu
        ("cell.diameter", "5e-6m", 5.0),
        ("cell.diameter", 5, 5.0),
        ("wall.thickness", "100 nm", 0.1),
        ("wall.thickness", "0.0001 mm", 0.1),
        ("turgor.pressure", "2 atm", 0.202650),
        ("turgor.pressure", "-3 bar", -0.3),
        ("turgor.pressure", "250 kPa", 0.25),
        ("turgor.pressure", 0, 0.0),
        ("wall.shear_modulus", "40 N/mm^2", 40.0),
        ("wall.shear_modulus", "0.04 GPa", 40.0),
        ("growth.time", "45 min", 45.0),
        ("growth.time", "0.5 h", 30.0),
        ("growth.time", "30 s", 0.5),
        ("growth.zone.half_angle", "24 deg", 24.0),
        ("growth.zone.half_angle", "24°", 24.0),
    ],
)
def test_units_are_converted_to_the_last_digit(bud, key, text, expected):
    value = bud.with_values({key: text})
    for part in key.split("."):
        value = getattr(value, part)
    assert isinstance(value, float)
    assert value == expected


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("wall.thickness", 2.4999),
        ("wall.ogden_exponent", -4),
        ("turgor.pressure", -1),
        ("turgor.ramp", 0),
        ("growth.zone.half_angle", 180),
        ("numerics.elements", 2),
        ("numerics.elements", 100_000),
        ("numerics.order", 4),
        ("numerics.thickness_points", 1),
        ("numerics.thickness_points", 24),
        ("numerics.tolerance", 0.1),
    ],
)
def test_the_ends_of_every_range_are_allowed(bud, key, value):
    table, *keys = key.split(".")
    found = getattr(bud.with_values({key: value}), table)
    for part in keys:
        found = getattr(found, part)
    assert found == value


def test_radians_become_degrees(bud):
    zone = bud.with_values({"growth.zone.half_angle": "0.4 rad"}).growth.zone
    assert zone.half_angle == pytest.approx(22.918311805232928, abs=1e-13)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_complete_and_valid(name):
    preset = dataclasses.asdict(PRESETS[name])
    assert {"preset", *preset} == set(Numerics.model_fields)
    given = {key: value for key, value in preset.items() if value is not None or key == "step"}
    assert Numerics(preset=name) == Numerics(preset=name, **given)


def test_a_smaller_tolerance_and_more_zones_need_more_elements():
    bud = Scene.from_toml(BUD).with_values({"numerics": {}})
    scenes = [bud.with_values({"numerics.tolerance": t}) for t in (1e-3, 1e-4, 1e-6)]
    elements = [scene.numerics.elements for scene in scenes]
    assert elements == sorted(set(elements))
    assert scenes[1].with_values({"growth.zone.pole": "both"}).numerics.elements > elements[1]
    assert scenes[1].with_values({"growth": None}).numerics.elements < elements[1]
    assert scenes[1].with_values({"numerics.elements": 20}).numerics.elements == 20
    assert Scene.from_toml(scenes[2].to_toml()) == scenes[2]


def test_the_paper_preset_has_the_numerics_of_the_paper():
    paper = Scene.from_toml(BALLOON + '[numerics]\npreset = "paper"').numerics
    assert (paper.elements, paper.order, paper.thickness_points) == (480, 1, 3)
    assert (paper.grading, paper.geometry) == ("uniform", "conical")
    assert (paper.integrator, paper.step) == ("backward-euler", 0.2)


def test_a_key_overrides_only_its_own_value_of_the_preset():
    paper = Scene.from_toml(BALLOON + '[numerics]\npreset = "paper"\nstep = "adaptive"').numerics
    assert paper == Numerics(
        **{"preset": "paper", **dataclasses.asdict(PRESETS["paper"]), "step": None}
    )


def test_saved_times_are_sorted_and_unique_and_default_to_the_end(bud):
    saved = bud.with_values({"run.save": [90, "1 h", 40, 60.0, 0]}).run.save
    assert saved == (0.0, 40.0, 60.0, 90.0)
    assert Run(end=30).save == (30.0,)


@pytest.mark.parametrize("text", [BUD, BALLOON, BALLOON + '[numerics]\npreset = "paper"'])
def test_written_scenes_read_back_equal(text):
    scene = Scene.from_toml(text)
    written = scene.to_toml()
    assert Scene.from_toml(written) == scene
    assert Scene.from_toml(written).to_toml() == written


def test_written_scenes_contain_every_default():
    written = Scene.from_toml(BALLOON + '[run]\nend = 9\n[numerics]\nstep = "adaptive"').to_toml()
    for key in ("title", "ogden_exponent", "ramp", "save", *Numerics.model_fields):
        assert f"\n{key} = " in written


def test_an_infinite_shear_penalty_is_read_and_written():
    scene = Scene.from_toml(BALLOON + "[numerics]\nshear_penalty = inf")
    assert scene.numerics.shear_penalty == float("inf")
    assert Scene.from_toml(scene.to_toml()) == scene


def test_values_can_be_changed(bud):
    changed = bud.with_values({"growth.time": 30, "wall.shear_modulus": "20 MPa"})
    assert (changed.growth.time, changed.wall.shear_modulus) == (30.0, 20.0)
    assert (bud.growth.time, bud.wall.shear_modulus) == (45.0, 40.0)
    assert changed != bud
    assert changed.with_values({"growth.time": 45, "wall.shear_modulus": 40}) == bud


def test_defaults_follow_a_change():
    scene = Scene.from_toml(BALLOON + "[run]\nend = 90\n[numerics]\norder = 2\n")
    paper = scene.with_values({"numerics.preset": "paper", "run.end": 30})
    assert paper.numerics == Numerics(preset="paper", order=2)
    assert paper.run.save == (30.0,)
    back = paper.with_values({"numerics.preset": "default", "run.end": 90})
    assert back == scene


def test_whole_tables_can_be_changed_and_removed(bud):
    zone = {"pole": "bottom", "half_angle": 10}
    changed = bud.with_values({"growth.zone": zone, "growth.zone.half_angle": 30})
    assert changed.growth.zone == Zone(pole="bottom", half_angle=30)
    assert zone == {"pole": "bottom", "half_angle": 10}
    assert bud.with_values({"growth.zone": Zone(pole="top", half_angle=90)}).growth.time == 45
    elastic = bud.with_values({"growth": None, "numerics.step": None})
    assert elastic.growth is None
    assert elastic.numerics.step is None
    assert elastic.with_values({"growth": bud.growth, "numerics.step": 0.2}) == bud


def test_a_scene_is_named_after_its_file_or_else_its_title(tmp_path, bud):
    path = tmp_path / "my-bud.toml"
    path.write_text(BUD, encoding="utf-8")
    scene = Scene.load(path)
    assert scene.name == "my-bud"
    assert scene.with_values({"growth.time": 30}).name == "my-bud"
    assert bud.name == "s-cerevisiae-bud"
    assert scene == bud
    assert hash(scene) == hash(bud)
    assert "my-bud" not in scene.to_toml()


def test_pickled_scenes_keep_their_name_and_preset(tmp_path):
    path = tmp_path / "bud.toml"
    path.write_text(BALLOON)
    scene = pickle.loads(pickle.dumps(Scene.load(path)))
    assert scene.name == "bud"
    assert scene.with_values({"numerics.preset": "paper"}).numerics.elements == 480


def test_files_with_a_byte_order_mark_and_crlf_are_read(tmp_path, bud):
    path = tmp_path / "bud.toml"
    path.write_bytes(b"\xef\xbb\xbf" + BUD.replace("\n", "\r\n").encode())
    assert Scene.load(path) == bud


def test_scenes_are_frozen(bud):
    with pytest.raises(ValidationError, match="frozen"):
        bud.wall.thickness = 1.0


def test_usual_units_have_the_digits_of_pint() -> None:
    """They are converted without it."""
    random = np.random.default_rng(3)
    numbers = [*map(repr, random.lognormal(0, 5, 50).tolist()), "100", "0.01", "2.5e-3", "1e5"]
    for unit in (units.LENGTH, units.PRESSURE, units.TIME, units.FORCE, units.ANGLE):
        for name in units._USUAL[unit.symbol]:
            by_pint = units._registry().parse_units(name)
            for number in numbers:
                quantity = units._registry().Quantity(Decimal(number), by_pint)
                assert unit.read(f"{number} {name}") == float(quantity.to(unit.symbol).magnitude)


def test_no_saved_times_means_the_end() -> None:
    assert Scene.from_toml(BUD.replace("save = [40, 70, 90]", "save = []")).run.save == (90.0,)


@pytest.mark.parametrize("file", ["/dev/zero"])
def test_a_file_without_end_is_refused(file: str) -> None:
    with pytest.raises(SceneError, match="larger than 10 MB"):
        Scene.load(file)


def test_a_capsule_has_a_bounded_slenderness() -> None:
    capsule = 'shape = "capsule"\ndiameter = 5\nlength = 1e12'
    with pytest.raises(SceneError, match="expected a length <= 1000 diameters"):
        Scene.from_toml(BUD.replace('shape = "sphere"\ndiameter = "5 um"', capsule))
