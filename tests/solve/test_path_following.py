"""Static paths, stability, limit pressures, and a turgor that changes in time."""

import numpy as np
import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.scene import PressureTable, StaticPath, Until
from fenics_yeast.simulation import Result

MU, H, R = 40.0, 0.1, 2.5
UNIT = MU * H / R


def balloon(volume_ratio: np.ndarray) -> np.ndarray:
    """p R/(μ h) of a neo-Hookean membrane."""
    return 2 * (volume_ratio ** (-1 / 3) - volume_ratio ** (-7 / 3))


def walk(scene: Scene, control: str, steps: int = 60, **until: float) -> Result:
    path = StaticPath(control=control, until=Until(**until), steps=steps)
    return simulate(scene.with_values({"path": path}))


@pytest.mark.parametrize("control", ["volume", "arc-length"])
def test_path_passes_the_limit_point_of_a_balloon(elastic_scene: Scene, control: str) -> None:
    result = walk(elastic_scene, control, volume_ratio=8.0)
    history = result.history
    assert result.status == "finished"
    assert history.volume_ratio[0] == 1 and history.pressure_MPa[0] == 0
    assert history.volume_ratio[-1] == pytest.approx(8, rel=1e-8)
    shell = history.pressure_MPa / UNIT
    np.testing.assert_allclose(shell, balloon(history.volume_ratio), atol=2e-4)
    assert 55 < len(history) < 80 and not history.time_min.any()
    assert history.newton_iterations.sum() < 3 * len(history)
    assert "past a limit point at 1.98" in result.message
    assert result.profiles.all[-1].r.max() == pytest.approx(2 * R, rel=1e-3)
    # Stable up to the limit point under given pressure, not beyond.
    top = 7**0.5
    assert history.stable[history.volume_ratio < 0.98 * top].all()
    assert not history.stable[history.volume_ratio > 1.02 * top].any()


def test_all_controls_of_pressure_reach_the_same_state(elastic_scene: Scene) -> None:
    by = {c: walk(elastic_scene, c, pressure=1.5) for c in ("pressure", "volume", "arc-length")}
    ends = [result.history.volume_ratio[-1] for result in by.values()]
    np.testing.assert_allclose(ends, ends[0], rtol=1e-7)
    for result in by.values():
        assert result.history.pressure_MPa[-1] == pytest.approx(1.5, rel=1e-9)
        assert result.history.stable.all()


@pytest.mark.distributed
@pytest.mark.parametrize("control", ["pressure", "volume", "arc-length"])
def test_unreachable_pressure_is_reported_with_the_limit_pressure(
    elastic_scene: Scene, control: str
) -> None:
    result = walk(elastic_scene, control, steps=20, pressure=2.5)
    assert result.status == "no-equilibrium"
    said = float(result.message.split("limit pressure exceeded (")[1].split(" MPa")[0])
    assert said / UNIT == pytest.approx(1.239463, rel=2e-3)
    assert result.history.pressure_MPa.max() / UNIT == pytest.approx(1.239463, rel=2e-3)


def test_stiffening_balloon_has_no_limit_point(elastic_scene: Scene) -> None:
    stiff = elastic_scene.with_values({"wall.ogden_exponent": 8.0})
    for control in ("pressure", "arc-length"):
        result = walk(stiff, control, volume_ratio=4.0)
        assert result.status == "finished"
        assert "limit point" not in result.message
        assert (np.diff(result.history.pressure_MPa) > 0).all()
        assert result.history.stable.all()


def outside(scene: Scene, ratio: float, times: float) -> tuple[Scene, float]:
    """A wall of h/R whose mesh resolves buckles of length √(R h), and its classical pressure."""
    critical = 2 * 3 * MU * ratio**2 / np.sqrt(3 * 0.75)
    values = {
        "wall.thickness": ratio * R,
        "turgor.pressure": -times * critical,
        "numerics.elements": int(20 / ratio**0.5),
        "numerics.order": 3,
    }
    return scene.with_values(values), critical


@pytest.mark.parametrize("ratio", [1 / 100, 1 / 300, 1 / 1000])
def test_sphere_under_external_pressure_loses_stability_at_its_classical_pressure(
    elastic_scene: Scene, ratio: float
) -> None:
    scene, critical = outside(elastic_scene, ratio, 1.1)
    result = walk(scene, "pressure", steps=22, pressure=-1.1 * critical)
    history = result.history
    assert result.status == "finished"
    assert "unstable beyond" in result.message
    lost = np.flatnonzero(~history.stable)
    assert (np.diff(lost) == 1).all() and lost[-1] == len(history) - 1  # it stays lost
    assert result.bifurcation is not None and result.bifurcation.step == lost[0] - 1
    assert -result.bifurcation.pressure_MPa / critical == pytest.approx(1, abs=0.03)


@pytest.mark.parametrize(("times", "stable"), [(0.95, True), (1.05, False)])
def test_static_scene_and_run_report_whether_they_are_stable(
    elastic_scene: Scene, times: float, stable: bool
) -> None:
    scene, critical = outside(elastic_scene, 1 / 200, times)
    static = simulate(scene)
    run = simulate(
        scene.with_values({"run": {"end": 1.0}, "turgor.ramp": 1.0, "numerics.step": 0.05})
    )
    for result in (static, run):
        assert result.status == "finished"
        assert result.history.stable[-1] == stable
        assert ("unstable" in result.message) != stable
    if not stable:  # reported with its time and pressure
        first = np.flatnonzero(~run.history.stable)[0]
        assert f"beyond {run.history.time_min[first - 1]:.6g} min" in run.message
        assert -run.history.pressure_MPa[first - 1] / critical == pytest.approx(1, abs=0.03)


def test_growing_bud_is_stable_until_it_bursts(bud_run: Result) -> None:
    assert bud_run.history.stable.all()
    assert "unstable" not in bud_run.message


@pytest.mark.distributed
@pytest.mark.parametrize("values", [{}, {"run": {"end": 1.0}}])
def test_equilibrium_just_below_the_limit_pressure_is_found(
    elastic_scene: Scene, values: dict
) -> None:
    """Plain Newton's method could end on the other side of the limit point."""
    below = 1.2390 * UNIT
    result = simulate(elastic_scene.with_values({"turgor.pressure": below, **values}))
    assert result.status == "finished"
    assert result.history.stable.all()
    ratio = result.history.volume_ratio[-1]
    assert ratio < 7**0.5 and balloon(ratio) == pytest.approx(1.2390, abs=2e-4)


# --- turgor in time -----------------------------------------------------------------------


def changing(scene: Scene, **values: object) -> Result:
    table = PressureTable(time=(0.0, 1.0, 1.5, 3.0), value=(0.2, 0.2, 0.02, 0.04))
    changes = {"turgor.pressure": table, "run": {"end": 4.0, "save": [4.0]}, **values}
    return simulate(scene.with_values(changes))


@pytest.mark.distributed
def test_turgor_follows_its_table_and_meets_its_kinks(sphere_scene: Scene) -> None:
    result = changing(sphere_scene, **{"growth": None, "turgor.ramp": 0.25, "numerics.step": 0.3})
    history = result.history
    for time, pressure in ((0.25, 0.2), (1, 0.2), (1.5, 0.02), (3, 0.04), (4, 0.04)):
        assert history.at(time).pressure_MPa == pytest.approx(pressure, rel=1e-12)
    first = history.time_min <= 0.25
    np.testing.assert_allclose(history.pressure_MPa[first], 0.8 * history.time_min[first])
    later = (history.time_min >= 1.5) & (history.time_min <= 3)
    expected = 0.02 + 0.02 * (history.time_min[later] - 1.5) / 1.5
    np.testing.assert_allclose(history.pressure_MPa[later], expected)
    shell = history.pressure_MPa / UNIT
    np.testing.assert_allclose(shell, balloon(history.volume_ratio), atol=2e-4)


def test_nothing_grows_while_the_turgor_is_below_the_threshold(sphere_scene: Scene) -> None:
    history = changing(sphere_scene, **{"numerics.step": None}).history
    low = (history.time_min >= 1.5) & (history.time_min <= 3)  # below the threshold throughout
    grown = history.max_growth_strain[low]
    assert grown[0] > 0.01
    np.testing.assert_allclose(grown, grown[0], rtol=1e-12)


def test_step_in_which_nothing_changes_ends_at_the_next_milestone(sphere_scene: Scene) -> None:
    idle = {"growth.threshold": 10.0, "run": {"end": 1e6, "save": [3.0, 1e6]}}
    for step in (0.2, None):
        result = simulate(sphere_scene.with_values({**idle, "numerics.step": step}))
        assert result.status == "finished" and "nothing grew" in result.message
        assert len(result.history) < 10
        assert [profile.time for profile in result.profiles] == [3, 1e6]
