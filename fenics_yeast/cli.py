"""The command `fenics-yeast`.

Start-up is kept short: what only a run or a figure needs is imported where it is used.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from .scene import Scene, SceneError, parse_assignment

if TYPE_CHECKING:
    from ._terminal import Lines, ProgressLine
    from .record import Result

_BEGAN = perf_counter()

_BAD_INPUT, _INTERRUPTED = 2, 130
_EXIT = {"finished": 0, "no-equilibrium": 3, "failed": 4, "interrupted": _INTERRUPTED}
_LOST = 1  # neither input nor physics: dolfinx is missing

app = typer.Typer(
    help="Growth of a walled cell under turgor: a thin shell of revolution.",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help and usage errors, which need no rich
    pretty_exceptions_enable=False,
)

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="The scene, a TOML file.")]


@app.command()
def run(
    scene_file: SceneFile,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Output folder.", show_default="out/<scene name>"),
    ] = None,
    assignments: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="TABLE.KEY=VALUE", help="Change a value; may be repeated."),
    ] = None,
    error_bars: Annotated[
        bool,
        typer.Option("--error-bars", help="Run it again, refined, to estimate errors of V/V0."),
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Run a scene into an output folder.

    It takes in the history, profiles at the saved times, figures and a summary. Exit status: 0
    finished, 2 bad input, 3 the model has no equilibrium beyond some time, 4 the solver gave up,
    130 interrupted.
    """
    try:
        changes = dict(parse_assignment(text) for text in assignments or ())
        scene = Scene.load(scene_file)
        scene = scene.with_values(changes) if changes else scene
    except SceneError as error:
        _fail(str(error), _BAD_INPUT)
    path = Path("out", scene.name) if out is None else out
    try:
        with _terminated_as_interrupted():
            result = _run(path, scene, error_bars, quiet)
    except KeyboardInterrupt:
        _fail("interrupted", _INTERRUPTED)
    if result.status != "finished":
        _fail(result.message, _EXIT[result.status])


def _run(path: Path, scene: Scene, error_bars: bool, quiet: bool) -> Result:
    from .job import DolfinxMissing, RunLost, run_into
    from .output import OutputError

    screen = None if quiet else _screen(scene)
    try:
        result = run_into(path, scene, screen=screen, began=_BEGAN, with_error_bars=error_bars)
    except OutputError as error:
        _fail(str(error), _BAD_INPUT)
    except DolfinxMissing as error:
        _fail(str(error), _LOST)
    except RunLost as error:
        _abandon(str(error))
    if screen is not None and _rank() == 0:
        screen.summary(result, str(path))
    return result


@app.command()
def check(scene_file: SceneFile) -> None:
    """Validate a scene without running it."""
    try:
        Scene.load(scene_file)
    except SceneError as error:
        _fail(str(error), _BAD_INPUT)
    typer.echo(f"{scene_file}: a valid scene")


@app.command()
def plot(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of a run.")],
) -> None:
    """Draw the figures of a finished or a running output folder."""
    from . import plots
    from .output import (
        OutputError,
        load_error_bars,
        load_history,
        load_profiles,
        load_scene,
        load_status,
        writing,
    )

    try:
        scene, status = load_scene(directory), load_status(directory)
        profiles = load_profiles(directory)  # before the history, which is ahead of them
        history, bars = load_history(directory), load_error_bars(directory)
        with writing(directory):
            drawn = plots.draw(directory, scene, history, profiles, status, bars)
    except (SceneError, OutputError) as error:
        _fail(str(error), _BAD_INPUT)
    if not drawn:
        _fail(f"{directory}: nothing to draw yet; wait for the first saved time", _BAD_INPUT)
    for path in drawn:
        typer.echo(path)


def _screen(scene: Scene) -> Lines | ProgressLine:
    """Give what suits the place that the output goes to."""
    from ._terminal import Lines, ProgressLine

    # Open MPI gives every rank a pseudo-terminal, wherever its output goes.
    fancy = sys.stdout.isatty() and "OMPI_COMM_WORLD_SIZE" not in os.environ
    fancy = fancy and os.environ.get("TERM") != "dumb"
    return ProgressLine(scene) if fancy else Lines()


def _rank() -> int:
    try:
        from mpi4py import MPI
    except ImportError:
        return 0
    return int(MPI.COMM_WORLD.rank)


def _fail(message: str, status: int) -> NoReturn:
    """Say in a line of rank 0 what ends the command, and end it."""
    if _rank() == 0:
        kind = "" if status in (_EXIT["no-equilibrium"], _INTERRUPTED) else "error: "
        typer.echo(kind + message, err=True)
    raise typer.Exit(status)


def _abandon(message: str) -> NoReturn:
    """End all ranks from rank 0, which alone knows that its output folder is lost."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.size > 1:
        typer.echo(f"error: {message}", err=True)
        MPI.COMM_WORLD.Abort(_EXIT["failed"])
    _fail(message, _EXIT["failed"])


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Treat SIGTERM, which batch systems send, as Ctrl-C."""

    def interrupt(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


def main() -> None:
    """Run the command."""
    app()
