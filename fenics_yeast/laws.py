"""A material law with its parameters, which become constants of the compiled forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _dolfinx as dx


@dataclass(frozen=True)
class Law:
    """A UFL function and values for its named parameters; other values compile nothing anew.

    Attributes
    ----------
    function
        Strain energy, a function of the elastic strains (see `wall`), or growth rate, a function
        of a `growth.WallPoint`; it takes the parameters by name after that.
    parameters
        Their values, in µm, MPa and min.
    """

    function: Callable[..., Any]
    parameters: Mapping[str, float] = field(default_factory=dict)

    def on(self, mesh: Any) -> Callable[[Any], Any]:
        """The function with its parameters as constants on a mesh."""
        constants = {
            name: dx.fem.Constant(mesh, np.float64(value))
            for name, value in self.parameters.items()
        }
        return lambda argument: self.function(argument, **constants)
