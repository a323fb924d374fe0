"""The length of time steps: milestones hit exactly, growth after success, cuts after failure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, isclose

_CUT = 0.5
_GROWTH = 4.0  # largest growth of a step from one to the next
_SAFETY = 0.9
_LEAST = 2.0**-20  # of the first step
_SAME = 1e-12  # relative difference of times that are one


def same_time(a: float, b: float) -> bool:
    """Whether two times are too near to each other for a step between them."""
    return isclose(a, b, rel_tol=_SAME)


@dataclass(frozen=True)
class ControllerState:
    """What the next steps depend on: wanted and last length in min, last error, failures, cuts."""

    wanted: float
    taken: float
    last_error: float
    failures: int
    reductions: int


class StepController:
    """Proposes the end of the next step; is told what became of it.

    Steps before a milestone are made equal, so that none of them is a sliver.

    Parameters
    ----------
    milestones
        Times in min that are hit exactly; the last one is the end.
    step
        Length of the first step, in min, to which later ones go back after a cut; where errors
        are estimated, only that of the first one.
    order
        Order of the estimated error in the step; None: fixed steps.

    Attributes
    ----------
    failures
        Steps in a row that found no equilibrium.
    cuts
        Steps in all that found none.
    """

    def __init__(self, milestones: Iterable[float], step: float, order: int | None) -> None:
        self._milestones = sorted({float(t) for t in milestones if t > 0})
        self._wanted = self._fixed = step
        self._taken = step
        self._least = step * _LEAST
        self._order = order
        self._last_error = 1.0
        self.failures = self.reductions = 0

    def propose(self, time: float, longest: float = float("inf")) -> float | None:
        """End of the next step from a time, of a bounded length; None at the end of the run."""
        ahead = [t for t in self._milestones if t > time and not same_time(t, time)]
        if not ahead:
            return None
        span = ahead[0] - time
        pieces = max(1, ceil(span / min(self._wanted, longest) - 1e-9))
        self._taken = span / pieces
        return ahead[0] if pieces == 1 else time + self._taken

    def propose_milestone(self, time: float) -> float | None:
        """End of a step over a time in which nothing changes: the next milestone."""
        wanted, self._wanted = self._wanted, float("inf")
        end = self.propose(time)
        self._wanted = wanted
        return end

    def state(self) -> ControllerState:
        """What the next steps depend on."""
        return ControllerState(
            self._wanted, self._taken, self._last_error, self.failures, self.reductions
        )

    def restore(self, state: ControllerState) -> None:
        """Go on as an earlier run would have."""
        self._wanted, self._taken = state.wanted, state.taken
        self._last_error = state.last_error
        self.failures, self.reductions = state.failures, state.reductions

    @property
    def exhausted(self) -> bool:
        """Whether the step has become smaller than any that makes sense."""
        return self._wanted < self._least

    def accepts(self, error: float) -> bool:
        """Whether a step with this error, 1 being the largest wanted, is good enough.

        The next step follows from it, by a proportional-integral controller.
        """
        self.failures = 0
        if self._order is None:
            self._wanted = min(self._fixed, 2 * self._wanted)
            return True
        error = max(error, 1e-6)
        if error > 1:
            self._wanted = self._taken * max(0.1, _SAFETY * error ** (-1 / self._order))
            return False
        factor = error ** (-0.7 / self._order) * self._last_error ** (0.4 / self._order)
        self._wanted = max(self._taken * min(_GROWTH, _SAFETY * factor), self._least)
        self._last_error = error
        return True

    def reset(self) -> None:
        """Forget what the last steps taught: what comes is unlike them."""
        self._wanted, self._last_error = self._fixed, 1.0

    def failed(self) -> None:
        """Cut the step that found no equilibrium."""
        self.failures += 1
        self.reductions += 1
        self._wanted = _CUT * self._taken
