"""The summary of a run, `run.json`: the only place that writes and reads it."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self, get_args

import numpy as np

from ..simulation import ErrorBars, Result, Status, Timings
from .errors import OutputError
from .files import RUN


@dataclass(frozen=True)
class Summary:
    """How a run ended, and what it took; attributes as in `Result`.

    `timings` are those of the whole command.
    """

    status: Status
    message: str
    end_time: float
    dofs: int
    steps: int
    rejected_steps: int
    newton_iterations: int
    timings: Timings
    error_bars: ErrorBars | None = None

    @classmethod
    def of(cls, result: Result, timings: Timings) -> Self:
        """Return the summary of a result."""
        return cls(
            status=result.status,
            message=result.message,
            end_time=float(result.end_time),
            dofs=int(result.dofs),
            steps=int(result.steps),
            rejected_steps=int(result.rejected_steps),
            newton_iterations=int(result.newton_iterations),
            timings=timings,
            error_bars=result.error_bars,
        )

    def to_json(self) -> bytes:
        """Return the content of the file."""
        values: dict[str, object] = {
            "status": self.status,
            "end_time_min": self.end_time,
            "message": self.message,
            "versions": _versions(),
            "dofs": self.dofs,
            "steps": self.steps,
            "rejected_steps": self.rejected_steps,
            "newton_iterations": self.newton_iterations,
            "timings": asdict(self.timings),
        }
        if self.error_bars is not None:
            columns = {
                name: [None if np.isnan(value) else float(value) for value in column]
                for name, column in self.error_bars.columns().items()
            }  # JSON has null for "not a number"
            values["error_bars"] = {**columns, "message": self.error_bars.message}
        return (json.dumps(values, indent=2) + "\n").encode()


def read_summary(directory: Path) -> Summary | None:
    """Read the summary of a run; None while it has not ended.

    Raises
    ------
    OutputError
        If the file is damaged.
    """
    path = directory / RUN
    try:
        values = json.loads(path.read_bytes())
        if values["status"] not in get_args(Status):
            raise ValueError
        return Summary(
            status=values["status"],
            message=values["message"],
            end_time=values["end_time_min"],
            dofs=values["dofs"],
            steps=values["steps"],
            rejected_steps=values["rejected_steps"],
            newton_iterations=values["newton_iterations"],
            timings=Timings(**values["timings"]),
            error_bars=_error_bars(values.get("error_bars")),
        )
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise OutputError(f"{path}: damaged; rerun the scene") from None


def _error_bars(values: dict[str, Any] | None) -> ErrorBars | None:
    if values is None:
        return None
    columns = {
        name: np.array(column, dtype=float)
        for name, column in values.items()
        if name not in ("total", "message")
    }
    return ErrorBars(**columns, message=values["message"])


def _versions() -> dict[str, str]:
    import dolfinx
    from petsc4py import PETSc

    from .. import __version__

    return {
        "fenics_yeast": __version__,
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
