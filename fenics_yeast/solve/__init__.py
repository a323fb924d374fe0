"""Equilibrium and time: Newton's method, continuation, stability and time stepping of a shell.

Knows no scene: it gets a shell, loads as numbers or functions, and tolerances.
"""

from __future__ import annotations

from .equilibrium import Equilibrium, EquilibriumError, Tangent
from .limit_points import Approach, approach
from .path_following import Goal, PathError, Plane, follow, limit_point
from .runge_kutta import TABLEAUX, Tableau
from .stability import Count, Stability
from .step_control import Controller, TimeSteps, same_time
from .time_stepper import Evolution, Memory, Step

__all__ = [
    "TABLEAUX",
    "Approach",
    "Controller",
    "Count",
    "Equilibrium",
    "EquilibriumError",
    "Evolution",
    "Goal",
    "Memory",
    "PathError",
    "Plane",
    "Stability",
    "Step",
    "Tableau",
    "Tangent",
    "TimeSteps",
    "approach",
    "follow",
    "limit_point",
    "same_time",
]
