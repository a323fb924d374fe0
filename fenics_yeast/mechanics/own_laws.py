"""Laws that a user brings: looked at when they are called, so that a slip is told in a line."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from ufl.core.expr import Expr

from .laws import Law

OwnLaw = Law | Callable[..., Any]

_SHAPES: dict[tuple[int, ...], str] = {
    (): "a scalar UFL expression is wanted, in MPa",
    (2,): "a UFL vector of two rates in 1/min is wanted, e.g. ufl.as_vector([a, b])",
}


def energy_law(law: OwnLaw) -> Law:
    """Strain energy of a user, which must give a scalar of the elastic strains.

    Parameters
    ----------
    law
        A function of the elastic logarithmic strains `(ε1^e, ε2^e)`, a UFL vector, or a `Law`
        that gives it parameters.

    Returns
    -------
    Law
        The same, whose function raises TypeError for what is no UFL expression, and ValueError
        for one of another shape or for what the function raises.
    """
    return _checked(law, "strain energy", ())


def growth_law(law: OwnLaw) -> Law:
    """Growth rate of a user: two rates at a `growth.WallPoint`; else as `energy_law`."""
    return _checked(law, "growth law", (2,))


def _checked(law: OwnLaw, kind: str, shape: tuple[int, ...]) -> Law:
    if not isinstance(law, Law):
        if not callable(law):
            raise TypeError(f"the {kind} is {_article(law)}; a function or a Law of one is wanted")
        law = Law(law)
    function = law.function
    name = f"the {kind} {getattr(function, '__name__', repr(function))}"

    @wraps(function)
    def checked(*arguments: Any, **parameters: Any) -> Any:
        try:
            value = function(*arguments, **parameters)
        except Exception as error:
            raise ValueError(f"{name} raised {type(error).__name__}: {error}") from error
        if not isinstance(value, Expr):
            raise TypeError(f"{name} returned {_article(value)}; {_SHAPES[shape]}")
        if value.ufl_shape != shape:
            raise ValueError(f"{name} returned the shape {value.ufl_shape}; {_SHAPES[shape]}")
        return value

    return Law(checked, law.parameters)


def _article(value: object) -> str:
    return "nothing (None)" if value is None else f"an object of type {type(value).__name__}"
