"""Every error of a scene is reported on one line."""

import random

import pytest
from support.scenes import BALLOON, BUD

from fenics_yeast.scene import (
    Cell,
    Scene,
    SceneError,
    Turgor,
    Wall,
    parse_assignment,
)


@pytest.fixture
def bud() -> Scene:
    return Scene.from_toml(BUD, source="bud.toml")


def replaced(old: str, new: str) -> str:
    assert BUD.count(old) == 1
    return BUD.replace(old, new)


# What is wrong, and what the message must contain: the key, the value, what must hold.
MALFORMED = {
    "syntax": (replaced('shape = "sphere"', "shape sphere"), ["not TOML", "line 4"]),
    "unquoted unit": (replaced('"100 nm"', "100 nm"), ["not TOML", "line 8"]),
    "key twice": (replaced("order = 1", "elements = 1"), ["not TOML"]),
    "nested too deeply": ("a = " + "[" * 10_000, ["brackets are nested too deeply"]),
    "control character": (replaced("sphere", "sph\x00ere"), ["not TOML"]),
    "empty": ("", ["cell is missing", "[cell]", "(and 1 more error)"]),
    "unknown table": (replaced("[growth]", "[groth]"), ["groth", "unknown", "mean growth?"]),
    "unknown key": (
        replaced("thickness = ", "thicknes = "),
        ["wall.thicknes", "did you mean wall.thickness?"],
    ),
    "unknown key alone": (
        replaced("[turgor]", "[turgor]\nvolume = 3"),
        ["turgor.volume = 3", "unknown key", "pressure, ramp"],
    ),
    "near key": (
        replaced("[turgor]", "[turgor]\nramps = 3"),
        ["turgor.ramps = 3", "did you mean turgor.ramp?"],
    ),
    "key without a table": ("half_angle = 3\n" + BUD, ["half_angle = 3", "unknown key"]),
    "key of another table": ("diameter = 5\n" + BUD, ["diameter = 5", "mean cell.diameter?"]),
    "odd key": ('"a\\nb" = 5\n' + BUD, [r"a\nb = 5", "unknown key"]),
    "missing key": (replaced('diameter = "5 um"', ""), ["cell.diameter is missing", "length"]),
    "missing nested key": (
        replaced('pole = "top", ', ""),
        ["growth.zone.pole is missing", '"top", "bottom"'],
    ),
    "number for table": (
        replaced('zone = { pole = "top", half_angle = 24.0 }', "zone = 24"),
        ["growth.zone = 24", "table [growth.zone]"],
    ),
    "table for number": (replaced('"100 nm"', "{ nm = 100 }"), ["wall.thickness = {...}"]),
    "list for table": ("wall = [1, 2]\n" + BALLOON.replace("[wall]", "[wal]"), ["mean wall?"]),
    "text for list": (
        BALLOON.replace('shape = "sphere"\ndiameter = 5', 'shape = "profile"\nr = "2 um"\nz = [0]'),
        ['cell.r = "2 um"', "list of lengths"],
    ),
    "number that overflows": (replaced('"5 um"', "1e308"), ["larger than 1e+30 µm"]),
    "table in a list": (replaced("[turgor]", "[[turgor]]"), ["turgor = [{...}]", "[turgor]"]),
    "date": (replaced('"45 min"', "1979-05-27T07:32:00Z"), ["growth.time = 1979-05-27", "a time"]),
    "unknown key in a list": (
        replaced("[turgor]", "[[wall.zone]]\nthicknesss = 1\n[turgor]"),
        ["wall.zone[0].thicknesss = 1", "did you mean wall.zone[0].thickness?"],
    ),
    "number for bool": (
        replaced("[turgor]", "bending = 1\n[turgor]"),
        ["wall.bending = 1: expected true or false"],
    ),
    "bool for quantity": (replaced('"1 MPa"', "true"), ["growth.threshold = true", "pressure"]),
    "bool for count": (
        replaced("order = 1", "order = true"),
        ["numerics.order = true", "an integer"],
    ),
    "real for count": (replaced("480", "480.0"), ["numerics.elements = 480.0", "an integer"]),
    "text for count": (replaced("480", '"480"'), ['numerics.elements = "480"', "an integer"]),
    "text for number": (replaced("1e-4", '"1e-4"'), ['numerics.tolerance = "1e-4"', "number"]),
    "number for text": (replaced('"S. cerevisiae bud"', "3"), ["title = 3: expected a string"]),
    "no unit": (replaced('"100 nm"', '"100"'), ['wall.thickness = "100"', "no unit", '"100 nm"']),
    "unit alone": (replaced('"100 nm"', '"nm"'), ['wall.thickness = "nm"', '"100 nm"']),
    "wrong dimension": (
        replaced('"100 nm"', '"100 kg"'),
        ['wall.thickness = "100 kg": expected a length', '"100 nm"', "plain numbers are in µm"],
    ),
    "time for pressure": (replaced('"2 atm"', '"2 min"'), ['turgor.pressure = "2 min"', "MPa"]),
    "length for angle": (replaced("24.0", '"1 um"'), ['half_angle = "1 um"', "degrees"]),
    "unknown unit": (
        replaced('"100 nm"', '"100 furlong"'),
        ['wall.thickness = "100 furlong"', 'unknown unit "furlong"', '"100 nm"'],
    ),
    "unit with a factor": (replaced('"100 nm"', '"100 9**9**9 m"'), ["unknown unit"]),
    "expression": (replaced('"100 nm"', '"100 nm + 1 nm"'), ["unknown unit", "wall.thickness"]),
    "two lines": (replaced('"100 nm"', '"100 n\\nm"'), [r'wall.thickness = "100 n\nm"']),
    "nan": (replaced("24.0", "nan"), ["growth.zone.half_angle = nan", "not finite", "180"]),
    "nan without unit": (replaced("2.0", "nan"), ["wall.ogden_exponent = nan", "finite"]),
    "nan penalty": (replaced("1000.0", "nan"), ["numerics.shear_penalty = nan", "> 0"]),
    "nan pressure": (replaced('"2 atm"', "nan"), ["turgor.pressure = nan", "not finite"]),
    "nan in text": (replaced('"2 atm"', '"nan atm"'), ['turgor.pressure = "nan atm"']),
    "infinity": (replaced('"90 min"', "inf"), ["run.end = inf", "not finite"]),
    "infinite in text": (replaced('"2 atm"', '"1e999 atm"'), ["turgor.pressure", "not finite"]),
    "huge integer": (replaced('"5 um"', "1" * 400), ["cell.diameter", "not finite"]),
    "endless integer": (replaced('"5 um"', "0x" + "f" * 9999), ["cell.diameter", "not finite"]),
    "other shape": (replaced('"sphere"', '"cube"'), ['cell.shape = "cube"', '"sphere"']),
    "other preset": (replaced('"default"', '"Paper"'), ['numerics.preset = "Paper"', '"paper"']),
    "other integrator": (replaced('"backward-euler"', '"rk4"'), ['"rk4"', '"sdirk3"']),
    "list for choice": (replaced('"conical"', "[]"), ["numerics.geometry = []", '"curved"']),
    "no diameter": (replaced('"5 um"', '"0 um"'), ['cell.diameter = "0 um"', "> 0"]),
    "negative thickness": (replaced('"100 nm"', "-0.1"), ["wall.thickness = -0.1", "> 0"]),
    "wall thicker than the cell": (
        replaced('"100 nm"', '"3 um"'),
        ['wall.thickness = "3 um"', "radius (2.5 µm)"],
    ),
    "exponent 0": (replaced("2.0", "0"), ["wall.ogden_exponent = 0", "must not be 0"]),
    "negative ramp": (replaced('"0.01 min"', "-1"), ["turgor.ramp = -1", ">= 0"]),
    "zone of 0°": (replaced("24.0", "0"), ["growth.zone.half_angle = 0", "> 0"]),
    "zone beyond 180°": (replaced("24.0", '"181 deg"'), ['half_angle = "181 deg"', "<= 180"]),
    "no threshold": (replaced('"1 MPa"', "0"), ["growth.threshold = 0", "> 0"]),
    "no end": (replaced('"90 min"', "0"), ["run.end = 0", "> 0"]),
    "saved after the end": (
        replaced("[40, 70, 90]", '[40, "2 h"]'),
        ['run.save = [40, "2 h"]', "120 min is outside", "run.end (90 min)"],
    ),
    "saved before the start": (replaced("[40, 70, 90]", "[-1]"), ["run.save = [-1]", "-1 min"]),
    "empty saved time": (replaced("[40, 70, 90]", '[40, ""]'), ['run.save[1] = ""', "a time"]),
    "nan saved": (replaced("[40, 70, 90]", "[nan]"), ["run.save[0] = nan", "not finite"]),
    "one saved time": (replaced("[40, 70, 90]", "40"), ["run.save = 40", "list of times"]),
    "nested saved times": (replaced("[40, 70, 90]", "[[40]]"), ["run.save[0] = [40]", "a time"]),
    "growth without run": (
        BUD[: BUD.index("[run]")],
        ["run is missing: growth needs [run], e.g. end ="],
    ),
    "one element": (replaced("480", "1"), ["numerics.elements = 1", ">= 2 and <= 100000"]),
    "too many elements": (replaced("480", "100_001"), ["elements = 100001", "<= 100000"]),
    "order 5": (replaced("order = 1", "order = 5"), ["numerics.order = 5", "<= 4"]),
    "25 points": (replaced("points = 3", "points = 25"), ["thickness_points = 25", "<= 24"]),
    "two clustered points": (
        replaced("points = 3", 'points = 2\nthickness_rule = "clustered"'),
        ["numerics.thickness_points = 2", "expected 3 or more", 'use "gauss"'],
    ),
    "no step": (replaced('"0.2 min"', "0"), ["numerics.step = 0", "> 0", '"adaptive"']),
    "loose tolerance": (replaced("1e-4", "0.2"), ["numerics.tolerance = 0.2", "<= 0.1"]),
    "loose tolerance of a preset": (
        BALLOON + "[numerics]\ntolerance = 7",
        ["numerics.tolerance = 7", "<= 0.1"],
    ),
    "several": (
        BUD.replace("480", "1").replace('"conical"', "3").replace("1e-4", "7"),
        ["numerics.tolerance = 7", "(and 2 more errors)"],
    ),
    "wrong preset and a key": (
        BALLOON + '[numerics]\npreset = "x"\norder = 9\n',
        ['numerics.preset = "x": expected one of', "(and 1 more error)"],
    ),
}


def assert_one_line(message: str) -> None:
    assert len(message.splitlines()) == 1
    assert message.isprintable()
    assert len(message) < 400
    assert "pydantic" not in message


@pytest.mark.parametrize(("text", "said"), MALFORMED.values(), ids=MALFORMED)
def test_malformed_scenes_are_reported_on_one_line(tmp_path, text, said):
    path = tmp_path / "bud.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        Scene.load(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    message = message.removeprefix(f"{path}: ")
    assert_one_line(message)
    for part in said:
        assert part in message


def test_unreadable_files_are_reported_on_one_line(tmp_path):
    latin = tmp_path / "latin.toml"
    latin.write_bytes('title = "ä"'.encode("latin-1"))
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    for path, said in [
        (tmp_path / "none.toml", "no such file"),
        (tmp_path, "cannot be read: Is a directory"),
        (latin / "bud.toml", "cannot be read: Not a directory"),
        (latin, "not UTF-8 at byte 10; save the file as UTF-8"),
        (loop, "cannot be read"),
        ("bud\0.toml", "cannot be read"),
        ("bud\n.toml", "no such file"),
    ]:
        with pytest.raises(SceneError, match=said) as caught:
            Scene.load(path)
        assert_one_line(str(caught.value))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"growth.time": -3}, "bud.toml: growth.time = -3: expected a time > 0"),
        ({"growth.tim": 3}, "bud.toml: growth.tim = 3: unknown key; did you mean growth.time?"),
        ({"cell.diameter.x": 3}, "bud.toml: cell.diameter.x = 3: diameter is a value, not a table"),
        ({"run.save.0": 3}, "bud.toml: run.save.0 = 3: save is a value, not a table"),
        ({"run": None}, "bud.toml: run = None: growth needs [run], e.g. end"),
        ({"cell": None}, "bud.toml: cell = None: expected a table [cell]"),
        (
            {"run.end": 50},
            "bud.toml: run.save = [40.0, 70.0, 90.0]: 70 min is outside the run; saved times must "
            "lie between 0 and run.end (50 min); if you change run.end, also set run.save",
        ),
        ({"growth": {1: 2}}, "bud.toml: growth"),
        ({"": 3}, "bud.toml:  = 3: unknown key"),
        ({"growth.time": object()}, "bud.toml: growth.time = <object"),
    ],
)
def test_wrong_changes_are_reported_on_one_line(bud, changes, said):
    with pytest.raises(SceneError) as caught:
        bud.with_values(changes)
    assert_one_line(str(caught.value))
    assert str(caught.value).startswith(said)


def test_errors_of_tables_built_in_python_are_reported_on_one_line():
    with pytest.raises(SceneError, match=r"^Cell: diameter = -1: expected a length > 0"):
        Cell(shape="sphere", diameter=-1)
    with pytest.raises(SceneError, match=r"^Scene: wall is missing"):
        Scene(cell=Cell(shape="sphere", diameter=5), turgor=Turgor(pressure=1))
    with pytest.raises(
        SceneError,
        match=r"^Scene: wall.thickness = 4.0: must be less than the cell's radius \(2.5 µm\)",
    ):
        Scene(
            cell=Cell(shape="sphere", diameter=5),
            wall=Wall(thickness=4, shear_modulus=1),
            turgor=Turgor(pressure=1),
        )


def test_a_scene_with_random_edits_is_read_or_raises_a_scene_error():
    chance = random.Random(1)
    pieces = [*'=[]{}".,#-+_eE0', "\n", "\n[", "nan", "inf", "true", "1e999", "5 kg", "µ", "\x07"]
    words = BUD.split()
    refused = 0
    for _ in range(1000):
        text = BUD
        for _ in range(chance.randint(1, 4)):
            start = chance.randrange(len(text))
            end = start + chance.choice([0, 1, 3, 10])
            new = chance.choice([chance.choice(pieces), chance.choice(words), text[start:end] * 2])
            text = text[:start] + new + text[end:]
        try:
            Scene.from_toml(text)
        except SceneError as error:
            assert_one_line(str(error))
            refused += 1
    assert 500 < refused < 1000


def test_a_value_of_any_type_at_any_key_is_taken_or_raises_a_scene_error(bud):
    keys = [
        f"{table}.{key}"
        for table, model in Scene.model_fields.items()
        if table != "title"
        for key in bud.model_dump()[table] or ()
    ]
    keys += ["title", "cell", "growth", "numerics", "growth.zone.pole", "growth.zone.half_angle"]
    texts = ["0", "-1", "1e300", "5e-324", "nan", "-inf", "true", "[]", "{}", "[[1]]", "''", "x"]
    texts += ["{a=1}", "[{a=1}]", "07:32:00", "1979-05-27", "'1 m'", "5 µ", "1 / 0 m", "9" * 5000]
    for key in keys:
        for text in texts:
            try:
                bud.with_values(dict([parse_assignment(f"{key}={text}")]))
            except SceneError as error:
                assert_one_line(str(error))
                assert key in str(error) or "wall.thickness" in str(error)
