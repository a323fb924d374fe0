"""The unloaded shape of a turgid outline, found once for all runs in an output directory."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..scene import ProfileCell, Scene

if TYPE_CHECKING:
    from ..simulation import ResumePoint


def with_unloaded_shape(
    scene: Scene, start: ResumePoint | None, comm: Any, note: Callable[[str], None] | None
) -> tuple[Scene, str | None]:
    """Return a scene with the unloaded shape of its turgid outline, or why there is none.

    A run that is resumed keeps the shape of its checkpoint; a line about another one is passed to
    `note`. Collective.
    """
    from ..simulation import UnloadedShapeError, find_unloaded, fit_of

    if start is not None:
        earlier = Scene.from_toml(start.checkpoint.scene).cell
        if isinstance(earlier, ProfileCell) and earlier.unloaded is not None:
            scene = scene.with_values({"cell.unloaded": earlier.unloaded})
    try:
        found = find_unloaded(scene, comm)
    except UnloadedShapeError as error:
        return scene, str(error)
    fit = fit_of(found)
    if note is not None and fit is not None and found is not scene:
        distance = f"{fit.residual_distance_um:.2g} µm"
        note(f"unloaded shape found; under turgor it is within {distance} of the outline")
    return found, None
