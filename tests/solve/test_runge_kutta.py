"""Butcher tableaux: order conditions of the solutions and of their error estimates."""

import numpy as np
import pytest

from fenics_yeast.solve import TABLEAUX


@pytest.mark.parametrize("tableau", TABLEAUX.values(), ids=list(TABLEAUX))
def test_weights_satisfy_the_conditions_of_their_order(tableau) -> None:
    """Those of quadrature and, from the third order on, of the tree with two levels."""
    A, b, c = tableau.A, tableau.b, tableau.c
    for q in range(1, tableau.order + 1):
        assert b @ c ** (q - 1) == pytest.approx(1 / q, abs=1e-13)
    if tableau.order >= 3:
        assert b @ A @ c == pytest.approx(1 / 6, abs=1e-13)


@pytest.mark.parametrize(
    ("name", "order"), [("forward-euler", 2), ("backward-euler", 2), ("sdirk2", 1), ("sdirk3", 2)]
)
def test_embedded_weights_have_another_order(name: str, order: int) -> None:
    tableau = TABLEAUX[name]
    moments = [tableau.embedded @ tableau.c ** (q - 1) - 1 / q for q in (1, 2, 3)]
    np.testing.assert_allclose(moments[:order], 0, atol=1e-13)
    assert abs(moments[order]) > 0.01


@pytest.mark.parametrize("tableau", TABLEAUX.values(), ids=list(TABLEAUX))
def test_last_stage_is_the_end_of_the_step(tableau) -> None:
    assert tableau.is_stiffly_accurate
    assert tableau.c[-1] == pytest.approx(1, abs=1e-13)
    np.testing.assert_array_equal(tableau.A, np.tril(tableau.A))


def test_only_forward_euler_is_explicit() -> None:
    assert [name for name, tableau in TABLEAUX.items() if tableau.is_explicit] == ["forward-euler"]
