"""A scene run into an output folder: simulation, figures, summary, on any number of ranks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from .interrupts import Interrupts
from .output import OutputError, OutputFolder, Unwritable, writing
from .record import History, Observer, Profile, Profiles, Result, Row, Status, Timings
from .scene import Scene

if TYPE_CHECKING:
    from .checkpoint import Checkpoint, Start
    from .restart import Past

T = TypeVar("T")


class DolfinxMissing(Exception):
    """dolfinx cannot be loaded or compiles nothing; the message is a line that says what to do."""


class Screen(Observer, Protocol):
    """An observer that shows a run between entry and exit."""

    def __enter__(self) -> object: ...

    def __exit__(self, *_: object) -> None: ...

    def taken_up(self, row: Row, rows: int) -> None:
        """Take note of the row from which an earlier run goes on, the last of so many."""

    def note(self, line: str) -> None:
        """Show a line to the user."""

    def refining(self, part: str) -> None:
        """Take note of a run that is refined in one part, for the error bars."""


class RunLost(Exception):
    """The folder stopped taking in the run half-way, as a full disk does.

    The message is a line that says what to do, `problem` the line without that. Where it is not
    raised `everywhere` other ranks still wait for rank 0.
    """

    def __init__(self, problem: str, advice: str, *, everywhere: bool) -> None:
        super().__init__(f"{problem}; {advice}")
        self.problem, self.everywhere = problem, everywhere


def run_into(
    path: Path,
    scene: Scene,
    *,
    screen: Screen | None = None,
    comm: Any = None,
    began: float | None = None,
    with_error_bars: bool = False,
    figures: bool = True,
    resume: bool = False,
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
    resume
        Whether a run of the scene that the folder holds is taken up where it is; where there is
        none the scene is run from the beginning.

    Returns
    -------
    Result
        As of `simulate`, its status and message the same on all ranks.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be loaded, or finds no C compiler.
    OutputError
        On every rank, before anything is computed, if the folder cannot be written, or if what
        it holds cannot be taken up.
    RunLost
        If the folder cannot be written later on.
    KeyboardInterrupt
        If figures or runs for the error bars are interrupted: the folder holds all but those. A
        run that is interrupted is told in the result; whatever interrupts it again waits until
        the folder holds what was computed.
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
            from .checkpoint import CheckpointError
            from .journal import ObserverError
            from .restart import Past
            from .simulation import simulate
        except ImportError as error:
            raise DolfinxMissing(str(error)) from None
        import_s = perf_counter() - importing
        past = _look_back(path, scene, comm) if resume else Past()
        if past.ended is not None and (past.ended.error_bars or not with_error_bars):
            _announce(observers, screen, f"{path}: ended before: {past.ended.message}")
            return past.ended
        folder = _open(path, scene, comm, past.start)
        if folder is not None:
            stack.enter_context(folder)
            observers.insert(0, folder)
        if resume and past.start is None:
            _announce(observers, screen, _nothing(path, scene))
        elif observers and screen is not None and past.start is not None:
            screen.taken_up(past.start.rows[-1], len(past.start.rows))
        interrupts = stack.enter_context(Interrupts(comm))
        if comm.rank == 0:
            observers.append(interrupts)
        clock = _Clock(began, import_s, past.start)

        def keep(checkpoint: Checkpoint) -> None:
            if folder is not None:
                folder.keep(replace(checkpoint, timings=clock.whole(checkpoint.timings)))

        simulated = False
        try:
            try:
                observer = _All(observers)
                result = simulate(scene, observer=observer, comm=comm, start=past.start, keep=keep)
                simulated = True
                status, message = comm.bcast((result.status, result.message))
                if status == "failed" and interrupts.acted:
                    status, message = "interrupted", f"interrupted at {result.end_time:g} min"
                result = replace(result, status=status, message=message)
                interrupts.hold()
            except KeyboardInterrupt:
                result = _cut_short(folder, past.start, "interrupted")
            if folder is not None:
                _complete(folder, scene, result, clock, figures, interrupts)
            if with_error_bars and result.status != "interrupted":
                from .error_bars import error_bars

                announce = screen.refining if observers and screen is not None else None
                try:
                    bars = error_bars(
                        scene, result, announce=announce, observer=interrupts, comm=comm
                    )
                except KeyboardInterrupt:
                    message = f"{result.message}; the error bars were interrupted"
                    if folder is not None:
                        folder.finish(replace(result, message=message), clock.whole(result.timings))
                    raise
                result = replace(result, error_bars=bars)
                interrupts.hold()
                if folder is not None:
                    _complete(folder, scene, result, clock, figures, interrupts)
        except CheckpointError as error:
            raise OutputError(f"{path}: its checkpoint {error}; run the scene anew") from None
        except Unwritable as error:
            advice = _lose(folder, error, past.start, clock)
            raise RunLost(error.problem, advice, everywhere=not simulated) from None
        except ObserverError as error:  # on other ranks than 0
            raise RunLost(str(error), "rank 0 tells more", everywhere=True) from None
        except CompilerError as error:
            raise DolfinxMissing(str(error)) from None
    return result


def _look_back(path: Path, scene: Scene, comm: Any) -> Past:
    """What the folder holds of an earlier run, read on rank 0 for all; profiles on rank 0 alone."""
    from .restart import Past, look_back

    past = _on_root(comm, lambda: look_back(path, scene))
    others = None
    if past is not None:
        start = past.start and replace(past.start, profiles=())
        others = Past(start, past.ended)
    others = comm.bcast(others)
    return others if past is None else past


def _open(path: Path, scene: Scene, comm: Any, start: Start | None) -> OutputFolder | None:
    """Open the folder on rank 0."""
    return _on_root(comm, lambda: OutputFolder(path, scene, start))


def _on_root(comm: Any, act: Callable[[], T]) -> T | None:
    """What something gives on rank 0; every rank learns whether that worked."""
    found, problem = None, None
    if comm.rank == 0:
        try:
            found = act()
        except OutputError as error:
            problem = str(error)
    problem = comm.bcast(problem)
    if problem is not None:
        raise OutputError(problem)
    return found


def _announce(observers: Sequence[Observer], screen: Screen | None, line: str) -> None:
    """Show a line on rank 0, which alone has observers."""
    if observers and screen is not None:
        screen.note(line)


def _nothing(path: Path, scene: Scene) -> str:
    """Why a run is not taken up."""
    if scene.path is not None:
        return "a path is not taken up half-way: it starts from the beginning"
    return f"{path}: no checkpoint to go on from; the run starts from the beginning"


def _cut_short(
    folder: OutputFolder | None, start: Start | None, status: Status, message: str = ""
) -> Result:
    """Result of a run that ended outside of its steps, from what its folder has taken in."""
    rows = () if folder is None else folder.rows
    when = f"at {rows[-1].time_min:g} min" if rows else "before the first equilibrium"
    return Result(
        history=History(rows),
        profiles=Profiles(() if folder is None else folder.profiles),
        status=status,
        message=message or f"{status} {when}",
        end_time=rows[-1].time_min if rows else 0.0,
        dofs=0,
        steps=max(0, len(rows) - 1),
        rejected_steps=0 if start is None else start.checkpoint.tally.rejected,
        newton_iterations=0 if start is None else start.checkpoint.tally.iterations,
        timings=Timings() if start is None else start.checkpoint.timings,
    )


def _lose(
    folder: OutputFolder | None, error: Unwritable, start: Start | None, clock: _Clock
) -> str:
    """What to do about a folder that takes in no more; its summary tells, if there is room."""
    then = "run the scene again"
    if folder is not None and folder.complete:
        then = f"fenics-yeast plot {folder.path} draws what lacks"
    elif folder is not None:
        with suppress(OutputError):
            result = _cut_short(folder, start, "failed", error.problem)
            folder.summarise(result, clock.whole(result.timings))
        if folder.can_go_on:
            then = "the same command with --resume goes on"
    return f"once that is mended, {then}"


class _Clock:
    """Times of the whole command in place of those of a simulation, earlier parts included."""

    def __init__(self, began: float, import_s: float, start: Start | None) -> None:
        before = Timings() if start is None else start.checkpoint.timings
        self._began, self._before = began, before.total_s
        self._import_s = before.import_s + import_s

    def whole(self, timings: Timings, output_s: float = 0.0) -> Timings:
        """Add what a simulation does not know, and more seconds of output."""
        return replace(
            timings,
            import_s=self._import_s,
            output_s=timings.output_s + output_s,
            total_s=self._before + perf_counter() - self._began,
        )


def _complete(
    folder: OutputFolder,
    scene: Scene,
    result: Result,
    clock: _Clock,
    figures: bool,
    interrupts: Interrupts,
) -> None:
    """Write the summary, draw the figures and make the surfaces, for which there may be no time."""
    folder.finish(result, clock.whole(result.timings))
    drawing = perf_counter()
    try:
        interrupts.release()
        if figures:
            _draw(folder.path, scene, result)
    except KeyboardInterrupt:
        if result.status != "interrupted":
            raise
    folder.finish(result, clock.whole(result.timings, perf_counter() - drawing))


def _draw(path: Path, scene: Scene, result: Result) -> None:
    from . import plots, surface

    found = result.history, result.profiles, result.status, result.error_bars
    with writing(path):
        if len(result.profiles):
            surface.write_surfaces(path, scene, result.profiles)
        plots.draw(path, scene, *found)


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
