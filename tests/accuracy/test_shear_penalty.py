"""The limit of a wall without shear is approached from any penalty, without more iterations."""

from math import inf

import numpy as np
import pytest

from fenics_yeast import Scene, simulate

pytestmark = pytest.mark.slow

PENALTIES = (10.0, 1e3, 1e6, inf)


def runs(scene: Scene, values: dict[str, object]) -> tuple[np.ndarray, np.ndarray]:
    """Newton iterations, and V/V0 at the end, for each penalty."""
    counts, volumes = [], []
    for penalty in PENALTIES:
        changes = {"numerics.step": 2.0, "numerics.shear_penalty": penalty}
        result = simulate(scene.with_values(values | changes))
        assert result.status == "finished", result.message
        counts.append(result.newton_iterations)
        volumes.append(result.history.volume_ratio[-1])
    return np.array(counts), np.array(volumes)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_error_of_a_finite_penalty_is_inverse_to_it_near_the_limit_point(
    cell_scene: Scene, order: int
) -> None:
    """A minute before the limit point, the error of V/V0 is 0.012/κ."""
    values = {
        "numerics.thickness_points": 3,
        "numerics.elements": 24 if order > 1 else 160,
        "numerics.order": order,
        "run": {"end": 92.0},
    }
    counts, volumes = runs(cell_scene, values)
    assert counts.max() <= 1.1 * counts.min()
    errors = volumes[:-1] - volumes[-1]
    np.testing.assert_allclose(errors[:2] * PENALTIES[:2], 0.012, rtol=0.05)
    assert abs(errors[2]) < 1e-7


@pytest.mark.parametrize("thickness", [0.02, 0.0025])
def test_error_of_a_finite_penalty_is_negligible_for_a_thin_bud(
    cell_scene: Scene, thickness: float
) -> None:
    values = {
        "wall.thickness": thickness,
        "turgor.pressure": 0.20265 * thickness / 0.1,
        "numerics.thickness_points": 3,
        "numerics.elements": 24,
        "run": {"end": 60.0},
    }
    counts, volumes = runs(cell_scene, values)
    assert counts.max() <= 1.1 * counts.min()
    errors = np.abs(volumes[:-1] - volumes[-1])
    assert errors[0] < 1e-5 and errors[1] < 1e-7 and errors[2] < 1e-9
