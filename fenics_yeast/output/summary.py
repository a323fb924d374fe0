"""The summary of a run, `run.json`: the only place that writes and reads it."""

import json
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self, get_args

import numpy as np

from ..simulation import Bifurcation, ErrorBars, ErrorEstimate, Result, Status, Timings
from .errors import OutputError
from .files import RUN


@dataclass(frozen=True)
class Summary:
    """How a run ended and what it took: the file's names, in its order, as in `Result`.

    `timings` are those of the whole command, `versions` those of the software by name.
    """

    status: Status
    end_time_min: float
    message: str
    versions: Mapping[str, str]
    dofs: int
    steps: int
    rejected_steps: int
    newton_iterations: int
    timings: Timings
    error_estimate: ErrorEstimate | None = None
    bifurcation: Bifurcation | None = None
    warnings: tuple[str, ...] = ()
    error_bars: ErrorBars | None = None

    @classmethod
    def of(cls, result: Result, timings: Timings) -> Self:
        """Return the summary of a result that this process has computed."""
        return cls(
            status=result.status,
            end_time_min=float(result.end_time),
            message=result.message,
            versions=_versions(),
            dofs=int(result.dofs),
            steps=int(result.steps),
            rejected_steps=int(result.rejected_steps),
            newton_iterations=int(result.newton_iterations),
            timings=timings,
            error_estimate=result.error_estimate,
            bifurcation=result.bifurcation,
            warnings=result.warnings,
            error_bars=result.error_bars,
        )

    def to_json(self) -> bytes:
        """Return the content of the file."""
        errors = self.error_estimate
        content = vars(self) | {
            "timings": asdict(self.timings),
            "bifurcation": self.bifurcation and asdict(self.bifurcation),
            "error_estimate": errors and asdict(errors) | {"total": errors.total},
        }
        if self.error_bars is None:
            del content["error_bars"]
        else:  # JSON has null in place of "not a number"
            content["error_bars"] = {
                name: [None if np.isnan(value) else float(value) for value in column]
                for name, column in self.error_bars.columns().items()
            } | {"message": self.error_bars.message}
        return (json.dumps(content, indent=2) + "\n").encode()


def read_summary(directory: Path) -> Summary | None:
    """Return the summary of a run; None while the run is in progress.

    Raises
    ------
    OutputError
        If the file is damaged.
    """
    path = directory / RUN
    try:
        content = json.loads(path.read_bytes())
        if content["status"] not in get_args(Status):
            raise ValueError
        content["timings"] = Timings(**content["timings"])
        if errors := content.get("error_estimate"):
            del errors["total"]  # the sum of the others
            content["error_estimate"] = ErrorEstimate(**errors)
        if bifurcation := content.get("bifurcation"):
            content["bifurcation"] = Bifurcation(**bifurcation)
        content["warnings"] = tuple(content.get("warnings", ()))
        if "error_bars" in content:
            content["error_bars"] = _error_bars(content["error_bars"])
        return Summary(**content)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise OutputError(f"{path}: damaged; rerun the scene") from None


def _error_bars(content: dict[str, Any]) -> ErrorBars:
    columns = {
        name: np.array(column, dtype=float)
        for name, column in content.items()
        if name not in ("total", "message")  # the total is the sum of the others
    }
    return ErrorBars(**columns, message=content["message"])


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    import dolfinx
    from petsc4py import PETSc

    return {
        "fenics_yeast": version("fenics-yeast"),
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
