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
    from .figure import draw_sweep
    from .outlines import OutlineResiduals, compare_outlines, distances, outline_residuals

__all__ = [
    "TABLE", "Case", "CaseRow", "OutlineResiduals", "compare_outlines", "differences",
    "distances", "draw_sweep", "estimate_error_bars", "outline_residuals", "parse_variation",
    "plan", "read_paired", "read_table", "run_sweep", "simulate_with_derivatives", "value_label",
]  # fmt: skip

# Names whose modules load dolfinx or figures.
_LATE = {
    "OutlineResiduals": "outlines",
    "compare_outlines": "outlines",
    "differences": "derivatives",
    "distances": "outlines",
    "draw_sweep": "figure",
    "estimate_error_bars": "error_bars",
    "outline_residuals": "outlines",
    "simulate_with_derivatives": "derivatives",
}


def __getattr__(name: str) -> Any:
    if name in _LATE:
        from importlib import import_module

        return getattr(import_module(f".{_LATE[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
