"""Times at which steps must end: kinks of the pressure, switches of growth, saved times."""

from bisect import bisect_left
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..scene import Scene
from ..solve import GivenSteps, StepController, same_time
from .kinks import kinks

_FIRST_STEP = 1e-3  # of the characteristic growth time, where steps are adaptive
_PARTS = 4  # of a change of pressure, in which growth may begin unseen by estimates of errors


def memory(scene: Scene) -> int:
    """Return from how many solutions a run predicts the next: more for short and equal steps."""
    return 3 if scene.numerics.step is None else 5


def step_controller(
    scene: Scene,
    pressure: Callable[[float], float],
    estimate_order: int,
    given: Sequence[float] = (),
) -> StepController:
    """Return the control of fixed steps, or of steps that follow the estimated error of growth.

    Parameters
    ----------
    scene
        The scene.
    pressure
        Turgor in MPa as a function of time in min.
    estimate_order
        Order of the method's estimated error.
    given
        Times in min at which the steps must end, those of an earlier run.
    """
    if given:
        return GivenSteps(given)
    run, numerics, growth_time = scene.run, scene.numerics, scene.growth_time
    places = kinks(scene)
    milestones = [] if run is None else [*places, *run.save, run.end]
    if numerics.step is not None:
        return StepController(milestones, numerics.step, None)
    for start, end in pairwise([0.0, *places]):
        if pressure(start) != pressure(end):
            milestones += list(np.linspace(start, end, _PARTS + 1))
    if growth_time is None:
        return StepController(milestones, max(milestones, default=0.0) / 100, None)
    return StepController(milestones, _FIRST_STEP * growth_time, estimate_order)


def among(time: float, times: Sequence[float]) -> bool:
    """Whether a time is one of some increasing ones."""
    after = bisect_left(times, time)
    if after < len(times) and same_time(time, times[after]):
        return True
    return after > 0 and same_time(time, times[after - 1])
