"""How a run ended, in a word and in a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from .result import Row, Status


class Outcome(NamedTuple):
    """Status of a run and the sentence that explains it."""

    status: Status
    message: str


def limit_pressure_reached(limit: float, time: float | None = None) -> Outcome:
    """The wall finds no equilibrium beyond a limit pressure in MPa, at a time in min."""
    when = "" if time is None else f" from {time:g} min on"
    side = "inside" if limit > 0 else "outside"
    return Outcome(
        "no-equilibrium",
        f"no equilibrium{when}: the wall bears no more than its limit pressure, "
        f"{abs(limit):.6g} MPa from {side}",
    )


def limit_force_reached(limit: float) -> Outcome:
    """The wall finds no equilibrium beyond a limit force in µN."""
    return Outcome(
        "no-equilibrium",
        f"no equilibrium: the wall bears no more than its limit force, {limit:.6g} µN",
    )


def softened(row: Row, softens: bool = True) -> Outcome:
    """The wall has grown to a limit point; `row` is the last state before.

    A wall whose energy is per grown volume never softens.
    """
    why = "the wall has grown so soft that it can no longer carry the turgor"
    if not softens:
        why = "the cell has grown so large that its wall can no longer carry the turgor"
    if row.pressure_MPa < 0:
        why = "the wall has shrunk into a shape that gives way to the pressure from outside"
    where = f"beyond {row.time_min:.5g} min, at V/V0 = {row.volume_ratio:.4f}"
    return Outcome("no-equilibrium", f"{where}, there is no equilibrium: {why}")


def stability_note(rows: Sequence[Row]) -> str:
    """What must be known of the accepted states: that and where they are unstable."""
    first = next((i for i, row in enumerate(rows) if not row.stable), None)
    if first is None:
        return ""
    row, when = rows[first], "" if rows[-1].time_min == 0 else f"{rows[first].time_min:.6g} min, "
    where = f"{when}{row.pressure_MPa:.6g} MPa, V/V0 = {row.volume_ratio:.6g}"
    if any(later.stable for later in rows[first:]):
        return f"; some states are unstable, the first of them at {where}"
    since = f"from {where} on, " if len(rows) > 1 else ""
    return f"; {since}the equilibrium is unstable: a small disturbance leads away from it"
