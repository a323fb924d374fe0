"""A material law with its parameters, which become coefficients of the compiled forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .growth_weights import Weights

Array = NDArray[np.float64]

Parameter = float | Callable[[Array], Array] | Weights


@dataclass(frozen=True)
class Law:
    """A UFL function and values for its named parameters; other values compile nothing anew.

    Attributes
    ----------
    function
        Strain energy, a function of the elastic strains (see `wall`), or growth rate, a function
        of a `growth.WallPoint`; it takes the parameters by name after that.
    parameters
        Their values, in µm, MPa and min: a number, a function of the reference arc length in µm
        (arrays of one shape in and out), or, of a growth rate, weights that change in time.
    """

    function: Callable[..., Any]
    parameters: Mapping[str, Parameter] = field(default_factory=dict)

    def on(self, coefficient: Callable[[Parameter], Any]) -> Callable[[Any], Any]:
        """The function with its parameters as coefficients of a wall."""
        values = {name: coefficient(value) for name, value in self.parameters.items()}
        return lambda argument: self.function(argument, **values)
