"""A scene on its way to a result: builds the shell, runs it in time or along a path, records it.

The only room that knows both scenes and the shell. What loads dolfinx is imported when first used.
"""

from typing import TYPE_CHECKING, Any

from .buckling_mode import BucklingMode
from .discretise import discretise
from .history import COLUMNS, Digest, History, Row
from .interpolation import interpolate
from .kinks import kinks
from .observers import Observers
from .profiles import Profile, Profiles
from .ranks import RootError, on_root
from .replay import Replay
from .result import (
    ANSWERS,
    EXIT_STATUS,
    Bifurcation,
    ErrorBars,
    ErrorEstimate,
    Observer,
    Result,
    Status,
    Timings,
)
from .sensitivities import Sensitivities
from .separation import pieces

if TYPE_CHECKING:
    from .buckling import buckling_modes
    from .build import build_shell
    from .checkpoint import Checkpoint, CheckpointError, ResumePoint
    from .directions import has_exact_sensitivity
    from .shell_pool import ShellPool
    from .simulation import Simulation, simulate

__all__ = [
    "ANSWERS", "COLUMNS", "EXIT_STATUS", "Bifurcation", "BucklingMode", "Checkpoint",
    "CheckpointError", "Digest", "ErrorBars", "ErrorEstimate", "History", "Observer",
    "Observers", "Profile", "Profiles", "Replay", "Result", "ResumePoint", "RootError", "Row",
    "Sensitivities", "ShellPool", "Simulation", "Status", "Timings", "buckling_modes",
    "build_shell", "discretise", "has_exact_sensitivity", "interpolate", "kinks", "on_root",
    "pieces", "simulate",
]  # fmt: skip

# What loads dolfinx, by the module that holds it.
_LATE = {
    "buckling_modes": "buckling",
    "Checkpoint": "checkpoint",
    "CheckpointError": "checkpoint",
    "Simulation": "simulation",
    "ResumePoint": "checkpoint",
    "ShellPool": "shell_pool",
    "build_shell": "build",
    "has_exact_sensitivity": "directions",
    "simulate": "simulation",
}


def __getattr__(name: str) -> Any:
    if name in _LATE:
        from importlib import import_module

        return getattr(import_module(f".{_LATE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
