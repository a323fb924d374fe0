"""What to simulate: the typed tables of a scene file, their units, and the errors in them.

A scene is validated once and frozen; inside it every quantity is a number in µm, MPa and min.
"""

from .cell import Cell
from .errors import SceneError, value_text
from .fit_file import FitProblem, Varied
from .growth import Growth, Polarity
from .keys import fields_of, flatten, keys_of, parse_assignment, parse_value, unit_symbol, value_of
from .loads import Load, PressureTable, Septum, Turgor
from .measured_curve import MeasuredCurve
from .measured_outline import MeasuredOutlines, Outline
from .numerics import PRESETS, Geometry, Grading, Integrator, Numerics, Preset
from .precision import SHARES, Meridian, estimate_errors
from .profile_cell import ProfileCell
from .run import Control, Run, StaticPath, Until
from .scene import Scene
from .text_file import read_text
from .units import Unit
from .unloaded import Unloaded
from .wall import AnyWall, LinearWall, OgdenWall, Wall, WallZone
from .zone import Zone

__all__ = [
    "PRESETS", "SHARES", "AnyWall", "Cell", "Control", "FitProblem", "Geometry", "Grading",
    "Growth", "Integrator", "LinearWall", "Load", "MeasuredCurve", "MeasuredOutlines", "Meridian",
    "Numerics", "OgdenWall", "Outline", "Polarity", "Preset", "PressureTable", "ProfileCell", "Run",
    "Scene", "SceneError", "Septum", "StaticPath", "Turgor", "Unit", "Unloaded", "Until", "Varied",
    "Wall", "WallZone", "Zone", "estimate_errors", "fields_of", "flatten", "keys_of",
    "parse_assignment", "parse_value", "read_text", "unit_symbol", "value_of", "value_text",
]  # fmt: skip
