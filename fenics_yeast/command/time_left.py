"""How long a run will still take, from the steps that it has made."""

from __future__ import annotations

from math import log
from statistics import median
from time import perf_counter

_FEWEST = 8  # steps before which nothing can be said
_PART = 2  # the last of so many parts of the steps tells how they change
_MOST = 300  # steps that are looked at
_GROWTH, _DECAY = 0.2, -3.0  # bounds of their exponent


class TimeLeft:
    """Estimates the seconds that are left from the lengths of the steps, and how these change.

    Steps that follow the growth of a cell lengthen at first, and shorten as it runs away. They are
    taken to go on as a power of time; the wall clock, as so many seconds for each step.

    Parameters
    ----------
    end
        End of the run in min.
    """

    def __init__(self, end: float) -> None:
        self._end = end
        self._times: list[float] = []
        self._clock: list[float] = []

    def accepted(self, time: float, now: float | None = None) -> float | None:
        """Seconds left after a step to a time in min; None where that cannot be said yet."""
        self._times.append(time)
        self._clock.append(perf_counter() if now is None else now)
        count = len(self._times) - 1
        if count < _FEWEST:
            return None
        recent = min(_MOST, max(4, count // _PART))
        steps = [b - a for a, b in zip(self._times[-recent - 1 : -1], self._times[-recent:],
                                       strict=True)]  # fmt: skip
        half = recent // 2
        # Medians: a step that is cut to hit a saved time says nothing of the next ones.
        early, late = median(steps[:half]), median(steps[-half:])
        ratio = median(self._times[-half:]) / median(self._times[-recent : -recent + half])
        power = min(_GROWTH, max(_DECAY, log(late / early) / log(ratio)))
        left = late and time / late * ((self._end / time) ** (1 - power) - 1) / (1 - power)
        half = max(_FEWEST, count // 2)
        return left * (self._clock[-1] - self._clock[-half - 1]) / half


def duration(seconds: float) -> str:
    """Write a duration as precisely as it can be known."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"
