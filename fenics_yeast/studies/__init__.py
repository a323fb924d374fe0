"""Many runs of a scene: sweeps over parameters, error bars, derivatives.

Cases run side by side in processes or on MPI ranks, each into a directory of its own.
"""

from typing import TYPE_CHECKING, Any

from .cases import Case, parse_variation, plan, value_label
from .execution import run_sweep
from .paired import read_paired
from .table import TABLE, CaseRow, read_table

if TYPE_CHECKING:
    from .derivatives import differences, simulate_with_derivatives
    from .error_bars import estimate_error_bars
    from .figure import draw_sweep, is_combined
    from .fit_figures import draw_fit
    from .fit_files import RunsTable, read_best, read_runs, write_fit
    from .fit_model import Evaluation, Unknowns
    from .fit_result import Estimate, FitResult, FittedCurve, NoFit, Profile
    from .fitting import expected, fit, fit_problem
    from .outlines import OutlineResiduals, compare_outlines, distances, outline_residuals

__all__ = [
    "TABLE", "Case", "CaseRow", "Estimate", "Evaluation", "FitResult", "FittedCurve", "NoFit",
    "OutlineResiduals", "Profile", "RunsTable", "Unknowns", "compare_outlines", "differences",
    "distances", "draw_fit", "draw_sweep", "estimate_error_bars", "expected", "fit",
    "fit_problem", "is_combined", "outline_residuals", "parse_variation", "plan", "read_best",
    "read_paired",
    "read_runs", "read_table", "run_sweep", "simulate_with_derivatives", "value_label",
    "write_fit",
]  # fmt: skip

# Names whose modules load dolfinx or figures.
_LATE = {
    "Estimate": "fit_result",
    "Evaluation": "fit_model",
    "FitResult": "fit_result",
    "FittedCurve": "fit_result",
    "NoFit": "fit_result",
    "OutlineResiduals": "outlines",
    "Profile": "fit_result",
    "RunsTable": "fit_files",
    "Unknowns": "fit_model",
    "compare_outlines": "outlines",
    "differences": "derivatives",
    "distances": "outlines",
    "draw_fit": "fit_figures",
    "draw_sweep": "figure",
    "is_combined": "figure",
    "estimate_error_bars": "error_bars",
    "expected": "fitting",
    "fit": "fitting",
    "fit_problem": "fitting",
    "outline_residuals": "outlines",
    "read_best": "fit_files",
    "read_runs": "fit_files",
    "simulate_with_derivatives": "derivatives",
    "write_fit": "fit_files",
}


def __getattr__(name: str) -> Any:
    if name in _LATE:
        from importlib import import_module

        return getattr(import_module(f".{_LATE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
