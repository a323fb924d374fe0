"""The tolerance is the error of V/V0 in steps, mesh, integration points and shear penalty."""

import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.output import read_summary
from fenics_yeast.output.job import Job

pytestmark = pytest.mark.slow

# V/V0 of the bud with 16 of Gauss' points, tolerance 1e-6; 9 points differ by 0.0007 at 90 min.
CONVERGED = {60.0: 1.12366, 75.0: 1.17708, 90.0: 1.35143}


def test_the_default_bud_is_within_its_tolerance(cell_scene: Scene) -> None:
    scene = cell_scene.with_values({"numerics": {}, "run.save": list(CONVERGED)})
    assert (scene.numerics.thickness_points, scene.numerics.thickness_rule) == (6, "clustered")
    result = simulate(scene)
    for time, ratio in CONVERGED.items():
        assert result.history.at(time).volume_ratio == pytest.approx(ratio, rel=1e-3)
    assert result.error_estimate is not None
    assert 3e-4 < result.error_estimate.total < 1e-3
    assert result.warnings == ()


@pytest.mark.parametrize("points", [3, 6])
def test_points_clustered_at_the_faces_halve_the_error_of_gauss_and_more(
    cell_scene: Scene, points: int
) -> None:
    scene = cell_scene.with_values({"numerics": {"thickness_points": points}})
    errors = {}
    for rule in ("gauss", "clustered"):
        ratio = simulate(scene.with_values({"numerics.thickness_rule": rule})).history.volume_ratio
        errors[rule] = abs(ratio[-1] / CONVERGED[90.0] - 1)
    assert errors["clustered"] < 0.5 * errors["gauss"]
    assert errors["gauss"] < 0.062 / points**2 and errors["clustered"] < 0.026 / points**2


@pytest.mark.parametrize(
    "numerics", [{"geometry": "conical"}, {"order": 1}, {"order": 2}, {"grading": "uniform"}]
)
def test_each_kind_of_mesh_has_the_elements_that_the_tolerance_asks(
    cell_scene: Scene, numerics: dict
) -> None:
    scene = cell_scene.with_values({"numerics": {**numerics, "thickness_points": 3}})
    scene = scene.with_values({"run.end": 85.0, "run.save": [85.0]})
    chosen = simulate(scene).history.volume_ratio[-1]
    finer = scene.with_values({"numerics.elements": 3 * scene.numerics.elements})
    assert chosen == pytest.approx(simulate(finer).history.volume_ratio[-1], rel=2e-4)


def test_a_wall_that_grows_alike_everywhere_takes_three_points(cell_scene: Scene) -> None:
    whole = cell_scene.with_values({"numerics": {}, "growth.zone.half_angle": 180.0})
    assert whole.numerics.thickness_points == 3
    whole = whole.with_values({"run.end": 10.0, "run.save": [10.0]})
    ratios = [
        simulate(whole.with_values({"numerics.thickness_points": n})).history.volume_ratio[-1]
        for n in (3, 8)
    ]
    assert ratios[0] == pytest.approx(ratios[1], rel=1e-8)


def test_too_few_points_are_said(cell_scene: Scene, tmp_path) -> None:
    scene = cell_scene.with_values({"numerics": {"thickness_points": 3}, "run.end": 5.0})
    scene = scene.with_values({"run.save": [5.0]})
    with Job(tmp_path, scene) as job:
        job.run()
    summary = read_summary(tmp_path)
    (warning,) = summary.warnings
    assert "more than the tolerance 0.001" in warning
    assert warning.endswith("increase numerics.thickness_points")
    assert summary.error_estimate.thickness_points == pytest.approx(0.062 / 9, rel=1e-6)


def test_conical_elements_are_as_many_as_the_tolerance_asks(cell_scene: Scene) -> None:
    """Their own limit is 1.26052 at 85 min with five points: 960 elements of degree 1."""
    scene = cell_scene.with_values(
        {"turgor.ramp": 0, "run": {"end": 85}, "numerics": {"geometry": "conical"}}
    )
    found = simulate(scene).history.volume_ratio[-1]
    assert found == pytest.approx(1.26052, rel=1e-3)


def test_external_pressure_beyond_the_limit_has_its_name(cell_scene: Scene) -> None:
    scene = cell_scene.with_values({"turgor.pressure": -1.0, "run": {"end": 10}, "numerics": {}})
    result = simulate(scene)
    assert result.status == "no-equilibrium"
    assert "limit pressure exceeded" in result.message and "external" in result.message
    assert result.warnings == ()
