"""Equilibrium and time: Newton's method, continuation, stability and time stepping of a shell.

Knows no scene: it works on a shell, loads as numbers or functions, and tolerances.
"""

from .continuation import BorderedNewton
from .equilibrium import ChordState, Equilibrium, EquilibriumError
from .limit_points import approach_limit_point, find_limit_force, find_limit_pressure
from .outline_inversion import InverseShape, InversionError, OutlineInversion
from .path_following import PathCoordinates, PathError, PathTarget, follow_path
from .resumable import Resumable
from .runge_kutta import TABLEAUX, ButcherTableau
from .sensitivities import Direction, ForwardSensitivities
from .stability import Stability, StabilityState
from .step_control import ControllerState, GivenSteps, StepController, same_time
from .time_stepper import Follower, StepperState, StepResult, TimeStepper
from .waves import WaveModes

__all__ = [
    "TABLEAUX",
    "BorderedNewton",
    "ButcherTableau",
    "ChordState",
    "ControllerState",
    "Direction",
    "Equilibrium",
    "EquilibriumError",
    "Follower",
    "ForwardSensitivities",
    "GivenSteps",
    "InverseShape",
    "InversionError",
    "OutlineInversion",
    "PathCoordinates",
    "PathError",
    "PathTarget",
    "Resumable",
    "Stability",
    "StabilityState",
    "StepController",
    "StepResult",
    "StepperState",
    "TimeStepper",
    "WaveModes",
    "approach_limit_point",
    "find_limit_force",
    "find_limit_pressure",
    "follow_path",
    "same_time",
]  # fmt: skip
