"""Rows of a verification table: our number and a published one, printed and drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Row:
    """A computed number and the range in which it must lie.

    Attributes
    ----------
    what
        What is compared.
    found, published
        Our number and the published one; the median if there are several.
    least, most
        The range in which our number must lie.
    """

    what: str
    found: float
    published: float
    least: float
    most: float

    @classmethod
    def near(cls, what: str, found: float, published: float, tolerance: float) -> Row:
        """Return a row whose range is a relative tolerance around the published number."""
        away = abs(published) * tolerance
        return cls(what, float(found), published, published - away, published + away)

    @property
    def holds(self) -> bool:
        """Return whether our number lies in the range."""
        return self.least <= self.found <= self.most


def show(rows: Sequence[Row]) -> None:
    """Print a table; rows out of their range are marked."""
    print(f"{'':44}{'ours':>12}{'published':>12}{'difference':>12}")
    for row in rows:
        difference = f"{row.found / row.published - 1:.1e}" if row.published else "-"
        mark = "" if row.holds else "  outside"
        print(f"{row.what:44}{row.found:12.6g}{row.published:12.6g}{difference:>12}{mark}")


@contextmanager
def figure_axes(name: str) -> Iterator[Any]:
    """Yield axes of a small figure that is saved to the directory `out`."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    path = Path("out") / f"{name}.png"
    path.parent.mkdir(exist_ok=True)
    figure, axes = plt.subplots(figsize=(4.8, 3.4), layout="constrained")
    axes.spines[["top", "right"]].set_visible(False)
    yield axes
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=200)
    plt.close(figure)
    print(f"Figure: {path}")
