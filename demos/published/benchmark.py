"""A row of a benchmark's table: our number beside a published one; how it is printed and drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Row:
    """A number that was found, and the range in which it must lie.

    Attributes
    ----------
    what
        What is compared.
    found, published
        Our number, and theirs; where several were published, the one in the middle.
    least, most
        The range in which ours must lie.
    """

    what: str
    found: float
    published: float
    least: float
    most: float

    @classmethod
    def near(cls, what: str, found: float, published: float, tolerance: float) -> Row:
        """A row whose number lies within a relative tolerance of the published one."""
        away = abs(published) * tolerance
        return cls(what, float(found), published, published - away, published + away)

    @property
    def holds(self) -> bool:
        """Whether our number lies in the range."""
        return self.least <= self.found <= self.most


def show(rows: Sequence[Row]) -> None:
    """Print a table, and what does not hold."""
    print(f"{'':44}{'ours':>12}{'published':>12}{'difference':>12}")
    for row in rows:
        difference = f"{row.found / row.published - 1:.1e}" if row.published else "-"
        mark = "" if row.holds else "  outside"
        print(f"{row.what:44}{row.found:12.6g}{row.published:12.6g}{difference:>12}{mark}")


@contextmanager
def picture(name: str) -> Iterator[Any]:
    """Axes of a small picture in the folder `out`."""
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
    print(f"Picture: {path}")
