"""The paper in UFL: kinematics, hyperelasticity, growth laws, and the forms of the shell.

Knows neither scenes nor solvers. A law is one UFL function; its derivatives come from UFL.
"""

from . import growth_laws, hyperelasticity
from .circumferential import SecondVariation
from .growth_laws import WallPoint
from .growth_state import GrowthState
from .growth_weights import Gaussian, Weight
from .laws import Coefficient, Law, OwnLaw, Parameter, own_energy, own_growth_law
from .ordering import DofValues, Order, Ordering, PointValues
from .quadrature import QuadraturePoints
from .section import Approximation, WallProperties, coefficients
from .shell import Shell, ShellState
from .structure import structure_of
from .thickness_rule import thickness_rule

__all__ = [
    "Approximation", "Coefficient", "DofValues", "Gaussian", "GrowthState", "Law", "Order",
    "Ordering", "OwnLaw", "Parameter", "PointValues", "QuadraturePoints", "SecondVariation",
    "Shell", "ShellState", "WallPoint", "WallProperties", "Weight", "coefficients",
    "growth_laws", "hyperelasticity", "own_energy", "own_growth_law", "structure_of",
    "thickness_rule",
]  # fmt: skip
