"""The command `fenics-yeast`.

Start-up is kept short: what only a run or a figure needs is imported where it is used.
"""

from __future__ import annotations

import logging
import os
from pathlib import Path
from shlex import quote
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from ..scene import Scene, SceneError, parse_assignment
from .exits import (
    BAD_INPUT,
    BROKEN,
    EXIT,
    FAILED,
    INTERRUPTED,
    abandon,
    fail,
    launched,
    on_terminal,
    terminated_as_interrupted,
)

if TYPE_CHECKING:
    from ..simulation import Result
    from ..studies import Case, CaseRow
    from .terminal import Lines, ProgressLine

_BEGAN = perf_counter()

app = typer.Typer(
    help="Growth of a walled cell under turgor: a thin shell of revolution.",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help and usage errors, which need no rich
    pretty_exceptions_enable=False,
)


def _completed(incomplete: str) -> list[tuple[str, str]]:
    from .completion import assignments

    return assignments(incomplete)


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="The scene, a TOML file.")]
Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="TABLE.KEY=VALUE",
        help='Change a value, as growth.time="30 min"; may be repeated.',
        autocompletion=_completed,
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]


@app.command()
def run(
    scene_file: SceneFile,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Output folder.", show_default="out/<scene name>"),
    ] = None,
    assignments: Assignments = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the run that the output folder holds.")
    ] = False,
    error_bars: Annotated[
        bool,
        typer.Option("--error-bars", help="Run it again, refined, to estimate errors of V/V0."),
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Run a scene into an output folder.

    It takes in the history, profiles at the saved times, figures and a summary. Exit status: 0
    finished, 2 bad input, 3 the model has no equilibrium beyond some time, 4 the solver gave up,
    130 interrupted; 1 if dolfinx or its C compiler is missing.
    """
    try:
        scene = _load(scene_file, assignments)
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    path = Path("out", scene.name) if out is None else out
    try:
        with terminated_as_interrupted():
            result = _run(path, scene, resume, error_bars, quiet)
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    if result.status != "finished":
        fail(result.message, EXIT[result.status])


def _run(path: Path, scene: Scene, resume: bool, error_bars: bool, quiet: bool) -> Result:
    from ..output import DolfinxMissing, OutputError, RunLost
    from .run import run_completely

    screen = None if quiet else _screen(scene)
    try:
        result = run_completely(
            path,
            scene,
            screen=screen,
            began=_BEGAN,
            with_error_bars=error_bars,
            resume=resume,
        )
    except OutputError as error:
        fail(str(error), BAD_INPUT)
    except DolfinxMissing as error:
        fail(str(error), BROKEN)
    except RunLost as error:
        fail(str(error), FAILED) if error.everywhere else abandon(str(error))
    comm = launched()
    if screen is not None and (comm is None or comm.rank == 0):
        screen.summary(result, str(path))
    return result


@app.command()
def sweep(
    scene_file: SceneFile,
    variations: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="TABLE.KEY=V1,V2,...",
            help="Values of a key, or A:B:N for N of them from A to B; may be repeated.",
            autocompletion=_completed,
        ),
    ],
    assignments: Assignments = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Output folder.", show_default="out/<scene name>-sweep"),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Processes.", show_default="one for each core"),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Run a scene with every combination of some values.

    Each case gets an output folder below that of the sweep, which takes in a table, sweep.csv,
    and a figure of one parameter or two. Started again, it skips the cases that are finished.
    Under mpirun the ranks share the cases. Exit status: 0 every case has come to an end, 2 bad
    input, 4 some failed, 130 interrupted; 1 if dolfinx or its C compiler is missing.
    """
    from ..studies import parse_variation, plan

    try:
        scene = _load(scene_file, assignments)
        parameters = [parse_variation(text) for text in variations]
        cases = plan(scene, parameters)
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    if jobs is not None and launched() is not None:
        fail("--jobs is for one machine; under mpirun the ranks share the cases", BAD_INPUT)
    directory = Path("out", f"{scene.name}-sweep") if out is None else out
    keys = [parameter.key for parameter in parameters]
    try:
        with terminated_as_interrupted():
            rows = _sweep(directory, keys, cases, jobs, quiet)
    except KeyboardInterrupt:
        fail("interrupted; the same command goes on from here", INTERRUPTED)
    if failed := [row for row in rows if not row.answered]:
        fail(f"{len(failed)} of {len(rows)} cases failed, {failed[0].case} the first", FAILED)


def _sweep(
    directory: Path, keys: list[str], cases: list[Case], jobs: int | None, quiet: bool
) -> list[CaseRow]:
    from ..output import DolfinxMissing, OutputError, writing
    from ..studies import TABLE, run_sweep
    from ..studies import figure as sweep_plots
    from .sweep_terminal import SweepBar, SweepLines, tally
    from .terminal import print_line

    # What numpy would start beside, the processes would fight for.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    comm = launched()
    screen = (SweepBar if on_terminal() else SweepLines)(keys)
    jobs = jobs or len(os.sched_getaffinity(0))
    try:
        if quiet:
            rows = run_sweep(directory, keys, cases, jobs=jobs, comm=comm)
        else:
            with screen:
                rows = run_sweep(directory, keys, cases, jobs=jobs, comm=comm, screen=screen)
        if comm is not None and comm.rank > 0:
            return []
        with writing(directory):
            drawn = sweep_plots.draw(directory)
    except OutputError as error:
        fail(str(error), BAD_INPUT)
    except DolfinxMissing as error:
        fail(str(error), BROKEN)
    if not quiet:
        figure = f", {drawn[0]}" if drawn else ""
        print_line(f"{tally(rows)}; see {directory / TABLE}{figure}")
    return rows


@app.command()
def check(scene_file: SceneFile) -> None:
    """Validate a scene without running it."""
    try:
        Scene.load(scene_file)
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    typer.echo(f"{scene_file}: a valid scene")


@app.command()
def plot(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Output folder of a run or a sweep.")
    ],
    pdf: Annotated[bool, typer.Option("--pdf", help="Each figure as PDF too.")] = False,
    film: Annotated[
        bool,
        typer.Option("--film", help="A film too, GIF and, where ffmpeg is, MP4: runs it again."),
    ] = False,
) -> None:
    """Draw the figures of an output folder, finished or still going.

    Of a run: shapes, volume, stress and growth along the meridian, and the surfaces for ParaView.
    """
    from ..figures import FilmError
    from ..output import OutputError, writing
    from .redraw import draw_folder

    try:
        with writing(directory):
            drawn = draw_folder(directory, pdf=pdf, moving=film)
    except (SceneError, OutputError, FilmError) as error:
        fail(str(error), BAD_INPUT)
    except ImportError as error:
        fail(str(error), BROKEN)
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    if not drawn:
        fail(f"{directory}: nothing to draw yet; wait for the first saved time", BAD_INPUT)
    for path in drawn:
        typer.echo(path)


@app.command()
def new(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="The file to write.")],
) -> None:
    """Write a commented scene to begin with."""
    from .example import EXAMPLE

    try:
        with open(scene_file, "x", encoding="utf-8") as file:
            file.write(EXAMPLE)
    except FileExistsError:
        fail(f"{scene_file}: exists already; choose another name", BAD_INPUT)
    except OSError as error:
        fail(f"{scene_file}: cannot be written: {error.strerror or error}", BAD_INPUT)
    typer.echo(f"{scene_file}: a scene to change; then: fenics-yeast run {quote(str(scene_file))}")


@app.command()
def info() -> None:
    """Say what is installed, and whether it works.

    Exit status 1 if a run would fail; the line says what to do.
    """
    from .info import examine

    works = True
    for finding in examine():
        works = works and finding.works
        mark = "" if finding.works else "error: "
        typer.echo(f"{finding.subject:13} {mark}{finding.text}")
    if not works:
        raise typer.Exit(BROKEN)
    typer.echo("All that a run needs is there and works.")


def _load(scene_file: Path, assignments: list[str] | None) -> Scene:
    """Scene of a file with the values of `--set`."""
    changes = dict(parse_assignment(text) for text in assignments or ())
    scene = Scene.load(scene_file)
    return scene.with_values(changes) if changes else scene


def _screen(scene: Scene) -> Lines | ProgressLine:
    """Give what suits the place that the output goes to."""
    from .terminal import Lines, ProgressLine

    return ProgressLine(scene) if on_terminal() else Lines()


def _home() -> str:
    try:
        return str(Path.home())
    except RuntimeError:  # an unknown user, whose forms are compiled anew in every run
        from .._form_cache import temporary

        return str(temporary("home"))


def main() -> None:
    """Run the command."""
    if "HOME" not in os.environ:  # as in a service; Open MPI 5 wants one
        os.environ["HOME"] = _home()
    # It tells at length that a home is read-only, and that it looks for fonts.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    app()
