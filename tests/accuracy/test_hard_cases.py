"""Hard cases: each ends in its reference value or in a message that names the physics."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "demos"))
import hard_cases as table

pytestmark = pytest.mark.slow

CASES = table.hard_cases()


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_hard_case_has_its_status_and_value(case) -> None:
    found = case.run()
    assert found.status == case.status, found.message
    assert found.value == pytest.approx(case.reference, rel=0, abs=case.tolerance)
    assert case.says in found.message


def test_hard_cases_are_many_and_have_different_names() -> None:
    names = {case.name for case in CASES}
    assert len(names) == len(CASES) >= 40


def test_error_against_the_membrane_falls_with_the_square_of_the_thickness() -> None:
    """No locking: the error falls with the square of h/R."""
    errors = [
        abs(table.membrane_error(ratio)().value - table.inflated(table.P))
        for ratio in (1 / 5, 1 / 25, 1 / 125)
    ]
    assert 20 < errors[0] / errors[1] < 30
    assert 20 < errors[1] / errors[2] < 30
