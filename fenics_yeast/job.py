"""A scene run into an output folder: simulation, figures, summary, on any number of ranks."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol

from .output import OutputError, OutputFolder, writing
from .record import History, Observer, Profile, Profiles, Result, Row, Timings
from .scene import Scene

_UNSTARTED = Result(
    history=History(()),
    profiles=Profiles(()),
    status="interrupted",
    message="interrupted before the first equilibrium",
    end_time=0.0,
    dofs=0,
    steps=0,
    rejected_steps=0,
    newton_iterations=0,
    timings=Timings(),
)


class DolfinxMissing(Exception):
    """dolfinx cannot be loaded or compiles nothing; the message is a line that says what to do."""


class Screen(Observer, Protocol):
    """An observer that shows a run between entry and exit."""

    def __enter__(self) -> object: ...

    def __exit__(self, *_: object) -> None: ...

    def refining(self, part: str) -> None:
        """Take note of a run that is refined in one part, for the error bars."""


class RunLost(Exception):
    """The folder stopped taking in the run half-way, as a full disk does; on rank 0 alone."""


def run_into(
    path: Path,
    scene: Scene,
    *,
    screen: Screen | None = None,
    comm: Any = None,
    began: float | None = None,
    with_error_bars: bool = False,
    figures: bool = True,
) -> Result:
    """Run a scene; leave its history, profiles, figures and summary in a folder.

    Every rank of the communicator calls this; rank 0 alone writes.

    Parameters
    ----------
    path
        The output folder.
    scene
        What to run.
    screen
        Shows the run, on rank 0.
    comm
        MPI communicator of the run; all ranks of the world if left out.
    began
        `time.perf_counter()` when the command began, for the total time.
    with_error_bars
        Whether the scene is run again, refined, for error bars of the volume.
    figures
        Whether figures and surfaces are made, which takes as long as a short run.

    Returns
    -------
    Result
        As of `simulate`, its status and message the same on all ranks.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be loaded, or finds no C compiler.
    OutputError
        On every rank, before anything is computed, if the folder cannot be written.
    RunLost
        If the folder cannot be written later on.
    KeyboardInterrupt
        If the runs for the error bars are interrupted; the folder is complete without them.
    """
    importing = perf_counter()
    began = importing if began is None else began
    with ExitStack() as stack:
        try:
            from mpi4py import MPI

            comm = MPI.COMM_WORLD if comm is None else comm
            observers: list[Observer] = []
            if screen is not None and comm.rank == 0:
                stack.enter_context(screen)
                observers.append(screen)
            from ._form_cache import CompilerError
            from .simulation import simulate
        except ImportError as error:
            raise DolfinxMissing(str(error)) from None
        import_s = perf_counter() - importing
        folder = _open(path, scene, comm)
        if folder is not None:
            stack.enter_context(folder)
            observers.insert(0, folder)
        try:
            try:
                result = simulate(scene, observer=_All(observers), comm=comm)
                status, message = comm.bcast((result.status, result.message))
                result = replace(result, status=status, message=message)
            except KeyboardInterrupt:
                result = _UNSTARTED
            if folder is not None:
                _complete(folder, scene, result, import_s, began, figures)
            if with_error_bars and result.status != "interrupted":
                from .error_bars import error_bars

                announce = screen.refining if observers and screen is not None else None
                bars = error_bars(scene, result, announce=announce, comm=comm)
                result = replace(result, error_bars=bars)
                if folder is not None:
                    _complete(folder, scene, result, import_s, began, figures)
        except OutputError as error:
            raise RunLost(str(error)) from None
        except CompilerError as error:
            raise DolfinxMissing(str(error)) from None
    return result


def _open(path: Path, scene: Scene, comm: Any) -> OutputFolder | None:
    """Open the folder on rank 0; every rank learns whether that worked."""
    folder, problem = None, None
    if comm.rank == 0:
        try:
            folder = OutputFolder(path, scene)
        except OutputError as error:
            problem = str(error)
    problem = comm.bcast(problem)
    if problem is not None:
        raise OutputError(problem)
    return folder


def _complete(
    folder: OutputFolder, scene: Scene, result: Result, import_s: float, began: float, figures: bool
) -> None:
    """Draw the figures, make the surfaces and write the summary."""
    drawing = perf_counter()
    if figures:
        from . import plots, surface

        with writing(folder.path):
            if len(result.profiles):
                surface.write_surfaces(folder.path, scene, result.profiles)
            plots.draw(
                folder.path,
                scene,
                result.history,
                result.profiles,
                result.status,
                result.error_bars,
            )
    now = perf_counter()
    output_s = result.timings.output_s + now - drawing
    timings = replace(result.timings, import_s=import_s, output_s=output_s, total_s=now - began)
    folder.finish(result, timings)


class _All:
    """Several observers as one."""

    def __init__(self, observers: Sequence[Observer]) -> None:
        self._observers = observers

    def accepted(self, row: Row) -> None:
        for observer in self._observers:
            observer.accepted(row)

    def saved(self, profile: Profile) -> None:
        for observer in self._observers:
            observer.saved(profile)
