"""Any physical scene has an answer: it is finished, without equilibrium, or unbounded."""

import os

import pytest
import tomli_w
from hypothesis import given, settings
from support.random_scenes import loaded_scenes, physical_scenes

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import ANSWERS

_PART = 16  # scenes that are read in the time that one is run


@pytest.mark.slow
@given(physical_scenes())
@settings(max_examples=int(os.environ.get("FUZZ", "160")) // _PART)
def test_any_physical_scene_has_an_answer(tables: dict[str, object]) -> None:
    result = simulate(Scene.from_toml(tomli_w.dumps(tables)))
    assert result.status in ANSWERS, result.message
    assert result.history.volume_ratio[0] > 0


@pytest.mark.slow
@given(loaded_scenes())
@settings(max_examples=int(os.environ.get("FUZZ", "160")) // _PART)
def test_any_elastic_wall_under_any_load_has_an_answer(tables: dict[str, object]) -> None:
    result = simulate(Scene.from_toml(tomli_w.dumps(tables)))
    assert result.status in ANSWERS, result.message
