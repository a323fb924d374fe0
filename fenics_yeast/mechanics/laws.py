"""Material laws with parameters, which become coefficients of the compiled forms."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import wraps
from typing import Any

from ufl.core.expr import Expr

from ..geometry import Array
from .growth_weights import Weights

Coefficient = float | Callable[[Array], Array]
"""A number, or a function of the reference arc length in µm (arrays of one shape in and out)."""
Parameter = Coefficient | Weights
"""A coefficient of the forms, or weights that change in time."""


@dataclass(frozen=True)
class Law:
    """A UFL function and values of its named parameters; new values need no recompilation.

    Attributes
    ----------
    function
        Strain energy, a function of the elastic strains (see `hyperelasticity`), or growth rate,
        a function of a `WallPoint` (see `growth_laws`); further arguments are its parameters.
    parameters
        Their values in µm, MPa and min; weights only in a growth rate.
    """

    function: Callable[..., Any]
    parameters: Mapping[str, Parameter] = field(default_factory=dict)

    @property
    def weights(self) -> dict[str, Weights]:
        """The parameters that are weights."""
        return {name: x for name, x in self.parameters.items() if isinstance(x, tuple)}


OwnLaw = Law | Callable[..., Any]
"""A user's own law: a UFL function, or a `Law` that gives it parameters."""

_EXPECTED: dict[tuple[int, ...], str] = {
    (): "expected a scalar UFL expression in MPa",
    (2,): "expected a UFL vector of two rates in 1/min, e.g. ufl.as_vector([a, b])",
}


def own_energy(law: OwnLaw) -> Law:
    """Return a user's strain energy as a law that checks what the function returns.

    Raises
    ------
    TypeError
        If it is not a function or, later, if it does not return a UFL expression.
    ValueError
        If, later, the function raises an error or returns an expression of the wrong shape.
    """
    return _checked(law, "strain energy", ())


def own_growth_law(law: OwnLaw) -> Law:
    """Return a user's growth rate as a law that checks its result, like `own_energy`."""
    return _checked(law, "growth law", (2,))


def _checked(law: OwnLaw, kind: str, shape: tuple[int, ...]) -> Law:
    if not isinstance(law, Law):
        if not callable(law):
            raise TypeError(f"the {kind} is {_article(law)}; expected a function or a Law")
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
            raise TypeError(f"{name} returned {_article(value)}; {_EXPECTED[shape]}")
        if value.ufl_shape != shape:
            raise ValueError(f"{name} returned the shape {value.ufl_shape}; {_EXPECTED[shape]}")
        return value

    return Law(checked, law.parameters)


def _article(value: object) -> str:
    return "nothing (None)" if value is None else f"an object of type {type(value).__name__}"
