"""Values between the steps of a run."""

import numpy as np
import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import History, Row, ShellPool


def history(time: np.ndarray, values: np.ndarray, kinks: tuple[float, ...] = ()) -> History:
    rest = dict.fromkeys(Row.__dataclass_fields__, 0.0)
    rows = [Row(**rest | {"time_min": float(t), "volume_um3": float(v)})  # type: ignore[arg-type]
            for t, v in zip(time, values, strict=True)]  # fmt: skip
    return History(rows, kinks)


def broken(t: np.ndarray) -> np.ndarray:
    """Two cubic polynomials that meet at 3 min with different slopes."""
    return np.where(t < 3, t**3 - 2 * t, 21 - 5 * (t - 3) + (t - 3) ** 3)


def test_cubics_that_meet_at_a_kink_are_found_exactly() -> None:
    time = np.array([0, 0.3, 1.0, 2.2, 3.0, 3.1, 4.0, 5.0, 5.5])
    at = np.linspace(0, 5.5, 40)
    sharp = history(time, broken(time), kinks=(3.0,)).interpolate("volume_um3", at)
    np.testing.assert_allclose(sharp, broken(at), atol=1e-12)
    smoothed = history(time, broken(time)).interpolate("volume_um3", at)
    assert np.abs(smoothed - broken(at)).max() > 0.01


@pytest.mark.parametrize(("rows", "degree"), [(2, 1), (3, 2), (4, 3)])
def test_few_steps_between_kinks_lower_the_degree(rows: int, degree: int) -> None:
    time = np.linspace(0, 1, rows) ** 2
    found = history(time, time**degree).interpolate("volume_um3", [0.1, 0.7])
    np.testing.assert_allclose(found, np.array([0.1, 0.7]) ** degree, atol=1e-14)


def test_the_rows_are_interpolated_exactly_and_times_outside_are_refused() -> None:
    time = np.array([0.0, 0.0, 1.0, 3.0, 3.5, 7.0])
    some = history(time, np.exp(time))
    np.testing.assert_allclose(some.interpolate("volume_um3", time[1:]), np.exp(time[1:]))
    assert some.interpolate("volume_um3", 3.0).shape == (1,)
    for outside in (-0.1, 7.1, np.nan):
        with pytest.raises(ValueError, match="outside the run, which goes from 0 to 7 min"):
            some.interpolate("volume_um3", [1.0, outside])
    with pytest.raises(ValueError, match="no column volume; choose one of time_min"):
        some.interpolate("volume", [1.0])
    with pytest.raises(ValueError, match="no steps in time"):
        history(np.zeros(3), np.ones(3)).interpolate("volume_um3", [0.0])


def test_errors_between_steps_fall_as_fast_as_those_of_the_integrator(sphere_scene: Scene) -> None:
    """Steps of third order, turgor with a kink at 3.2 min; the rate is 2.9 at the least."""
    kinked = {"turgor.pressure": {"time": [0, 3.2], "value": [0.15, 0.2]}, "run.end": 6.4}
    scene, at = sphere_scene.with_values(kinked), np.linspace(0.05, 6.35, 97)
    with ShellPool() as shells:
        curves = [
            simulate(scene.with_values({"numerics.step": step}), shells=shells).history
            .interpolate("volume_ratio", at)
            for step in (0.8, 0.4, 0.2, 0.05)
        ]  # fmt: skip
    errors = [np.abs(curve - curves[-1]).max() for curve in curves[:-1]]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 2.9, (errors, rates)
    assert errors[-1] < 1e-5
