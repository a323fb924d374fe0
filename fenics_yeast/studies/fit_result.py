"""The result of a fit: values with intervals, and what the data say of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..geometry import Array


class NoFit(Exception):
    """No values were found whose runs reach the last measured time."""


@dataclass(frozen=True)
class Estimate:
    """A fitted number with its interval of 95 %; `at_limit` says that a limit of it stopped it."""

    key: str
    value: float
    low: float
    high: float
    unit: str
    at_limit: bool = False


@dataclass(frozen=True)
class FittedCurve:
    """A measured curve beside the run that fits it.

    Attributes
    ----------
    name, quantity
        As in `MeasuredCurve`.
    time_min, measured, errors, model, residuals
        Values at the measured times: measured ones with their standard deviations, those of the
        run, and standardised residuals, (measured - model) / error.
    fine_min, fine, band
        Times between, the run there, and half of its interval of 95 %.
    """

    name: str
    quantity: str
    time_min: Array
    measured: Array
    errors: Array
    model: Array
    residuals: Array
    fine_min: Array
    fine: Array
    band: Array


@dataclass(frozen=True)
class Profile:
    """Least chi2, above the minimum, with one number held at each of some values."""

    key: str
    values: tuple[float, ...]
    rise: tuple[float, ...]


@dataclass(frozen=True)
class FitResult:
    """What a fit found.

    Attributes
    ----------
    parameters
        The varied numbers, then free offsets. By default, intervals are normal ones of 95 %, of
        logarithms (of offsets: of their values), for the given noise.
    correlation
        Correlations of the estimates, in their order.
    chi2, degrees_of_freedom
        Sum of the squares of the standardised residuals, and what it should be on average.
    curves
        Measured and fitted curves.
    warnings
        What the data do not fix, and what would help.
    runs, seconds
        Runs of the scene with derivatives, and the time that all took.
    profiles
        Profiles of the parameters, if they were asked for; they then give the intervals.
    bootstrap
        Values of the parameters fitted to made data, shape ``(number, parameters)``, if asked for.
    """

    parameters: tuple[Estimate, ...]
    correlation: Array
    chi2: float
    degrees_of_freedom: int
    curves: tuple[FittedCurve, ...]
    warnings: tuple[str, ...]
    runs: int
    seconds: float
    intervals: str
    profiles: tuple[Profile, ...] = ()
    bootstrap: Array | None = None

    def __getitem__(self, key: str) -> Estimate:
        """Return the estimate of a key."""
        return next(one for one in self.parameters if one.key == key)

    def to_frame(self) -> Any:
        """Return the parameters as a pandas `DataFrame`, a row for each.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame([vars(one) for one in self.parameters]).set_index("key")
