"""What a run found beside its history: its first bifurcation, and what must be known of it."""

from collections.abc import Iterator

from ..scene import ProfileCell, Scene
from .error_estimate import tolerance_warning
from .outcome import Outcome, contact_warning, smoothing_warning
from .recorder import Recorder
from .result import Bifurcation, ErrorEstimate

_NOTABLE = 0.01  # stress error by smoothing a contour


def first_bifurcation(scene: Scene, recorder: Recorder) -> Bifurcation | None:
    """Return the first bifurcation that a run has passed."""
    if not recorder.bifurcation:
        return None
    step, waves = recorder.bifurcation
    if not recorder.rows[step].stable:
        return None  # the first state is unstable already
    control = "time" if scene.path is None else scene.path.control
    return Bifurcation.at(recorder.rows[step], step, waves, control)


def warnings(
    scene: Scene, recorder: Recorder, outcome: Outcome | None, estimate: ErrorEstimate
) -> Iterator[str]:
    """Yield what must be known of a run even if it ended well."""
    finished = outcome is not None and outcome.status == "finished"
    inaccurate = tolerance_warning(scene, estimate)
    if finished and inaccurate is not None:  # V/V0 has no error where it becomes infinite
        yield inaccurate
    cell = scene.cell
    if isinstance(cell, ProfileCell) and cell.smoothing.stress_error > _NOTABLE:
        yield smoothing_warning(cell.smoothing)
    contact = recorder.contact
    if contact is not None:
        table, row = "run" if scene.path is None else "path", recorder.rows[contact]
        span = scene.path or scene.run
        if span is None or not span.stop_at_contact:
            yield contact_warning(row, table)
