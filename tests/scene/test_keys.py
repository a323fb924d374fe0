"""The walker over dotted keys: get, set, list, flatten, units; assignments of the command line."""

import pytest

from fenics_yeast.scene import (
    Scene,
    SceneError,
    flatten,
    keys_of,
    parse_assignment,
    parse_value,
    unit_symbol,
    value_of,
)
from fenics_yeast.scene.keys import set_value

SCENE = Scene.from_toml("""
[cell]
shape = "sphere"
diameter = "5 um"
[wall]
thickness = "100 nm"
shear_modulus = 40
[load]
point_force = "1 uN"
[turgor]
pressure = { time = [0, 30], value = [0.1, 0.2] }
[[growth]]
zone = { from = "1 um", to = "2 um" }
threshold = 1
time = 45
[run]
end = 30
""")


@pytest.mark.parametrize(
    ("key", "value", "unit"),
    [
        ("title", "", ""),
        ("cell.diameter", 5.0, "µm"),
        ("load.point_force", 1.0, "µN"),  # the attribute is `axial_load`
        ("turgor.pressure.value", (0.1, 0.2), "MPa"),
        ("growth.0.zone.from", 1.0, "µm"),
        ("growth.0.until", None, "min"),
        ("run.save", (30.0,), "min"),
        ("numerics.step", None, "min"),
        ("numerics.order", 4, ""),
    ],
)
def test_a_key_names_a_value_and_its_unit(key, value, unit):
    assert value_of(SCENE, key) == value
    assert unit_symbol(SCENE, key) == unit


@pytest.mark.parametrize("key", ["", "axial_load", "growth.time", "growth.1", "cell.diameter.x"])
def test_a_key_of_nothing_is_a_key_error(key):
    with pytest.raises(KeyError):
        value_of(SCENE, key)


def test_values_are_set_in_tables_that_are_made_where_they_are_missing():
    tables: dict = {"growth": ({"time": 45},)}
    set_value(tables, "growth.0.time", 30)
    set_value(tables, "run.end", 90)
    assert tables == {"growth": [{"time": 30}], "run": {"end": 90}}


def test_every_key_that_takes_a_value_is_listed_with_its_field():
    fields = dict(keys_of(Scene))
    assert {"turgor.pressure", "turgor.pressure.time", "load.at", "wall.zone.to"} <= set(fields)
    assert not {"growth", "growth.zone", "wall.zone", "axial_load"} & set(fields)


def test_every_field_has_a_description():
    assert not [key for key, field in keys_of(Scene) if not field.description]
    assert all(field.description for field in Scene.model_fields.values())


def test_flat_values_have_the_keys_of_the_scene_file():
    values = flatten(SCENE)
    assert values["load.point_force"] == 1.0
    assert values["turgor.pressure.value"] == (0.1, 0.2)
    assert values["septum"] is None


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("growth.time=30 min", "growth.time", "30 min"),
        ("growth.time=30", "growth.time", 30),
        (" growth.time = '30 min' ", "growth.time", "30 min"),
        ("growth.zone.half_angle=1e1", "growth.zone.half_angle", 10.0),
        ("run.save=[1, 2]", "run.save", [1, 2]),
        ("numerics.integrator=sdirk2", "numerics.integrator", "sdirk2"),
        ("title=a=b", "title", "a=b"),
        ("title=1\nx=2", "title", "1\nx=2"),
    ],
)
def test_assignments(text, key, value):
    assert parse_assignment(text) == (key, value)


def test_values_of_assignments_are_toml_or_text():
    assert parse_value("45 min") == "45 min"
    assert parse_value("true") is True
    assert parse_value("[" * 10_000) == "[" * 10_000


@pytest.mark.parametrize("text", ["growth.time", "=3", "growth.time=", "", "="])
def test_malformed_assignments(text):
    with pytest.raises(SceneError, match=r"TABLE\.KEY=VALUE"):
        parse_assignment(text)
