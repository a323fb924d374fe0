"""Results as small tables of HTML, which is how notebooks show them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from .result import History, Profile, Profiles, Result, Row

T = TypeVar("T")

_ENDS = 5  # rows shown of the beginning and of the end

_COLUMNS: dict[str, Callable[[Row], str]] = {
    "time (min)": lambda row: f"{row.time_min:.5g}",
    "pressure (MPa)": lambda row: f"{row.pressure_MPa:.4g}",
    "V/V0": lambda row: f"{row.volume_ratio:.6f}",
    "height (µm)": lambda row: f"{row.pole_height_um:.4g}",
    "bud radius (µm)": lambda row: f"{row.bud_radius_um:.4g}",
    "neck radius (µm)": lambda row: f"{row.neck_radius_um:.4g}",
    "growth strain": lambda row: f"{row.max_growth_strain:.4g}",
    "step (min)": lambda row: f"{row.step_min:.3g}",
    "iterations": lambda row: f"{row.newton_iterations}",
}

_OF_PROFILES: dict[str, Callable[[Profile], str]] = {
    "time (min)": lambda wall: f"{wall.time:.5g}",
    "height (µm)": lambda wall: f"{wall.z[-1] - wall.z[0]:.4g}",
    "largest radius (µm)": lambda wall: f"{wall.r.max():.4g}",
    "largest stress (MPa)": lambda wall: f"{wall.stress.max():.4g}",
    "largest growth strain": lambda wall: f"{wall.growth_strain.max():.4g}",
}


def history(record: History) -> str:
    """Table of the first and the last rows."""
    return _captioned(repr(record), _table(_COLUMNS, record.rows))


def profiles(record: Profiles) -> str:
    """Table of the saved times."""
    return _captioned(f"{len(record)} profiles", _table(_OF_PROFILES, record.all))


def result(record: Result) -> str:
    """How the run ended, and its rows at the times of its profiles."""
    rows = record.history.rows
    times = {profile.time for profile in record.profiles}
    saved = [row for row in rows if row.time_min in times] if len(times) > 1 else rows
    return _captioned(repr(record), _table(_COLUMNS, saved))


def _captioned(caption: str, table: str) -> str:
    return f"<p><code>{escape(caption)}</code></p>{table}"


def _table(columns: dict[str, Callable[[T], str]], records: Sequence[T]) -> str:
    """A row for each record, or for the first and the last of many."""
    head = _row("th", columns)
    lines = [_row("td", (text(record) for text in columns.values())) for record in records]
    if len(lines) > 2 * _ENDS + 1:
        lines[_ENDS:-_ENDS] = [_row("td", "⋮" * len(columns))]
    return f"<table><thead>{head}</thead><tbody>{''.join(lines)}</tbody></table>"


def _row(kind: str, cells: Iterable[str]) -> str:
    return "<tr>" + "".join(f"<{kind}>{escape(cell)}</{kind}>" for cell in cells) + "</tr>"
