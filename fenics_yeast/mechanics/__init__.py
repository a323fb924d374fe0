"""The paper in UFL: kinematics, hyperelasticity, growth laws, and the forms of the shell.

Knows neither scenes nor solvers. A law is one UFL function; its derivatives come from UFL.
"""

from __future__ import annotations

from . import growth_laws, hyperelasticity
from .gather import Order
from .growth_laws import WallPoint
from .growth_state import GrowthState
from .growth_weights import Gaussian, Weight, Weights
from .laws import Law, OwnLaw, Parameter, own_energy, own_growth_law
from .ordering import DofValues, Ordering, PointValues
from .shell import Approximation, Shell, ShellState, WallProperties

__all__ = [
    "Approximation",
    "DofValues",
    "Gaussian",
    "GrowthState",
    "Law",
    "Order",
    "Ordering",
    "OwnLaw",
    "Parameter",
    "PointValues",
    "Shell",
    "ShellState",
    "WallPoint",
    "WallProperties",
    "Weight",
    "Weights",
    "growth_laws",
    "hyperelasticity",
    "own_energy",
    "own_growth_law",
]
