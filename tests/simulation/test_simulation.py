"""Runs step by step from Python, and their tables in a notebook."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fenics_yeast import Scene, SceneError, Simulation, simulate
from fenics_yeast.simulation import COLUMNS, History, Profiles, Result, Row


@pytest.fixture
def scene(sphere_scene: Scene) -> Scene:
    """A sphere that grows everywhere, with steps of 1 min."""
    return sphere_scene.with_values({"run.save": [2.0, 8.0]})


@pytest.fixture(scope="module")
def whole(sphere_scene: Scene) -> Result:
    return simulate(sphere_scene.with_values({"run.save": [2.0, 8.0]}))


def test_a_callback_gets_every_row(scene: Scene, whole: Result) -> None:
    rows: list[Row] = []
    result = simulate(scene, callback=rows.append)
    assert tuple(rows) == result.history.rows == whole.history.rows


def test_an_exception_of_a_callback_is_raised(scene: Scene) -> None:
    def stop(row: Row) -> None:
        if row.time_min > 2:
            raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        simulate(scene, callback=stop)


def test_iterating_gives_the_rows_of_simulate(scene: Scene, whole: Result) -> None:
    with Simulation(scene) as simulation:
        rows = list(simulation)
    assert tuple(rows) == whole.history.rows
    result = simulation.result
    assert (result.status, result.message) == (whole.status, whole.message)
    assert len(result.profiles) == 2
    assert list(simulation) == []


def test_leaving_the_loop_interrupts_the_run_and_keeps_rows(scene: Scene, whole: Result) -> None:
    with Simulation(scene) as simulation:
        for row in simulation:
            if row.time_min > 2.5:
                break
        so_far = simulation.result
        assert so_far.status == "interrupted" and len(so_far.profiles) == 1
    result = simulation.result
    assert result.status == "interrupted" and result.message == "stopped at 3 min"
    assert result.history.rows == whole.history.rows[:4]
    assert [profile.time for profile in result.profiles] == [2, 3]
    assert list(simulation) == []  # after the block it is closed


def test_iteration_continues_after_a_first_row(scene: Scene, whole: Result) -> None:
    with Simulation(scene) as simulation:
        first = next(simulation)
        rest = list(simulation)
    assert (first, *rest) == whole.history.rows
    assert simulation.result.status == "finished"


def test_an_interrupt_between_two_steps_ends_the_run_as_interrupted(
    scene: Scene, whole: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    step = Simulation.__next__

    def interrupted(simulation: Simulation) -> Row:
        if len(simulation.result.history) == 4:
            raise KeyboardInterrupt
        return step(simulation)

    monkeypatch.setattr(Simulation, "__next__", interrupted)
    result = simulate(scene)
    assert (result.status, result.message) == ("interrupted", "interrupted at 3 min")
    assert result.history.rows == whole.history.rows[:4]


def test_an_exception_in_the_loop_ends_the_run(scene: Scene) -> None:
    with pytest.raises(ZeroDivisionError), Simulation(scene) as simulation:
        for row in simulation:
            assert 1 / (row.time_min - 3)
    assert simulation.result.message == "stopped at 3 min"


def test_time_spent_between_steps_is_not_loop_time(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    from time import sleep

    with Simulation(scene) as simulation:
        for _ in simulation:
            sleep(0.2)
    timings = simulation.result.timings
    assert timings.total_s > 9 * 0.2 > timings.loop_s


# --- notebooks ----------------------------------------------------------------------------


def test_results_are_short_tables_in_a_notebook(whole: Result) -> None:
    pytest.importorskip("pandas")
    html = whole._repr_html_()
    assert html is not None and html.count("<tr") == 3  # head, 2 min, 8 min
    assert f"{whole.history.at(8).volume_ratio:.6f}" in html
    assert "finished: reached 8 min" in html and "finished" in repr(whole)
    profiles, history = whole.profiles._repr_html_(), whole.history._repr_html_()
    assert profiles is not None and profiles.count("<tr") == 3
    assert history is not None and history.count("<tr") == 10
    many = History([whole.history.rows[0]] * 500)._repr_html_()
    assert many is not None and many.count("<tr") == 12
    for empty in (History(()), Profiles(())):
        assert "empty" in repr(empty) and "<table" in (empty._repr_html_() or "")


def test_a_message_is_escaped_in_html(whole: Result) -> None:
    pytest.importorskip("pandas")
    from dataclasses import replace

    assert "a &lt; b" in (replace(whole, message="a < b")._repr_html_() or "")


def test_results_have_no_html_without_pandas(
    whole: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    assert whole._repr_html_() is None


def test_a_history_converts_to_a_pandas_frame(whole: Result) -> None:
    pandas = pytest.importorskip("pandas")
    frame = whole.history.to_frame()
    assert list(frame.columns) == list(COLUMNS)
    assert isinstance(frame, pandas.DataFrame)
    np.testing.assert_array_equal(frame["volume_ratio"], whole.history.volume_ratio)


def test_a_frame_has_all_columns(whole: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    assert list(whole.history.to_frame()) == list(COLUMNS)


def test_to_frame_without_pandas_says_what_to_install(
    whole: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"^to_frame needs pandas; run: pip install pandas$"):
        whole.history.to_frame()


def test_the_response_to_a_tiny_pressure_is_that_of_linear_theory(elastic_scene: Scene) -> None:
    """V/V0 - 1 = p R / (4 μ h) of a thin neo-Hookean sphere, down to round-off of V/V0."""
    sphere = elastic_scene.with_values({"numerics": {}})
    wall = sphere.wall
    compliance = sphere.cell.radius / (4 * wall.shear_modulus * wall.thickness)
    for pressure in (1e-4, 1e-6, 1e-8, 1e-10):
        ratio = simulate(sphere.with_values({"turgor.pressure": pressure})).history.volume_ratio[-1]
        assert (ratio - 1) / pressure == pytest.approx(compliance, rel=1e-3)


def test_a_scene_may_be_given_by_its_file(elastic_scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(elastic_scene.to_toml())
    found, known = simulate(tmp_path / "cell.toml"), simulate(elastic_scene)
    assert found.history.rows == known.history.rows
    with pytest.raises(SceneError, match="no such file"):
        simulate(str(tmp_path / "none.toml"))


def test_a_jump_of_the_pressure_takes_an_elastic_cell_from_one_equilibrium_to_the_other(
    scene: Scene,
) -> None:
    jump = {"time": [0, 4, 4], "value": [0.2, 0.2, 0.1]}
    changes = {"growth": None, "run.save": [4, 8], "turgor.ramp": 0, "turgor.pressure": jump}
    volumes = simulate(scene.with_values(changes)).history
    for time, pressure in ((4, 0.2), (8, 0.1)):
        static = {"growth": None, "run": None, "turgor.pressure": pressure}
        expected = simulate(scene.with_values(static)).history.volume_ratio[-1]
        assert volumes.at(time).volume_ratio == pytest.approx(expected, rel=1e-9)
