"""Outlines as data: read by time, compared with computed profiles."""

import numpy as np
import pytest
from support.shapes import ellipse

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast.scene import MeasuredOutlines
from fenics_yeast.simulation import Profile, Profiles
from fenics_yeast.studies import compare_outlines, distances, outline_residuals


def write(path, r, z, shift=0.0):
    np.savetxt(path, np.column_stack([r, z + shift]), delimiter=",", header="r,z", comments="",
               fmt="%.10f")  # fmt: skip


def half(radius: float, number: int = 60) -> tuple[np.ndarray, np.ndarray]:
    return ellipse(number, radius, radius)


def profile(time: float, radius: float, nodes: int = 40) -> Profile:
    """A spherical wall of 2 µm that has grown to a radius."""
    S = np.linspace(0, 2 * np.pi, nodes)
    none = np.zeros((0, 1, 2))
    psi = S / 2
    return Profile(time, S, radius * np.sin(psi), -radius * np.cos(psi), psi, S[:0], S[:1],
                   none, none, none)  # fmt: skip


GROWN = Profiles((profile(0, 2.0), profile(30, 2.5), profile(60, 3.0)))


BUD = Scene.model_validate(
    {
        "cell": {"shape": "sphere", "diameter": 5.0},
        "wall": {"thickness": 0.1, "shear_modulus": 40.0, "ogden_exponent": 2.0},
        "turgor": {"pressure": 0.20265},
        "growth": {"zone": {"pole": "top", "half_angle": 24.0}, "threshold": 1.0, "time": 20.0},
        "run": {"end": 20.0, "save": [10.0, 20.0]},
        "numerics": {"thickness_points": 3, "elements": 30},
    }
)


# Reading --------------------------------------------------------------------------------------


def test_times_are_in_the_names_of_the_files(tmp_path):
    for name, radius in (("a_100min", 3), ("a_9min", 2), ("b-t0.5h", 2.5), ("30s_of_a", 1)):
        write(tmp_path / f"{name}.csv", *half(radius))
    found = MeasuredOutlines.read(tmp_path / "*.csv", noise=1.0).outlines
    assert [outline.time for outline in found] == [0.5, 9, 30, 100]
    assert [outline.points[:, 0].max() for outline in found] == pytest.approx(
        [1, 2, 2.5, 3], rel=1e-3
    )
    assert found[0].source == "30s_of_a.csv"


def test_times_are_given_in_the_order_of_numbers_in_names(tmp_path):
    for number in (1, 2, 10):
        write(tmp_path / f"frame{number}.csv", *half(number))
    found = MeasuredOutlines.read(tmp_path / "frame*.csv", noise=1.0, times=[0, 5, 7.5]).outlines
    assert [(outline.time, outline.source) for outline in found] == [
        (0, "frame1.csv"), (5, "frame2.csv"), (7.5, "frame10.csv")
    ]  # fmt: skip


def test_times_are_in_a_column(tmp_path):
    rows = [(t, *row) for t in (40.0, 10.0) for row in np.column_stack(half(2 + t / 10))]
    np.savetxt(tmp_path / "all.csv", rows, delimiter=",", header="time_min,r,z", comments="")
    found = MeasuredOutlines.read(tmp_path / "all.csv", noise=1.0).outlines
    assert [(outline.time, round(outline.points[:, 0].max())) for outline in found] == [
        (10, 3), (40, 6)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("names", "pattern", "times", "said"),
    [
        (["a"], "a.csv", None, "has no column time, and its name no time such as"),
        (["5min_a_6min"], "*.csv", None, "and its name no time"),
        (["a", "b"], "*.csv", [1.0], "2 files, but 1 times; give one for each"),
        ([], "*.csv", None, "no file has such a name"),
        ([], "a.csv", [0.0], "no such file"),
    ],
)
def test_outlines_without_files_or_times_are_refused(tmp_path, names, pattern, times, said):
    for name in names:
        write(tmp_path / f"{name}.csv", *half(1))
    with pytest.raises(SceneError, match=said) as caught:
        MeasuredOutlines.read(tmp_path / pattern, noise=1.0, times=times)
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)


# Comparing ------------------------------------------------------------------------------------


def data(tmp_path, radii: dict[float, float], shift: float = 0.0, **keys) -> MeasuredOutlines:
    for time, radius in radii.items():
        write(tmp_path / f"cell_{time}min.csv", *half(radius), shift)
    return MeasuredOutlines.read(tmp_path / "cell_*.csv", **{"noise": 1.0} | keys)


def test_residuals_of_spheres_are_the_differences_of_radii_over_the_noise(tmp_path):
    """Wherever the image has its origin."""
    outlines = data(tmp_path, {0: 2.1, 30: 2.5, 60: 2.8}, shift=17.0, noise=0.05)
    assert outlines.times == (0, 30, 60)
    expected = np.repeat([0.1, 0.0, -0.2], 60) / 0.05
    np.testing.assert_allclose(outline_residuals(outlines, GROWN), expected, atol=1e-4)


def test_the_clock_of_the_outlines_may_begin_before_the_run(tmp_path):
    outlines = data(tmp_path, {10: 2.0, 40: 2.5}, offset=10.0)
    assert outlines.times == (0, 30)
    np.testing.assert_allclose(outline_residuals(outlines, GROWN), 0, atol=1e-5)
    with pytest.raises(SceneError, match=r"cell_10min\.csv: 10 min is before the run begins"):
        MeasuredOutlines(outlines.outlines, offset=20.0)


def test_outlines_without_noise_are_refused(tmp_path):
    with pytest.raises(SceneError, match=r"noise = 0: expected a length > 0 \(µm\)"):
        data(tmp_path, {0: 2.0}, noise=0.0)


def test_a_time_that_was_not_saved_is_named(tmp_path):
    with pytest.raises(KeyError, match=r"no profile at 20 min; add it to run\.save"):
        outline_residuals(data(tmp_path, {20: 2.0}), GROWN)


def test_residuals_grow_continuously_beyond_the_end_of_a_run(tmp_path):
    late = [data(tmp_path / str(i), {time: 3.0}) for i, time in enumerate((60, 60.001, 80))
            if (tmp_path / str(i)).mkdir() is None]  # fmt: skip
    first, next_one, last = (abs(outline_residuals(one, GROWN)).max() for one in late)
    assert first < 1e-4 and next_one < 2e-3 and last > 5


def test_a_given_shift_is_kept(tmp_path):
    (outline,) = data(tmp_path, {30: 2.5}).outlines
    found = distances(outline, GROWN.at(30), shift=0.1)
    cosine = outline.points[:, 1] / 2.5
    np.testing.assert_allclose(found.distance, np.sqrt(2.5**2 + 0.01 + 0.5 * cosine) - 2.5,
                               atol=1e-5)  # fmt: skip
    assert found.shift == 0.1
    assert distances(outline, GROWN.at(30)).shift == pytest.approx(0, abs=1e-7)


def of_run(tmp_path, result, times=(10, 20)) -> MeasuredOutlines:
    """What a microscope would see of a run without noise."""
    for time in times:
        points = result.profiles.at(time)
        write(tmp_path / f"cell_{time}min.csv", points.r, points.z, shift=3.0)
    return MeasuredOutlines.read(tmp_path / "cell_*.csv", noise=1.0)


def test_the_outline_of_a_run_is_at_no_distance_from_it(tmp_path, bud_run):
    """Points between the nodes lie on the curve through them, poles of the bud included."""
    result, finer = bud_run
    outlines = of_run(tmp_path, finer)
    assert abs(outline_residuals(outlines, result.profiles)).max() < 1e-4


def test_a_stiffer_sphere_moves_all_residuals_alike(tmp_path):
    """By the closed form of a membrane."""
    scene = BUD.with_values(
        {"growth": None, "wall.bending": False, "run.end": 1.0, "run.save": [1.0]}
    )
    seen = simulate(scene)
    found = compare_outlines(scene, of_run(tmp_path, seen, (1,)), ["wall.shear_modulus"])
    # 1 - λ⁻⁶ = p R λ/(2 μ h), of a sphere of radius R
    stretch = seen.profiles.all[-1].r.max() / 2.5
    load = 0.20265 * 2.5 / (2 * 40.0 * 0.1)
    slope = -load * stretch / 40.0 / (6 * stretch**-7 - load)
    assert found.complete and abs(found.residuals).max() < 1e-6
    np.testing.assert_allclose(found.jacobian[:, 0], -2.5 * slope, rtol=1e-3)


@pytest.mark.slow
def test_outlines_give_the_parameters_back_that_made_them(tmp_path, bud_run):
    """Gauss-Newton by these derivatives, from values that are 5 % off."""
    outlines, names = of_run(tmp_path, bud_run[0]), ["growth.threshold", "growth.time"]
    x = np.array([1.05, 19.0])
    for _ in range(4):
        scene = BUD.with_values(dict(zip(names, x.tolist(), strict=True)))
        found = compare_outlines(scene, outlines, names)
        x = x - np.linalg.lstsq(found.jacobian, found.residuals, rcond=None)[0]
    np.testing.assert_allclose(x, [1.0, 20.0], rtol=2e-4)


@pytest.fixture(scope="module")
def bud_run():
    """A bud, and the same one on more elements."""
    return simulate(BUD), simulate(BUD.with_values({"numerics.elements": 60}))
