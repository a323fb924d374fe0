"""The size of time steps: from estimated errors, milestones and failures.

An accepted step of estimated error e_n, 1 being the largest allowed, sets the next size by the
proportional-integral controller

    h_{n+1} = 0.9 h_n e_n^(-0.7/k) e_{n-1}^(0.4/k)

where the estimate falls with h^k: the exponents are those of K. Gustafsson, Control theoretic
techniques for stepsize selection in explicit Runge-Kutta methods, ACM Trans. Math. Softw. 17 (1991)
533-554. A rejected step is tried again with 0.9 h_n e_n^(-1/k), one without equilibrium with half
its size.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, isclose

_REDUCTION = 0.5  # after a step without equilibrium
_LARGEST_GROWTH, _LEAST_GROWTH = 4.0, 0.1  # of the size from one step to the next
_SAFETY = 0.9
_LEAST_ERROR = 1e-6
_LEAST_STEP = 2.0**-20  # of the first step
_SAME = 1e-12  # relative difference of equal times


def same_time(a: float, b: float) -> bool:
    """Whether two times are too close to each other for a step between them."""
    return isclose(a, b, rel_tol=_SAME)


@dataclass(frozen=True)
class ControllerState:
    """Wanted and last step size in min, last error, failures in a row, reductions in all."""

    wanted: float
    taken: float
    last_error: float
    failures: int
    reductions: int


class StepController:
    """Proposes the end of the next step and adapts its size to the outcome of the last one.

    The steps before a milestone are made equal, so that none of them is very short.

    Parameters
    ----------
    milestones
        Times in min that are met exactly; the last one is the end.
    step
        Size of the first step in min. Without error estimates also the largest size, to which
        steps return after a reduction.
    order
        Power of the step size with which the estimated error falls; None for fixed steps.

    Attributes
    ----------
    failures
        Number of steps in a row without equilibrium.
    reductions
        Number of all steps without equilibrium.
    """

    def __init__(self, milestones: Iterable[float], step: float, order: int | None) -> None:
        self._milestones = sorted({float(t) for t in milestones if t > 0})
        self._wanted = self._taken = self._first = step
        self._least = step * _LEAST_STEP
        self._order = order
        self._last_error = 1.0
        self.failures = self.reductions = 0

    def propose(self, time: float, longest: float = float("inf")) -> float | None:
        """Return the end of the next step in min, of bounded size; None at the end of the run."""
        ahead = [t for t in self._milestones if t > time and not same_time(t, time)]
        if not ahead:
            return None
        span = ahead[0] - time
        steps = max(1, ceil(span / min(self._wanted, longest) - 1e-9))
        self._taken = span / steps
        return ahead[0] if steps == 1 else time + self._taken

    def propose_milestone(self, time: float) -> float | None:
        """Return the next milestone, as the end of a step in which nothing changes."""
        wanted, self._wanted = self._wanted, float("inf")
        end = self.propose(time)
        self._wanted = wanted
        return end

    def accepts(self, error: float) -> bool:
        """Whether a step of this estimated error, 1 being the largest allowed, is accurate enough.

        Sets the size of the next step.
        """
        self.failures = 0
        if self._order is None:
            self._wanted = min(self._first, 2 * self._wanted)
            return True
        error = max(error, _LEAST_ERROR)
        if error > 1:
            factor = max(_LEAST_GROWTH, _SAFETY * error ** (-1 / self._order))
            self._wanted = self._taken * factor
            return False
        factor = error ** (-0.7 / self._order) * self._last_error ** (0.4 / self._order)
        self._wanted = max(self._taken * min(_LARGEST_GROWTH, _SAFETY * factor), self._least)
        self._last_error = error
        return True

    def failed(self) -> None:
        """Reduce the size after a step without equilibrium."""
        self.failures += 1
        self.reductions += 1
        self._wanted = _REDUCTION * self._taken

    @property
    def exhausted(self) -> bool:
        """Whether the step size is too small to continue."""
        return self._wanted < self._least

    def reset(self) -> None:
        """Return to the first step size: growth changes abruptly here."""
        self._wanted, self._last_error = self._first, 1.0

    def state(self) -> ControllerState:
        """Return what the next steps depend on."""
        return ControllerState(
            self._wanted, self._taken, self._last_error, self.failures, self.reductions
        )

    def restore(self, state: ControllerState) -> None:
        """Continue with the steps of an earlier run."""
        self._wanted, self._taken = state.wanted, state.taken
        self._last_error = state.last_error
        self.failures, self.reductions = state.failures, state.reductions


class GivenSteps(StepController):
    """The steps of an earlier run, whatever their errors, none of them shortened.

    Parameters
    ----------
    times
        Ends of the steps in min.
    """

    def __init__(self, times: Iterable[float]) -> None:
        super().__init__(times, float("inf"), None)
        self._failed = False

    def propose(self, time: float, longest: float = float("inf")) -> float | None:
        """Return the end of the next step in min; None after the last one."""
        return super().propose(time)

    def failed(self) -> None:
        """End the run: without one of its steps it is another one."""
        super().failed()
        self._failed = True

    @property
    def exhausted(self) -> bool:
        """Whether a step had no equilibrium."""
        return self._failed
