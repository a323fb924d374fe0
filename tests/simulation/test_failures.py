"""A run that fails or is interrupted keeps what it has computed."""

from pathlib import Path

import numpy as np
import pytest
import ufl

from fenics_yeast import Scene, simulate
from fenics_yeast.mechanics import Law
from fenics_yeast.mechanics import growth_laws as growth
from fenics_yeast.simulation import COLUMNS, Profile, Result, Row
from fenics_yeast.solve.time_stepper import TimeStepper

LAW = {"sigma_trs": 1.0, "t_grw": 45.0}


@pytest.fixture
def scene(sphere_scene: Scene) -> Scene:
    """A sphere that grows everywhere, with steps of 1 min."""
    return sphere_scene.with_values({"run.save": [2.0, 8.0]})


class Listener:
    """An observer that raises an exception at a row."""

    def __init__(self, at: int, problem: BaseException) -> None:
        self.at, self.problem = at, problem
        self.rows: list[Row] = []
        self.profiles: list[Profile] = []

    def accepted(self, row: Row) -> None:
        self.rows.append(row)
        if len(self.rows) == self.at:
            raise self.problem

    def saved(self, profile: Profile) -> None:
        self.profiles.append(profile)


def assert_kept(result: Result, rows: int) -> None:
    """Assert that there are finite rows, at least so many, and a profile of the last of them."""
    history = result.history
    assert len(history) >= rows
    assert all(np.isfinite(getattr(history, name)).all() for name in COLUMNS[:-1])
    assert result.profiles.all[-1].time == history.time_min[-1] == result.end_time
    assert all(np.isfinite(array).all() for array in result.profiles.arrays().values())


def test_a_law_that_becomes_nan_ends_the_run_as_failed(scene: Scene) -> None:
    """The wall has no growth rate beyond a growth strain of 0.05."""

    def brittle(point, sigma_trs, t_grw):  # type: ignore[no-untyped-def]
        rate = growth.stress_driven(point, sigma_trs, t_grw)
        return (1 + 1e-9 * ufl.ln(0.05 - point.eps_g[0])) * rate

    result = simulate(scene, growth_law=Law(brittle, LAW))
    assert result.status == "failed"
    assert "even with the smallest step: the residual is not a number" in result.message
    assert_kept(result, 2)
    # Up to there the results are those of the usual law.
    usual = simulate(scene)
    np.testing.assert_allclose(
        result.history.volume_ratio[:2], usual.history.volume_ratio[:2], rtol=1e-6
    )
    assert 0.04 < result.history.max_growth_strain[-1] < 0.05


def test_an_exception_in_the_code_of_a_law_becomes_a_value_error(scene: Scene) -> None:
    def wrong(point):  # type: ignore[no-untyped-def]
        raise ZeroDivisionError("in my law")

    with pytest.raises(ValueError, match="ZeroDivisionError: in my law"):
        simulate(scene, growth_law=Law(wrong))


def test_an_unexpected_exception_ends_the_run_as_failed(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    attempt = TimeStepper.attempt

    def breaks(self: TimeStepper, end: float):  # type: ignore[no-untyped-def]
        if end > 4.5:
            self.shell.w.x.array[:] = np.nan
            raise RuntimeError("the machine broke")
        return attempt(self, end)

    caplog.set_level("DEBUG")
    monkeypatch.setattr(TimeStepper, "attempt", breaks)
    result = simulate(scene)
    assert result.status == "failed"
    assert "RuntimeError: the machine broke" in result.message
    assert "the machine broke" in caplog.text  # with its traceback
    assert_kept(result, 5)
    assert result.end_time == 4
    assert [profile.time for profile in result.profiles] == [2, 4]


def test_an_interrupt_in_an_observer_keeps_the_accepted_rows(scene: Scene) -> None:
    listener = Listener(6, KeyboardInterrupt())
    result = simulate(scene, observer=listener)
    assert result.status == "interrupted"
    assert "5 min" in result.message
    assert_kept(result, 6)
    assert [profile.time for profile in listener.profiles] == [2, 5]


def test_an_interrupt_within_newtons_method_keeps_the_accepted_state(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    stages = TimeStepper._solve_stages

    def interrupted(self: TimeStepper, end: float):  # type: ignore[no-untyped-def]
        step = stages(self, end)
        if end > 4.5:
            raise KeyboardInterrupt
        return step

    whole = simulate(scene)
    monkeypatch.setattr(TimeStepper, "_solve_stages", interrupted)
    result = simulate(scene)
    assert result.status == "interrupted"
    assert_kept(result, 5)
    largest = result.profiles.at(4).growth_strain.max()
    assert largest == pytest.approx(whole.history.at(4).max_growth_strain, rel=1e-12)


def test_an_exception_of_an_observer_is_raised(scene: Scene) -> None:
    listener = Listener(3, ZeroDivisionError("mine"))
    with pytest.raises(ZeroDivisionError, match="mine"):
        simulate(scene, observer=listener)
    assert len(listener.rows) == 3  # it is not called again


@pytest.mark.slow
def test_steps_without_a_solution_cost_few_iterations():
    """Ten stages stagnate; with all 40 iterations each they took 700 of 1669."""
    scene = Scene.load(Path(__file__).parents[2] / "demos" / "scenes" / "bud.toml")
    numerics = {"preset": "default", "thickness_points": 19, "thickness_rule": "clustered"}
    result = simulate(scene.with_values({"numerics": {**numerics, "tolerance": 1e-4}}))
    assert result.status == "finished"
    assert result.newton_iterations < 1100
