"""Loads of a scene other than constant turgor: time-dependent pressure, forces, static paths."""

import tomllib

import pytest
import tomli_w
from support import scenes

from fenics_yeast import Scene, SceneError
from fenics_yeast.scene import Cell, PressureTable, StaticPath, Until

BALLOON = scenes.BALLOON[: scenes.BALLOON.index("[turgor]")]
STEADY = "[turgor]\npressure = 0.2\n"
RUN = "[run]\nend = 90\n"
GROWTH = '[growth]\nzone = { pole = "top", half_angle = 24 }\nthreshold = 1\ntime = 45\n'


def scene(text: str) -> Scene:
    return Scene.from_toml(BALLOON + text, source="balloon.toml")


def with_pressure(table: str) -> str:
    return f"[turgor]\npressure = {table}\n"


CHANGING = with_pressure('{ time = [0, "30 min", 40], value = ["2 atm", "2 atm", "0.2 atm"] }')


def test_a_changing_pressure_is_read_in_its_units() -> None:
    pressure = scene(CHANGING + RUN).turgor.pressure
    assert pressure == PressureTable(time=(0, 30, 40), value=(0.20265, 0.20265, 0.020265))


def test_a_path_prescribes_the_volume_in_60_steps_by_default() -> None:
    path = scene(STEADY + "[path]\nuntil = { volume_ratio = 8 }\n").path
    assert path == StaticPath(control="volume", until=Until(volume_ratio=8.0), steps=60)
    text = '[path]\ncontrol = "arc-length"\nuntil = { pressure = "1 bar" }\nsteps = 9\n'
    path = scene(STEADY + text).path
    assert path == StaticPath(control="arc-length", until=Until(pressure=0.1), steps=9)


@pytest.mark.parametrize(
    "text",
    [
        CHANGING + RUN,
        CHANGING + RUN + GROWTH,
        STEADY + "[path]\nuntil = { volume_ratio = 8 }\n",
        STEADY + '[path]\ncontrol = "pressure"\nuntil = { pressure = -1 }\nsteps = 3\n',
    ],
)
def test_written_scenes_read_back_equal(text: str) -> None:
    first = scene(text)
    again = Scene.from_toml(first.to_toml())
    assert again == first
    assert hash(again) == hash(first)
    assert again.to_toml() == first.to_toml()


def test_values_can_be_changed() -> None:
    steady = scene(STEADY + RUN)
    table = {"time": [0, 10], "value": [0.1, "2 bar"]}
    changed = steady.with_values({"turgor.pressure": table})
    assert changed.turgor.pressure == PressureTable(time=(0, 10), value=(0.1, 0.2))
    assert changed.with_values({"turgor.pressure.value": [0, 1]}).turgor.pressure == PressureTable(
        time=(0, 10), value=(0, 1)
    )
    assert changed.with_values({"turgor.pressure": 0.2}) == steady
    path = {"run": None, "path": StaticPath(until=Until(pressure=1))}
    assert steady.with_values(path).with_values({"path.steps": 5}).path == StaticPath(
        until=Until(pressure=1), steps=5
    )


MALFORMED = {
    "one pressure for two times": (
        with_pressure("{ time = [0, 3], value = [1] }") + RUN,
        "turgor.pressure.value = [1]: expected 2 pressures, one per time",
    ),
    "no times": (
        with_pressure("{ time = [], value = [] }") + RUN,
        "turgor.pressure.time = []: expected times >= 0 in order",
    ),
    "decreasing times": (
        with_pressure("{ time = [3, 2], value = [1, 1] }") + RUN,
        "turgor.pressure.time = [3, 2]: expected times >= 0 in order",
    ),
    "three equal times": (
        with_pressure("{ time = [2, 2, 2], value = [1, 1, 1] }") + RUN,
        "turgor.pressure.time = [2, 2, 2]: expected at most two equal times",
    ),
    "time before the start": (
        with_pressure("{ time = [-1, 2], value = [1, 1] }") + RUN,
        "turgor.pressure.time = [-1, 2]: expected times >= 0 in order",
    ),
    "time for pressure": (
        with_pressure('{ time = [0, 2], value = ["1 min", 1] }') + RUN,
        'turgor.pressure.value[0] = "1 min": expected a pressure or stress',
    ),
    "not a number": (
        with_pressure("{ time = [0, nan], value = [1, 1] }") + RUN,
        "turgor.pressure.time[1] = nan: not finite; expected a time",
    ),
    "values missing": (
        with_pressure("{ time = [0, 1] }") + RUN,
        "turgor.pressure.value is missing: expected a list of pressures",
    ),
    "value for a list": (
        with_pressure("{ time = [0], value = 1 }") + RUN,
        "turgor.pressure.value = 1: expected a list of pressures",
    ),
    "other key": (
        with_pressure("{ times = [0, 1], time = [0, 1], value = [1, 1] }") + RUN,
        "turgor.pressure.times = [0, 1]: unknown key; did you mean turgor.pressure.time?",
    ),
    "list for table": (
        with_pressure("[0, 1]") + RUN,
        "turgor.pressure = [0, 1]: expected a pressure or stress",
    ),
    "changing without a run": (
        CHANGING,
        "turgor.pressure = {...}: a time-dependent pressure needs [run], e.g. end",
    ),
    "path and run": (
        STEADY + RUN + "[path]\nuntil = { volume_ratio = 8 }\n",
        "run = {...}: a [path] is static; remove [path] or [run]",
    ),
    "path and growth": (
        STEADY + GROWTH + "[path]\nuntil = { volume_ratio = 8 }\n",
        "growth = {...}: a [path] is static",
    ),
    "path without end": (STEADY + "[path]\n", "path.until is missing"),
    "no end": (
        STEADY + "[path]\nuntil = {}\n",
        "path.until = {...}: expected exactly one of volume_ratio",
    ),
    "two ends": (
        STEADY + "[path]\nuntil = { volume_ratio = 8, pressure = 1 }\n",
        "path.until = {...}: expected exactly one of volume_ratio, pressure, displacement, force",
    ),
    "end at the start": (
        STEADY + "[path]\nuntil = { pressure = 0 }\n",
        "path.until = {...}: must differ from the start of the path",
    ),
    "negative volume": (
        STEADY + "[path]\nuntil = { volume_ratio = -8 }\n",
        "path.until.volume_ratio = -8: must be > 0",
    ),
    "length for pressure": (
        STEADY + '[path]\nuntil = { pressure = "1 um" }\n',
        'path.until.pressure = "1 um": expected a pressure or stress',
    ),
    "unknown end": (
        STEADY + "[path]\nuntil = { volume = 8 }\n",
        "path.until.volume = 8: unknown key; did you mean path.until.volume_ratio?",
    ),
    "unknown control": (
        STEADY + '[path]\ncontrol = "time"\nuntil = { volume_ratio = 8 }\n',
        'path.control = "time": expected one of "pressure", "volume", "arc-length"',
    ),
    "no steps": (
        STEADY + "[path]\nsteps = 0\nuntil = { volume_ratio = 8 }\n",
        "path.steps = 0: expected an integer >= 1",
    ),
}


@pytest.mark.parametrize(("text", "said"), MALFORMED.values(), ids=MALFORMED)
def test_malformed_loads_are_reported_on_one_line(text: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(text)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert message.startswith("balloon.toml: " + said)


@pytest.mark.parametrize("edge", ["guided", "sliding"])
def test_a_membrane_cone_with_a_free_edge_needs_a_radial_support(edge):
    """The other edge must carry the radial pull of the wall."""
    size = "outer_diameter = 6, inner_diameter = 2, height = 2"
    text = f"""
        cell = {{ shape = "cone", {size}, edge = "{edge}" }}
        wall = {{ thickness = 0.1, shear_modulus = 40, bending = false }}
        turgor = {{ pressure = 0.1 }}
    """
    with pytest.raises(SceneError, match=f'cell.edge = "{edge}": must be "hinged" or "clamped"'):
        Scene.from_toml(text)
    Scene.from_toml(text.replace(edge, "hinged"))
    Scene.from_toml(text.replace(", bending = false", ""))


@pytest.mark.parametrize(("old", "new"), [("roller", "guided"), ("axial", "sliding")])
def test_old_names_of_edges_are_refused_with_the_new_one(old: str, new: str) -> None:
    """In silence, a roller of other programs would be taken for another support."""
    for cell in ({"shape": "disc", "diameter": 5.0, "edge": old},
                 {"shape": "cone", "outer_diameter": 5.0, "inner_diameter": 1.0, "height": 1.0,
                  "inner_edge": old}):  # fmt: skip
        with pytest.raises(SceneError, match=f'edge = "{old}": .*write "{new}"'):
            Cell(**cell)


def test_only_a_path_or_a_load_makes_turgor_optional() -> None:
    tables = tomllib.loads(scene(STEADY).to_toml())
    del tables["turgor"]
    with pytest.raises(SceneError, match=r"turgor is missing: expected a table \[turgor\]"):
        Scene.from_toml(tomli_w.dumps(tables))
    for table in ({"path": {"until": {"pressure": 0.1}}}, {"load": {"point_force": 1.0}}):
        found = Scene.from_toml(tomli_w.dumps(tables | table))
        assert found.turgor.pressure == 0
        assert Scene.from_toml(found.to_toml()) == found


@pytest.mark.parametrize(
    ("time", "value", "ramps"),
    [
        ([0, 30, 30], [2, 2, 1], ([0, 30, 30 * (1 + 1e-6)], (2, 2, 1))),
        ([0, 0, 30], [1, 2, 2], ([0, 1e-6, 30], (1, 2, 2))),
        ([5, 5, 5 + 1e-8], [1, 2, 3], ([5, 5 + 5e-9, 5 + 1e-8], (1, 2, 3))),
    ],
)
def test_a_jump_of_the_pressure_is_a_very_short_ramp(time, value, ramps) -> None:
    found = PressureTable(time=time, value=value).ramps
    assert found[0] == pytest.approx(ramps[0], rel=1e-15)
    assert found[1] == ramps[1]
