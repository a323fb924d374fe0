"""The paper in UFL: kinematics, hyperelasticity, growth laws, and the forms of the shell.

Knows neither scenes nor solvers. A law is one UFL function; its derivatives come from UFL.
"""

from __future__ import annotations

from .growth_laws import WallPoint
from .growth_state import GrowthState
from .growth_weights import Gaussian, Weight, Weights
from .laws import Law, Parameter
from .ordering import Ordering, PointValues, Unknowns
from .own_laws import OwnLaw
from .shell import Shell, ShellState

__all__ = [
    "Gaussian",
    "GrowthState",
    "Law",
    "Ordering",
    "OwnLaw",
    "Parameter",
    "PointValues",
    "Shell",
    "ShellState",
    "Unknowns",
    "WallPoint",
    "Weight",
    "Weights",
]
