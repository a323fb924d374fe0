"""Fits: values that made a curve are found again, and what data cannot tell is said."""

from collections.abc import Iterator

import numpy as np
import pytest

from fenics_yeast import MeasuredCurve, Scene, SceneError, fit, simulate
from fenics_yeast.scene import FitProblem
from fenics_yeast.simulation import ShellPool, UnloadedShapeError
from fenics_yeast.studies import NoFit, Unknowns, expected, fit_model, fit_problem

BUD = Scene.from_toml("""
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.20265 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 45 }
run = { end = 80 }
numerics = { tolerance = 0.01, thickness_points = 3 }
""")
TIMES = np.arange(5.0, 81.0, 5.0)
BOTH = ("growth.threshold", "growth.time")


@pytest.fixture(scope="module")
def shells() -> Iterator[ShellPool]:
    with ShellPool() as pool:
        yield pool


def made(
    shells: ShellPool, quantity: str = "volume_ratio", shift: float = 0.0, **kept: object
) -> MeasuredCurve:
    """Return a curve of the bud itself, with times shifted; `kept` are fields of the curve."""
    scene = BUD.with_values(kept.get("set", {}))  # type: ignore[arg-type]
    column = {"radius_um": "bud_radius_um", "length_um": "pole_height_um"}.get(quantity, quantity)
    values = simulate(scene, shells=shells).history.interpolate(column, TIMES)
    return MeasuredCurve(quantity, quantity, TIMES + shift, values, 0.01, **kept)  # type: ignore[arg-type]


@pytest.mark.parametrize("quantity", ["volume_ratio", "volume_um3", "length_um", "radius_um"])
def test_a_fit_finds_what_made_a_curve(shells: ShellPool, quantity: str) -> None:
    start = {"growth.time": {"start": 70}}
    found = fit_problem(FitProblem.of(BUD, [made(shells, quantity)], start), shells=shells)
    time = found["growth.time"]
    assert time.value == pytest.approx(45, rel=1e-3)
    assert time.low < 45 < time.high and time.unit == "min" and not time.at_limit
    assert found.chi2 < 1e-3 and found.degrees_of_freedom == len(TIMES) - 1
    assert not found.warnings


def test_two_turgors_separate_what_one_does_not(shells: ShellPool) -> None:
    """Standard deviations of logarithms and correlations by another program's differences."""
    one = made(shells)
    other = made(shells, set={"turgor.pressure": 0.19})
    together = [expected(FitProblem.of(BUD, c, BOTH)) for c in ([one], [one, other])]
    deviations = [
        [np.log(each.high / each.low) / (2 * 1.96) for each in result.parameters]
        for result in together
    ]
    found = [[0.41281, 1.03013], [0.08862, 0.22648]]
    np.testing.assert_allclose(deviations, found, rtol=0.03)
    for result, correlation in zip(together, (-0.999913, -0.998454), strict=True):
        assert result.correlation[0, 1] == pytest.approx(correlation, abs=1e-4)
    first, *others = together[0].warnings
    assert first.startswith("growth.threshold and growth.time are nearly one number")
    assert 'set = { "turgor.pressure" = ... }' in first
    assert any("the data fix growth.threshold and growth.time only together" in w for w in others)
    assert any("the data hardly fix growth.time" in warning for warning in others)
    assert not any("nearly one number" in warning for warning in together[1].warnings)


def test_runs_that_burst_lead_a_search_back(shells: ShellPool) -> None:
    start = {"growth.time": {"start": 30}}
    found = fit_problem(FitProblem.of(BUD, [made(shells)], start), shells=shells)
    assert found["growth.time"].value == pytest.approx(45, rel=1e-3)


def test_order_and_units_do_not_matter(shells: ShellPool) -> None:
    curves = [made(shells, set={"turgor.pressure": 0.19}), made(shells)]
    noise = 1 + 0.01 * np.random.default_rng(3).standard_normal((2, len(TIMES)))
    curves = [
        MeasuredCurve(c.name, c.quantity, c.time_min, c.values * n, 0.01, set=c.set)
        for c, n in zip(curves, noise, strict=True)
    ]
    plain = fit_problem(FitProblem.of(BUD, curves, BOTH), shells=shells)
    tables = {"growth.time": {"start": "0.75 h"}, "growth.threshold": {"start": "1000 kPa"}}
    turned = fit_problem(FitProblem.of(BUD, curves[::-1], tables), shells=shells)
    for key in BOTH:
        for name in ("value", "low", "high"):
            assert getattr(turned[key], name) == pytest.approx(getattr(plain[key], name), rel=2e-3)
    assert turned.chi2 == pytest.approx(plain.chi2, rel=1e-5)


def test_a_free_offset_is_found(shells: ShellPool) -> None:
    curve = made(shells, shift=7.0, offset="free")
    found = fit_problem(FitProblem.of(BUD, [curve], ["growth.time"]), shells=shells)
    assert found["growth.time"].value == pytest.approx(45, rel=5e-3)
    assert found["offset of volume_ratio"].value == pytest.approx(7, abs=0.1)


def test_a_value_at_a_limit_is_marked(shells: ShellPool) -> None:
    limits = {"growth.time": {"from": 50, "to": 90, "start": 60}}
    found = fit_problem(FitProblem.of(BUD, [made(shells)], limits), shells=shells)
    assert found["growth.time"].at_limit
    assert any("growth.time is at a limit, 50 min" in warning for warning in found.warnings)


def test_an_outlier_matters_less_with_a_robust_loss(shells: ShellPool) -> None:
    curve = made(shells)
    values = np.array(curve.values)
    values[8] *= 1.2
    wrong = MeasuredCurve("outlier", curve.quantity, TIMES, values, 0.01)
    errors = []
    for loss in ("linear", "soft_l1"):
        problem = FitProblem.of(BUD, [wrong], ["growth.time"], loss=loss)
        errors.append(abs(fit_problem(problem, shells=shells)["growth.time"].value - 45))
    assert errors[1] < 0.3 * errors[0]


def test_numbers_that_only_scale_together_are_named_before_the_run(shells: ShellPool) -> None:
    keys = ["turgor.pressure", "wall.shear_modulus", "growth.threshold"]
    found = expected(FitProblem.of(BUD, [made(shells)], keys))
    assert "only their ratios can be fitted" in found.warnings[0]
    # Data say nothing of their common factor.
    assert all(one.high / one.low > 1e3 for one in found.parameters)


def test_no_fit_is_an_error(shells: ShellPool) -> None:
    limits = {"growth.time": {"from": 1, "to": 5, "start": 2}}
    with pytest.raises(NoFit, match="no run tried reaches the last measured time"):
        fit_problem(FitProblem.of(BUD, [made(shells)], limits), shells=shells)


def test_profiles_agree_with_normal_intervals_where_a_curve_fixes_a_number(
    shells: ShellPool,
) -> None:
    problem = FitProblem.of(BUD, [made(shells)], ["growth.time"])
    normal, profiled = (fit_problem(problem, profile=p, shells=shells) for p in (False, True))
    for name in ("low", "high"):
        ends = [getattr(result["growth.time"], name) for result in (normal, profiled)]
        assert ends[1] == pytest.approx(ends[0], rel=0.02)
    assert "profile" in profiled.intervals


def test_fit_is_a_function_of_the_package(shells: ShellPool) -> None:
    curve = made(shells)
    found = fit(BUD, [curve], vary={"growth.time": {"from": 20, "to": 90}}, starts=2)
    assert found["growth.time"].value == pytest.approx(45, rel=1e-3)
    assert list(found.to_frame().index) == ["growth.time"]
    with pytest.raises(SceneError, match=r"did you mean growth\.time"):
        fit(BUD, [curve], vary=["growth.tme"])


def test_values_without_an_unloaded_shape_are_like_invalid_ones(
    shells: ShellPool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lost(*_: object, **__: object) -> None:
        raise UnloadedShapeError("no unloaded shape")

    problem = FitProblem.of(BUD, [made(shells)], ["growth.time"])
    monkeypatch.setattr(fit_model, "simulate_with_derivatives", lost)
    model = fit_model.FitModel(problem, shells)
    evaluation = model.evaluate(Unknowns(problem).start)
    assert not evaluation.complete and evaluation.message == "no unloaded shape"
    assert np.isfinite(evaluation.chi2)
