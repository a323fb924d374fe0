"""A scene on its way to a result: builds the shell, runs it in time or along a path, records it.

The only room that knows both scenes and the shell. What loads dolfinx is imported when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .discretise import discretise
from .observers import Observers
from .result import (
    COLUMNS,
    ErrorBars,
    History,
    Observer,
    Profile,
    Profiles,
    Result,
    Row,
    Status,
    Timings,
)
from .separation import pieces

if TYPE_CHECKING:
    from .checkpoint import Checkpoint, CheckpointError, Start
    from .recorder import ObserverError
    from .simulation import Simulation, build_shell, simulate

__all__ = [
    "COLUMNS",
    "Checkpoint",
    "CheckpointError",
    "ErrorBars",
    "History",
    "Observer",
    "ObserverError",
    "Observers",
    "Profile",
    "Profiles",
    "Result",
    "Row",
    "Simulation",
    "Start",
    "Status",
    "Timings",
    "build_shell",
    "discretise",
    "pieces",
    "simulate",
]

# What loads dolfinx, by the module that holds it.
_LATE = {
    "Checkpoint": "checkpoint",
    "CheckpointError": "checkpoint",
    "ObserverError": "recorder",
    "Simulation": "simulation",
    "Start": "checkpoint",
    "build_shell": "simulation",
    "simulate": "simulation",
}


def __getattr__(name: str) -> Any:
    if name in _LATE:
        from importlib import import_module

        return getattr(import_module(f".{_LATE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
