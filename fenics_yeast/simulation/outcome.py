"""How a run ended: a status word and a sentence."""

from collections.abc import Sequence
from typing import NamedTuple

from ..geometry import Smoothing
from .history import Row
from .result import Status


class Outcome(NamedTuple):
    """Status of a run, the sentence that explains it, and its end in min if beyond all states."""

    status: Status
    message: str
    time: float | None = None


def reached_end(
    end: float, grew: bool, late: bool, reductions: int, limited: str | None
) -> Outcome:
    """Return the end of a run that reached its end in min.

    Parameters
    ----------
    end, grew
        The end, and whether the wall has grown, if it can.
    late
        Whether growth begins only after the end.
    reductions, limited
        How often a fixed step was reduced; the method whose stability limit reduced all.
    """
    message = f"reached {end:g} min"
    if not grew:
        why = "growth.from is later" if late else "the stress stays below growth.threshold"
        message += f"; nothing grew: {why}"
    if limited is not None:
        message += f"; steps reduced to the stability limit of {limited}"
    elif reductions:
        message += f"; {reductions} fixed step{'s' * (reductions != 1)} reduced"
    return Outcome("finished", message)


def limit_pressure_exceeded(limit: float, time: float | None = None) -> Outcome:
    """Return the end of a run at a limit pressure in MPa, at a time in min."""
    when = "" if time is None else f" beyond {time:g} min"
    side = "internal" if limit > 0 else "external"
    return Outcome(
        "no-equilibrium",
        f"no equilibrium{when}: limit pressure exceeded ({abs(limit):.6g} MPa, {side})",
    )


def limit_force_exceeded(limit: float) -> Outcome:
    """Return the end of a run at a limit force in µN."""
    return Outcome("no-equilibrium", f"no equilibrium: limit force exceeded ({limit:.6g} µN)")


def wall_softened(stretch: float, where: str) -> Outcome:
    """Return the end of a run at a linear wall that is compressed beyond its stiffness."""
    return Outcome(
        "no-equilibrium",
        f"no equilibrium found beyond {where}: the wall is compressed to {stretch:.2g} of its "
        'length, where a linear wall has no stiffness; use law = "ogden"',
    )


def wall_folded(stretch: float, where: str) -> Outcome:
    """Return the end of a run at a wall that is bent to a radius of the size of its thickness."""
    return Outcome(
        "no-equilibrium",
        f"no equilibrium found beyond {where}: a fold compresses a face of the wall to "
        f"{stretch:.2g} of its length, too sharp for a shell; use a larger thickness, "
        "a polarity without an edge, or bending = false",
    )


def buckled(where: str) -> Outcome:
    """Return the end of a run whose last states are unstable, with no equilibrium nearby."""
    return Outcome("no-equilibrium", f"no equilibrium found beyond {where}: the wall has buckled")


def wall_thinned(ratio: float, where: str) -> Outcome:
    """Return the end of a run at a linear wall that has almost no thickness left.

    `where` is the last state, "at ..." or "under ...".
    """
    thinned = f"the linear wall has thinned to nothing {where}"
    if ratio > 0:
        thinned = (
            f"the linear wall has thinned to {100 * ratio:.2g} % of its thickness {where}, "
            "and nothing is left a little further"
        )
    return Outcome(
        "no-equilibrium", f'{thinned}; use law = "ogden" or thickness_change = "none"'
    )  # fmt: skip


def growth_limit_reached(row: Row, softens: bool = True) -> Outcome:
    """Return the end of a run at which growth reached a limit point, after its last row.

    Growth softens the wall unless the energy is per unit grown volume.
    """
    load = "the turgor" if row.force_uN == 0 else "turgor and force"
    why = f"growth has softened the wall until it can no longer carry {load}"
    if not softens:
        why = f"the cell has grown so large that its wall can no longer carry {load}"
    if row.pressure_MPa < 0:
        why = "the wall has shrunk into a shape that cannot carry the external pressure"
    where = f"beyond {row.time_min:.5g} min (V/V0 = {row.volume_ratio:.4f})"
    return Outcome("no-equilibrium", f"no equilibrium {where}: {why}")


def growth_unbounded(time: float, row: Row) -> Outcome:
    """Return the end of a run whose volume becomes infinite at a time in min after a row."""
    return Outcome(
        "unbounded",
        f"growth without bound: the volume becomes infinite at {time:.7g} min "
        f"(computed up to {row.time_min:.5g} min, V/V0 = {row.volume_ratio:.4g})",
        time,
    )


def stopped_at_contact(row: Row) -> Outcome:
    """Return the end of a run that was to end at the first row in which the wall touches itself."""
    return Outcome("finished", f"the wall touches itself at {_place(row)}; stopped there")


def stopped_at_bifurcation(waves: int) -> Outcome:
    """Return the end of a run that was to end where the first mode falls, with some waves."""
    where = "a bifurcation" if waves > 0 else "a limit point or axisymmetric bifurcation"
    return Outcome("no-equilibrium", f"stopped at {where}")


def _unstable_beyond(row: Row, waves: int) -> str:
    where = f"{row.pressure_MPa:.6g} MPa, V/V0 = {row.volume_ratio:.6g}"
    if row.force_uN != 0:
        where = f"{row.force_uN:.6g} µN, {where}"
    if row.time_min > 0:
        where = f"{row.time_min:.6g} min, {where}"
    return f"unstable beyond {where} to {_mode(waves)}"


def _mode(waves: int) -> str:
    if waves == 0:
        return "an axisymmetric mode"
    return f"a mode with {waves} wave{'s' * (waves > 1)} around the axis"


def contact_warning(row: Row, table: str) -> str:
    """Return what must be known of a run whose wall touches itself from a row on.

    `table` is the table of the scene with the key that ends a run there.
    """
    return (
        f"the wall touches itself from {_place(row)} on, and may go through itself, as contact is "
        f"not modelled; to end there, set {table}.stop_at_contact = true"
    )


def smoothing_warning(smoothing: Smoothing) -> str:
    """Return what must be known of a run whose cell is a smoothed contour."""
    return (
        f"the contour is smoothed by {1e3 * smoothing.tolerance:.2g} nm (cell.tolerance), which "
        f"changes its volume by {100 * smoothing.volume_change:+.2g} %; membrane stresses may be "
        f"wrong by {100 * smoothing.stress_error:.2g} % of their maximum"
    )


def _place(row: Row) -> str:
    if row.time_min > 0:
        return f"{row.time_min:.5g} min"
    if row.displacement_um != 0:
        return f"a displacement of {row.displacement_um:.5g} µm"
    return f"V/V0 = {row.volume_ratio:.5g}"


def stability_note(rows: Sequence[Row], bifurcation: Sequence[int] = ()) -> str:
    """Return the end of a message that says which accepted states are unstable.

    `bifurcation` has the number of the last row before the first one, and the waves of its mode.
    """
    if not bifurcation:
        return ""
    number, waves = bifurcation
    if not rows[number].stable:
        return f"; the equilibrium is unstable to {_mode(waves)}"
    again = any(row.stable for row in rows[number + 2 :])
    some = "some equilibria are " if again else ""
    return f"; {some}{_unstable_beyond(rows[number], waves)}"
