"""The commands `fenics-yeast fit` and `fenics-yeast design`: their work and their screen."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..scene import FitProblem, SceneError
from .exits import (
    BAD_INPUT,
    BROKEN,
    FAILED,
    INTERRUPTED,
    fail,
    launched,
    on_terminal,
    terminated_as_interrupted,
)
from .fit_terminal import FitLine, FitLines, print_estimates
from .options import Jobs, Quiet
from .terminal import print_line

if TYPE_CHECKING:
    from ..studies import Evaluation

FitFile = Annotated[Path, typer.Argument(metavar="FIT", help="Fit file (TOML).")]


def fit(
    fit_file: FitFile,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Output directory (default: out/<fit name>).", show_default=False
        ),
    ] = None,
    profile: Annotated[
        bool,
        typer.Option("--profile", help="Find intervals by profiles of chi2; takes more runs."),
    ] = False,
    bootstrap: Annotated[
        int, typer.Option(metavar="N", min=0, help="Also fit N made data sets (default: 0).")
    ] = 0,
    jobs: Jobs = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Start from the best values of runs.csv, if any.")
    ] = False,
    quiet: Quiet = False,
) -> None:  # fmt: skip
    """Fit numbers of a scene to measured curves.

    Writes fit.json, fit.csv, runs.csv and figures. Exit status: 0 fitted; 1 dolfinx or C compiler
    missing; 2 invalid input; 4 no fit found; 130 interrupted.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # threads would compete with processes
    problem = _load(fit_file)
    directory = Path("out", problem.name) if out is None else out
    jobs = jobs or len(os.sched_getaffinity(0))
    screen = None if quiet else (FitLine if on_terminal() else FitLines)(problem)
    with _named("interrupted; rerun with --resume to continue"):
        from ..output import FolderLock, writing
        from ..studies import (
            RunsTable,
            Unknowns,
            draw_fit,
            fit_problem,
            read_best,
            read_runs,
            write_fit,
        )

        with writing(directory):
            directory.mkdir(parents=True, exist_ok=True)
            lock = FolderLock(directory)
        with lock, terminated_as_interrupted():
            unknowns = Unknowns(problem)
            start = read_best(directory, unknowns) if resume else None
            table = RunsTable(directory, unknowns, read_runs(directory, unknowns) if resume else ())

            def tried(evaluation: Evaluation) -> None:
                table.add(evaluation)
                if screen is not None:
                    screen.tried(evaluation)

            try:
                result = fit_problem(
                    problem, profile=profile, bootstrap=bootstrap, jobs=jobs, start=start,
                    tried=tried,
                )  # fmt: skip
            finally:
                if screen is not None:
                    screen.end()
            write_fit(directory, result)
            with writing(directory):
                drawn = draw_fit(directory, result)
    if not quiet:
        print_estimates(result)
        print_line(f"{result.runs} runs in {result.seconds:.0f} s; see {directory}, {drawn[0]}")


def design(fit_file: FitFile) -> None:
    """Show the intervals to expect from an experiment before it is done.

    Uses times and noise of the curves of a fit, at the first values; measured values do not matter.
    Exit status: 0 shown; 1 dolfinx or C compiler missing; 2 invalid input; 4 a run ends early.
    """
    problem = _load(fit_file)
    with _named("interrupted"):
        from ..studies import expected

        result = expected(problem)
    print_line("expected intervals (95 %) at the first values:")
    print_estimates(result, judged=False)


@contextmanager
def _named(interrupted: str) -> Iterator[None]:
    """End the command with the message and exit status of what goes wrong here."""
    from ..output import DolfinxMissing, OutputError
    from ..studies import NoFit

    try:
        yield
    except (SceneError, OutputError) as error:
        fail(str(error), BAD_INPUT)
    except NoFit as error:
        fail(str(error), FAILED)
    except (DolfinxMissing, ImportError) as error:
        fail(str(error), BROKEN)
    except KeyboardInterrupt:
        fail(interrupted, INTERRUPTED)


def _load(fit_file: Path) -> FitProblem:
    try:
        if launched() is not None:
            raise SceneError("fits run on one rank; omit mpirun, and set --jobs")
        return FitProblem.load(fit_file)
    except SceneError as error:
        fail(str(error), BAD_INPUT)


def add_fits(app: typer.Typer) -> None:
    """Add the commands of fits."""
    app.command()(fit)
    app.command()(design)
