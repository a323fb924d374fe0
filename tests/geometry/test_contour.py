"""Traced contours: smoothed to a tolerance, or refused for what is wrong with them."""

import numpy as np
import pytest
from support.shapes import ellipse

from fenics_yeast.geometry import ContourError, read_contour, smooth_contour, spheroid

EXACT = spheroid(2.0, 3.5)


def test_a_noisy_contour_is_smoothed_to_the_stated_tolerance():
    r, z = ellipse(200)
    noise = np.random.default_rng(3).normal(scale=0.02, size=(2, 200))
    noise[0, [0, -1]] = 0
    curve = smooth_contour(tuple(r + noise[0]), tuple(z + noise[1]), 0.03)
    S = np.linspace(0, curve.length, 400)
    away = (curve.radius(S) / 2) ** 2 + (curve.height(S) / 3.5) ** 2 - 1
    assert abs(away).max() < 0.03
    assert curve.curvature(S).min() > 0.05  # an ellipse's least curvature is 0.16
    assert curve.length == pytest.approx(EXACT.length, rel=5e-3)


def test_a_contour_without_noise_is_the_curve_itself():
    curve = smooth_contour(*map(tuple, ellipse(80)), 0.0)
    S = np.linspace(0, 1, 50)
    assert curve.length == pytest.approx(EXACT.length, rel=1e-7)
    found, expected = (c.curvature(S * c.length) for c in (curve, EXACT))
    np.testing.assert_allclose(found, expected, rtol=2e-4)


SQUARE = ([0, 1, 2, 2, 2, 2, 2, 1, 0], [0, 0, 0, 1, 2, 3, 4, 4, 4])


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([p[5:] for p in ellipse(60)], "is open: its first point is 0.5"),
        ([p[:-3] for p in ellipse(60)], "is open: its last point"),
        ([p[::-1] for p in ellipse(60)], "runs from top to bottom"),
        ([np.r_[p[:20], p[40:20:-1], p[40:]] for p in ellipse(60)], "crosses itself near r = "),
        ([p[np.r_[0, np.random.default_rng(1).permutation(58) + 1, 59]] for p in ellipse(60)],
         "crosses itself"),
        ([np.r_[p[:30], [-0.3, 0.1][i], p[30:]] for i, p in enumerate(ellipse(60))],
         "meets the axis near r = -0.3"),
        ([np.interp(np.linspace(0, 8, 81), range(9), x) for x in SQUARE], "has a kink near r = 2"),
        ([p[::20] for p in ellipse(60)], "has 3 points; expected 8 to 5000"),
    ],
)  # fmt: skip
def test_what_is_no_meridian_is_refused(points, said):
    with pytest.raises(ContourError, match=said) as caught:
        smooth_contour(*map(tuple, points), 1e-3)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "no such file beside the scene"),
        ("", 'heading "r,z"'),
        ("r,z\n", "no points"),
        ("x,y\n1,2\n", 'heading "r,z"'),
        ("r,z\n0,1\n0;2\n", "line 3: expected two numbers"),
        ("r,z\n0,nan\n", "line 2: not finite"),
    ],
)
def test_files_that_are_no_contours_are_refused(tmp_path, text, said):
    path = tmp_path / "contour.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ContourError, match=said) as caught:
        read_contour(path)
    assert len(str(caught.value).splitlines()) == 1


def test_a_table_of_points_may_have_comments_and_more_columns(tmp_path):
    path = tmp_path / "contour.csv"
    path.write_text("# traced by hand\n name , Z, R\na,1,2\n\nb,3,4\n")
    assert read_contour(path) == ((2.0, 4.0), (1.0, 3.0))
