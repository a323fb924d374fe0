"""Step sizes: formula, limits and state of the controller; the predictor."""

import numpy as np
import pytest

from fenics_yeast.solve import StepController, same_time
from fenics_yeast.solve.predictor import extrapolate


def adaptive() -> StepController:
    controller = StepController([1000.0], 1.0, 3)
    controller.propose(0.0)
    return controller


def next_size(controller: StepController, time: float = 0.0) -> float:
    """Size of the next of the equal steps to the milestone, which is close to the wanted one."""
    end = controller.propose(time)
    assert end is not None
    return end - time


def test_next_step_follows_the_proportional_integral_formula() -> None:
    controller = adaptive()
    assert controller.accepts(0.5)
    assert next_size(controller) == pytest.approx(0.9 * 0.5 ** (-0.7 / 3), rel=2e-3)
    taken = next_size(controller)
    assert controller.accepts(0.8)
    expected = 0.9 * taken * 0.8 ** (-0.7 / 3) * 0.5 ** (0.4 / 3)
    assert next_size(controller) == pytest.approx(expected, rel=2e-3)


def test_step_grows_by_a_factor_of_four_at_most() -> None:
    controller = adaptive()
    assert controller.accepts(0.0)
    assert next_size(controller) == pytest.approx(4, rel=5e-3)


def test_step_with_too_large_an_error_is_rejected_and_reduced() -> None:
    controller = adaptive()
    assert not controller.accepts(2.0)
    assert next_size(controller) == pytest.approx(0.9 * 2 ** (-1 / 3), rel=2e-3)
    assert not controller.accepts(1e9)
    assert next_size(controller) == pytest.approx(0.1 * 0.9 * 2 ** (-1 / 3), rel=2e-3)


def test_failed_fixed_step_is_halved_and_returns_to_its_size() -> None:
    controller = StepController([10.0], 1.0, None)
    controller.propose(0.0)
    controller.failed()
    assert (controller.failures, controller.reductions) == (1, 1)
    assert next_size(controller) == 0.5
    assert controller.accepts(0.0)
    assert (controller.failures, controller.reductions) == (0, 1)
    assert next_size(controller) == 1


def test_controller_is_exhausted_after_many_failures() -> None:
    controller = adaptive()
    for _ in range(20):
        assert not controller.exhausted
        controller.propose(0.0)
        controller.failed()
    controller.propose(0.0)
    controller.failed()
    assert controller.exhausted


def test_restored_controller_proposes_the_same_steps() -> None:
    one, other = adaptive(), adaptive()
    one.accepts(0.3)
    one.propose(1.0)
    one.failed()
    other.restore(one.state())
    assert other.state() == one.state()
    assert one.propose(1.0) == other.propose(1.0)
    assert one.accepts(0.2) and other.accepts(0.2)
    assert one.propose(2.0) == other.propose(2.0)


def test_no_step_is_proposed_at_the_end() -> None:
    end = 0.1 + 0.2
    assert same_time(end, 0.3)
    assert StepController([0.3], 1.0, None).propose(end) is None


def test_predictor_reproduces_polynomials() -> None:
    times = (0.0, 0.3, 1.0, 1.7)
    solutions = [(t, np.array([t**3 - t, 2.0])) for t in times]
    np.testing.assert_allclose(extrapolate(solutions, 2.5), [2.5**3 - 2.5, 2.0], rtol=1e-12)
