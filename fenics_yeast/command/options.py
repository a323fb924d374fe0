"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer


def completed(incomplete: str) -> list[tuple[str, str]]:
    """Return the scene keys that complete the beginning of an assignment."""
    from .completion import assignments

    return assignments(incomplete)


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (TOML).")]
Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="TABLE.KEY=VALUE",
        help='Override a value, e.g. growth.time="30 min"; repeatable.',
        autocompletion=completed,
    ),
]
Variations = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="TABLE.KEY=V1,V2,...",
        help="Values V1,V2,... or range A:B:N (N values from A to B); repeatable.",
        autocompletion=completed,
    ),
]
PairedValues = Annotated[
    list[Path] | None,
    typer.Option(
        "--with",
        metavar="FILE.csv",
        help="Values that belong together: a column per scene key, a row per case; repeatable.",
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        min=1,
        help="Number of worker processes (default: available cores).",
        show_default=False,
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print errors only.")]
