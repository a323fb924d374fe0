"""Traced contours: smoothed to a tolerance, or refused for what is wrong with them."""

import numpy as np
import pytest
from support.shapes import ellipse

from fenics_yeast.geometry import ContourError, describe_smoothing, smooth_contour, spheroid

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


# With an edge ---------------------------------------------------------------------------------

CUT = tuple(tuple(x[20:].tolist()) for x in ellipse(90))  # its lower part is missing


def test_an_open_contour_is_the_curve_itself_up_to_its_edge():
    curve = smooth_contour(*CUT, 0.0, edge=True)
    S = np.linspace(0, curve.length, 200)
    whole = EXACT.length - curve.length + S
    assert curve.radius(np.zeros(1))[0] == pytest.approx(CUT[0][0], abs=1e-9)
    np.testing.assert_allclose(curve.radius(S), EXACT.radius(whole), atol=2e-6)
    np.testing.assert_allclose(curve.curvature(S), EXACT.curvature(whole), rtol=2e-3)


def test_an_open_contour_keeps_its_volume():
    z = CUT[1][0]
    exact = 2.0**2 * (2 / 3 * 3.5 - z + z**3 / (3 * 3.5**2))  # over π, above the plane of the edge
    curve = smooth_contour(*CUT, 0.0, edge=True)
    t = np.linspace(0, curve.end, 4001)
    discs = curve.point(t, 0)[0] ** 2 * curve.point(t, 1)[1]
    assert (discs[1:] + discs[:-1]).sum() / 2 * t[1] == pytest.approx(exact, rel=1e-6)
    assert abs(describe_smoothing(*CUT, 0.0, edge=True).volume_change) < 1e-6


def test_noise_of_an_open_contour_is_that_of_its_points():
    noise = 0.01 * np.random.default_rng(4).normal(size=(2, len(CUT[0])))
    noise[0, -1] = 0
    r, z = (tuple((x + e).tolist()) for x, e in zip(CUT, noise, strict=True))
    assert describe_smoothing(r, z, edge=True).tolerance == pytest.approx(0.02, rel=0.5)


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (ellipse(60), "is closed: its first point is on the axis; remove cell.edge"),
        ([p[5:-3] for p in ellipse(60)], "is open: its last point .* its top must be at r = 0"),
    ],
)
def test_an_edge_where_there_is_none_is_refused(points, said):
    with pytest.raises(ContourError, match=said):
        smooth_contour(*map(tuple, points), 1e-3, edge=True)


# By default, the data's own noise ---------------------------------------------------------------

PIXEL = 0.065


def staircase() -> tuple[np.ndarray, np.ndarray]:
    """The ellipse as a segmentation of an image gives it, in whole pixels."""
    z = np.arange(-3.5, 3.5 + PIXEL / 2, PIXEL)
    r = np.round(2.0 * np.sqrt(np.maximum(0, 1 - (z / 3.5) ** 2)) / PIXEL) * PIXEL
    keep = r > 0
    return np.r_[0, r[keep], 0], np.r_[-3.5, z[keep], 3.5]


def white(deviation: float, number: int = 120) -> tuple[np.ndarray, np.ndarray]:
    r, z = ellipse(number)
    noise = np.random.default_rng(3).normal(scale=deviation, size=(2, number))
    noise[0, [0, -1]] = 0
    return r + noise[0], z + noise[1]


def hoop(curve, at):
    """Membrane hoop stress over pressure, times the thickness: R2 (1 - κ1 R2 / 2)."""
    S = at * curve.length
    R2 = curve.radius(S) / np.sin(curve.angle(S))
    return R2 * (1 - curve.curvature(S) * R2 / 2)


@pytest.mark.parametrize(
    ("points", "error"),
    [(staircase(), 0.15), (white(0.003), 0.04), (white(0.02), 0.1), (white(0.02, 240), 0.15)],
    ids=["pixels", "white", "more noise", "more points"],
)
def test_the_default_tolerance_keeps_noise_out_of_the_stress(points, error):
    """Without smoothing, the same stress is wrong by its own size; the report says how much."""
    r, z = map(tuple, points)
    curve, report = smooth_contour(r, z), describe_smoothing(r, z)
    at = np.linspace(0.01, 0.99, 300)
    expected = hoop(EXACT, at)
    found = abs(hoop(curve, at) - expected).max() / expected.max()
    assert found < error
    assert found / 2 < report.stress_error < 4 * found
    # The ellipse has 4/3 π 2² 3.5 µm³.
    t = np.linspace(0, curve.length, 4001)
    radius, height = curve.radius(t), curve.height(t)
    volume = np.pi * np.sum((radius[1:] + radius[:-1]) ** 2 / 4 * np.diff(height))
    assert volume == pytest.approx(4 / 3 * np.pi * 2**2 * 3.5, rel=0.01)


def test_points_without_noise_are_interpolated_by_default():
    r, z = map(tuple, ellipse(80))
    report = describe_smoothing(r, z)
    assert report.tolerance < 1e-5
    assert report.stress_error < 1e-3
    # Compared with a smooth curve: chords would leave out 1/4 (π/79)² = 4e-4 of the volume.
    assert abs(report.volume_change) < 1e-6


def test_a_contour_that_cannot_be_smoothed_is_refused_by_default_too():
    points = [np.interp(np.linspace(0, 8, 81), range(9), x) for x in SQUARE]
    with pytest.raises(ContourError, match="has a kink"):
        smooth_contour(*map(tuple, points))
