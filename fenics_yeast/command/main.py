"""The command `fenics-yeast`.

Modules that only a run or a figure needs are imported in functions, to keep start-up short.
"""

from __future__ import annotations

import gc
from importlib.resources import files
from pathlib import Path
from shlex import quote
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from ..scene import Scene, SceneError, parse_assignment
from ..simulation import EXIT_STATUS
from .environment import prepare
from .exits import (
    BAD_INPUT,
    BROKEN,
    FAILED,
    INTERRUPTED,
    abandon,
    fail,
    launched,
    on_terminal,
    terminated_as_interrupted,
)
from .fit import add_fits
from .options import Assignments, Jobs, PairedValues, Quiet, SceneFile, Variations

if TYPE_CHECKING:
    from ..simulation import Result
    from .terminal import Lines, ProgressLine

_BEGAN = perf_counter()

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help and usage errors, which need no rich
    pretty_exceptions_enable=False,
)
add_fits(app)


def _show_version(requested: bool) -> None:
    if requested:
        from importlib.metadata import version

        typer.echo(f"fenics-yeast {version('fenics-yeast')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show the version and exit.", callback=_show_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Simulate walled-cell growth under turgor with an axisymmetric shell model."""


@app.command()
def run(
    scene_file: SceneFile,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Output directory (default: out/<scene name>).",
            show_default=False,
        ),
    ] = None,
    assignments: Assignments = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue from the last checkpoint, if any.")
    ] = False,
    error_bars: Annotated[
        bool,
        typer.Option(
            "--error-bars", help="Estimate the numerical error of V/V0 by refined reruns."
        ),
    ] = False,
    no_figures: Annotated[
        bool,
        typer.Option("--no-figures", help="Draw nothing; fenics-yeast plot does it later."),
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Run a simulation.

    Writes history, saved profiles, figures and a summary to the output directory. Exit status:
    0 finished; 1 dolfinx or C compiler missing, or disk full; 2 invalid input;
    3 no equilibrium or growth without bound; 4 solver failure; 130 interrupted.
    """
    try:
        scene = _load(scene_file, assignments)
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    path = Path("out", scene.name) if out is None else out
    try:
        with terminated_as_interrupted():
            result = _run(path, scene, resume, error_bars, not no_figures, quiet)
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    if result.status != "finished":
        resumable = result.status == "interrupted" and scene.run is not None
        advice = "; rerun with --resume to continue" if resumable else ""
        fail(result.message + advice, EXIT_STATUS[result.status])


def _run(
    path: Path, scene: Scene, resume: bool, error_bars: bool, figures: bool, quiet: bool
) -> Result:
    from ..output import DolfinxMissing, OutputError, RunLost
    from .run import run_completely

    screen = None if quiet else _screen(scene)
    try:
        result = run_completely(
            path, scene, screen=screen, began=_BEGAN, with_error_bars=error_bars,
            with_figures=figures, resume=resume,
        )  # fmt: skip
    except OutputError as error:
        fail(str(error), BAD_INPUT)
    except DolfinxMissing as error:
        fail(str(error), BROKEN)
    except RunLost as error:
        fail(str(error), BROKEN) if error.everywhere else abandon(str(error))
    comm = launched()
    if screen is not None and (comm is None or comm.rank == 0):
        screen.summary(result, str(path))
    return result


@app.command()
def sweep(
    scene_file: SceneFile,
    variations: Variations = None,
    paired: PairedValues = None,
    assignments: Assignments = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Output directory (default: out/<scene name>-sweep).",
            show_default=False,
        ),
    ] = None,
    jobs: Jobs = None,
    quiet: Quiet = False,
) -> None:
    """Run all combinations of parameter values, or of rows of a table.

    Writes a subdirectory per case, sweep.csv and a figure (none for all combinations of more than
    two parameters). Rerun to continue; finished cases are skipped. Under mpirun, ranks share the
    cases. Exit status: 0 all cases ended (with or without an equilibrium); 4 some failed; 1, 2, 130
    as for run.
    """
    from .sweep import cases_of, sweep_into

    try:
        scene = _load(scene_file, assignments)
        keys, cases = cases_of(scene, variations or [], paired or [])
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    if jobs is not None and launched() is not None:
        fail(
            "--jobs cannot be used under mpirun, where the ranks share the cases; omit it",
            BAD_INPUT,
        )
    directory = Path("out", f"{scene.name}-sweep") if out is None else out
    try:
        with terminated_as_interrupted():
            rows = sweep_into(directory, keys, cases, jobs, quiet)
    except KeyboardInterrupt:
        fail("interrupted; rerun the same command to continue", INTERRUPTED)
    if failed := [row for row in rows if not row.answered]:
        counts = f"{len(failed)} of {len(rows)} cases failed"
        fail(f"{counts}, first {failed[0].case}; see sweep.csv", FAILED)


@app.command()
def modes(
    scene_file: SceneFile,
    waves: Annotated[
        str,
        typer.Option(metavar="A:B", help="Numbers of waves around the axis (default: 0:12)."),
    ] = "0:12",
    assignments: Assignments = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Output directory (default: out/<scene name>-modes).",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Find the external pressures at which an unloaded wall buckles.

    Linear buckling, without growth and loads. Writes modes.csv, modes.png and, for ParaView,
    mode.vtu with the first mode.
    """
    from ..output import DolfinxMissing, OutputError
    from .modes import find_modes, parse_waves

    try:
        from ..simulation import UnloadedShapeError
        from ..solve import EquilibriumError
    except ImportError as error:
        fail(str(error), BROKEN)
    try:
        scene = _load(scene_file, assignments)
        if launched() is not None:
            raise SceneError("modes runs on one rank; omit mpirun")
        directory = Path("out", f"{scene.name}-modes") if out is None else out
        found = find_modes(scene, parse_waves(waves), directory)
    except (SceneError, OutputError) as error:
        fail(str(error), BAD_INPUT)
    except DolfinxMissing as error:
        fail(str(error), BROKEN)
    except EquilibriumError as error:
        fail(f"no equilibrium under a very small pressure: {error}", FAILED)
    except UnloadedShapeError as error:
        fail(str(error), FAILED)
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    for mode in found:
        pressure = "none" if mode.pressure is None else f"{mode.pressure:.6g} MPa"
        typer.echo(f"{mode.waves:3} waves: {pressure}")
    typer.echo(f"see {directory}")


@app.command()
def check(scene_file: SceneFile, assignments: Assignments = None) -> None:
    """Validate a scene file without running it."""
    try:
        _load(scene_file, assignments)
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    typer.echo(f"{scene_file}: valid")


@app.command()
def plot(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Output directory of a run or sweep.")
    ],
    pdf: Annotated[bool, typer.Option("--pdf", help="Also save figures as PDF.")] = False,
    film: Annotated[
        bool,
        typer.Option("--film", help="Also animate (GIF; MP4 with ffmpeg); reruns the simulation."),
    ] = False,
) -> None:
    """Plot a run or sweep, finished or in progress.

    For a run, also write ParaView surfaces.
    """
    from ..figures import AnimationError
    from ..output import OutputError, writing
    from .redraw import draw_folder, nothing_drawn

    try:
        with writing(directory):
            drawn = draw_folder(directory, pdf=pdf, moving=film)
    except (SceneError, OutputError, AnimationError) as error:
        fail(str(error), BAD_INPUT)
    except ImportError as error:
        fail(str(error), BROKEN)
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    if not drawn:
        fail(f"{directory}: {nothing_drawn(directory)}", BAD_INPUT)
    for path in drawn:
        typer.echo(path)


@app.command()
def new(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="File to create.")],
) -> None:
    """Create a commented example scene."""
    example = files(__package__).joinpath("example.toml").read_text(encoding="utf-8")
    try:
        with open(scene_file, "x", encoding="utf-8") as file:
            file.write(example)
    except FileExistsError:
        fail(f"{scene_file}: already exists; choose another name", BAD_INPUT)
    except OSError as error:
        fail(f"{scene_file}: cannot be written: {error.strerror or error}", BAD_INPUT)
    command = f"fenics-yeast run {quote(str(scene_file))}"
    typer.echo(f"created {scene_file}; edit it, then run: {command}")


@app.command()
def info() -> None:
    """Show versions and test the installation.

    Exit status 1 if a run would fail; prints the fix.
    """
    from .info import examine

    works = True
    for finding in examine():
        works = works and finding.works
        mark = "" if finding.works else "error: "
        typer.echo(f"{finding.subject:13} {mark}{finding.text}")
    if not works:
        raise typer.Exit(BROKEN)
    typer.echo("The installation works.")


def _load(scene_file: Path, assignments: list[str] | None) -> Scene:
    """Load a scene with the values of `--set`."""
    changes = dict(parse_assignment(text) for text in assignments or ())
    scene = Scene.load(scene_file)
    return scene.with_values(changes) if changes else scene


def _screen(scene: Scene) -> Lines | ProgressLine:
    """Return a screen that suits the output, a terminal or a file."""
    from .terminal import Lines, ProgressLine

    return ProgressLine(scene) if on_terminal() else Lines(scene)


def main() -> None:
    """Run the command."""
    prepare()
    try:
        app()
    finally:
        gc.freeze()  # the interpreter would search all forms for garbage once more
