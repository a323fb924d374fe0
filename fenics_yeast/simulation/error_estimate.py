"""The estimated error of V/V0 of a run, and the warning where it exceeds the tolerance."""

from ..scene import Scene, estimate_errors
from .result import ErrorEstimate

_FAST = 0.7  # V'/V times the characteristic growth time up to which errors a priori are bounds

_REMEDIES = {
    "steps": "reduce numerics.tolerance",
    "mesh": "increase numerics.elements",
    "thickness_points": "increase numerics.thickness_points",
    "shear_penalty": "increase numerics.shear_penalty",
}


def estimate_error(scene: Scene, step_error: float, speed: float) -> ErrorEstimate:
    """Return the estimated relative error of V/V0 at the saved times.

    Mesh, integration points and shear penalty have errors known from growing buds. Like those of
    the steps, they are shifts in time: towards bursting they grow with the speed of the cell.

    Parameters
    ----------
    scene
        The scene as run.
    step_error
        Largest relative error of V/V0 by the time steps.
    speed
        Largest `V'/V` in 1/min.
    """
    amplified = max(1.0, speed * (scene.growth_time or 0.0) / _FAST)
    known = estimate_errors(scene.numerics, scene.meridian)
    return ErrorEstimate(steps=step_error, **{key: amplified * e for key, e in known.items()})


def tolerance_warning(scene: Scene, estimate: ErrorEstimate) -> str | None:
    """Return a warning if the estimate exceeds a tolerance that governs the numerics."""
    numerics = scene.numerics
    if numerics.preset != "default" or estimate.total <= numerics.tolerance:
        return None
    parts = vars(estimate)
    worst = max(parts, key=lambda part: parts[part])
    remedy = _REMEDIES[worst]
    return (
        f"V/V0 may be wrong by {estimate.total:.1e}, more than the tolerance "
        f"{numerics.tolerance:g}; the largest part is due to the {worst.replace('_', ' ')}: "
        f"{remedy}"
    )
