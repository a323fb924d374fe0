"""The paper in UFL: kinematics, hyperelasticity, growth laws, and the forms of the shell.

Knows neither scenes nor solvers. A law is one UFL function; its derivatives come from UFL.
"""

from __future__ import annotations

from .growth_laws import WallPoint
from .growth_state import GrowthState
from .growth_weights import Bump, Weight, Weights
from .laws import Law, Parameter
from .ordering import Layout, PointValues, Unknowns
from .own_laws import OwnLaw
from .shell import Shell, Snapshot

__all__ = [
    "Bump",
    "GrowthState",
    "Law",
    "Layout",
    "OwnLaw",
    "Parameter",
    "PointValues",
    "Shell",
    "Snapshot",
    "Unknowns",
    "WallPoint",
    "Weight",
    "Weights",
]
