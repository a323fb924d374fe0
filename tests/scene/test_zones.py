"""Growing zones in a scene: lists of them, their places, and every way to be wrong."""

import numpy as np
import pytest
from support.scenes import BUD

from fenics_yeast.scene import Scene, SceneError


def with_growth(text: str) -> str:
    start, end = BUD.index("[growth]"), BUD.index("[run]")
    return f"{BUD[:start]}{text}\n{BUD[end:]}"


LIST = """[[growth]]
zone = { from = "1 um", to = "2 um" }
threshold = 1
time = 45
[[growth]]
zone = { pole = "top", half_angle = 24 }
threshold = 1
time = 30
from = "10 min"
until = "1 h"
"""


def test_lists_of_zones_are_read_written_and_changed():
    scene = Scene.from_toml(with_growth(LIST))
    assert Scene.from_toml(scene.to_toml()) == scene
    assert [growth.span for growth in scene.growing] == [(0, np.inf), (10, 60)]
    changed = scene.with_values({"growth.0.time": 20, "growth.1.zone.half_angle": 12})
    assert changed.growth_time == 20
    assert changed.growth[1].zone.half_angle == 12
    assert scene.growth_time == 30


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('to = "2 um"', 'to = "0.5 um"', ["growth[0].zone.to", "must be greater than from (1)"]),
        ('to = "2 um"', 'to = "8 um"', ["growth[0].zone = ", "meridian's length (7.85398 µm)"]),
        ('to = "2 um"', 'to = "7 um"', ["growth[1].zone = ", "zones must not overlap"]),
        ('to = "2 um"', "half_angle = 3", ["growth[0].zone.", "either pole and half_angle, from"]),
        ('from = "1 um", ', "", ["growth[0].zone.from is missing", "a length >= 0"]),
        (
            'zone = { from = "1 um", to = "2 um" }',
            "zone = {}",
            ["growth[0].zone = {...}: expected either pole"],
        ),
        ('"top"', '"left"', ['growth[1].zone.pole = "left"', '"top", "bottom", "both"']),
        (
            '"10 min"',
            '"2 h"',
            ['growth[1].until = "1 h"', "must be later than growth.from (120 min)"],
        ),
        ("time = 30", "tim = 30", ["growth[1].tim", "growth[1].time"]),
        ("threshold = 1\ntime = 45", "time = 45", ["growth[0].threshold is missing", "pressure"]),
    ],
)
def test_wrong_zones_are_reported_on_one_line(old, new, said):
    assert LIST.count(old) == 1
    with pytest.raises(SceneError) as caught:
        Scene.from_toml(with_growth(LIST.replace(old, new)))
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    for part in said:
        assert part in message


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("growth.2.time", "growth.2.time = 3: 2 must be the number of an entry, from 0 to 1"),
        ("growth.time", "growth.time = 3: time must be the number of an entry, from 0 to 1"),
    ],
)
def test_changes_of_no_entry_are_reported_on_one_line(change, said):
    scene = Scene.from_toml(with_growth(LIST))
    with pytest.raises(SceneError, match=said):
        scene.with_values({change: 3})
