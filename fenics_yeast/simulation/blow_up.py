"""Growth without bound: an estimate of the time at which the volume becomes infinite."""

from collections.abc import Sequence
from itertools import pairwise
from math import inf, log

from .history import Row

_ROWS = 5  # that the estimate uses
_LARGE = 100.0  # V/V0 below which growth is not examined
_HUGE = 1e4  # V/V0 that no limit point has
_SOON = 1.01  # estimated time over that of the last step, where no step leads on
_APART = 1.2  # ratio of volumes of the rows that the estimate uses
_AGREEMENT = 3e-5  # relative change of the estimated time from one of these rows to the next
_STEADY = 0.1  # relative change of the exponent from step to step


def blow_up_time(rows: Sequence[Row], broken_off: bool = False) -> float | None:
    """Return the time t* in min at which the volume of a growing cell becomes infinite.

    Close to it `V ~ (t* - t)^-a`. Three rows determine t* and a, which must agree with those of
    the rows before; a limit point, where the volume stays finite, gives no steady exponent.

    Parameters
    ----------
    rows
        The history so far.
    broken_off
        Whether no step leads on: then a cell of more than 10,000 volumes counts as infinite soon.

    Returns
    -------
    float or None
        The time; None as long as the volume is not seen to approach infinity.
    """
    if len(rows) < _ROWS or rows[-1].volume_ratio < _LARGE:
        return None
    last, far = rows[-1], _apart(rows)
    if any(after.time_min <= before.time_min for before, after in pairwise(far)):
        # Steps are lost in the digits of the time.
        return last.time_min if broken_off and last.volume_ratio > _HUGE else None
    estimates = [_power_law(*far[i : i + 3]) for i in range(_ROWS - 2)]
    times, exponents = zip(*estimates, strict=True)
    if broken_off:
        if last.volume_ratio < _HUGE:
            return None
        return times[-1] if times[-1] < _SOON * last.time_min else last.time_min
    if inf in times:
        return None
    spread = max(times) - min(times)
    steady = max(exponents) < (1 + _STEADY) * min(exponents)
    return times[-1] if steady and spread < _AGREEMENT * times[-1] else None


def _apart(rows: Sequence[Row]) -> list[Row]:
    """Return the last rows, of much different volumes where steps are short."""
    found = [rows[-1]]
    for i in range(len(rows) - 2, -1, -1):
        enough = rows[i].volume_um3 * _APART < found[-1].volume_um3
        if enough or i < _ROWS - len(found):  # the first rows, where there are no others
            found.append(rows[i])
        if len(found) == _ROWS:
            break
    return found[::-1]


def _power_law(first: Row, second: Row, third: Row) -> tuple[float, float]:
    """Return t* and a of `V ~ (t* - t)^-a` through three rows; infinite if there is none."""
    from scipy.optimize import brentq  # late: few cells grow without bound

    begin, middle, end = first.time_min, second.time_min, third.time_min
    early = log(second.volume_um3 / first.volume_um3)
    late = log(third.volume_um3 / second.volume_um3)

    def mismatch(remaining: float) -> float:
        """Compare the two exponents, multiplied by both logarithms; zero at `t* - end`."""
        from_begin = log((remaining + end - begin) / (remaining + end - middle))
        from_middle = log((remaining + end - middle) / remaining)
        return from_begin * late - from_middle * early

    least, most = 1e-9 * (end - begin), 1e3 * (end - begin)
    if early <= 0 or late <= 0 or mismatch(least) * mismatch(most) >= 0:
        return inf, inf
    remaining = float(brentq(mismatch, least, most, rtol=1e-12))
    return end + remaining, late / log((remaining + end - middle) / remaining)
