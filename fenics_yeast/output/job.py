"""Run a scene into an output directory, on any number of ranks."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from shlex import quote
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, Self

from ..scene import Scene
from ..simulation import (
    History,
    Observer,
    Profiles,
    Result,
    RootError,
    Row,
    Status,
    Timings,
    discretise,
    kinks,
    on_root,
)
from .errors import DolfinxMissing, OutputError, OutputWriteError, RunLost
from .files import writing
from .folder import OutputFolder
from .interrupts import Interrupts
from .outline import with_unloaded_shape

if TYPE_CHECKING:
    from ..simulation import Checkpoint, ResumePoint, ShellPool
    from .restart import EarlierRun


class Screen(Observer, Protocol):
    """An observer that shows a run between entry and exit."""

    def __enter__(self) -> object: ...

    def __exit__(self, *_: object) -> None: ...

    def resumed(self, row: Row, rows: int) -> None:
        """Show from which row an earlier run resumes, and its number."""

    def note(self, line: str) -> None:
        """Show a line."""

    def refining(self, part: str) -> None:
        """Show that a run is repeated with one part refined, for the error bars."""


def failed_figures(directory: Path, make: Callable[[], object]) -> str | None:
    """Make the figures of an output directory; return a warning if that fails."""
    try:
        with writing(directory):
            make()
    except OutputWriteError as error:
        reason = error.problem
    except Exception as error:  # a library, a font, a user's settings of matplotlib
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
    else:
        return None
    command = f"fenics-yeast plot {quote(str(directory))}"
    return f"figures are missing ({reason}); to create them, run: {command}"


class Job:
    """A run of a scene into an output directory: a context manager, entered on every rank.

        with Job(Path("out/bud"), scene) as job:
            result = job.run()
            job.complete(result, lambda: failed_figures(job.path, lambda: draw(job.path, result)))

    Parameters
    ----------
    path
        The output directory.
    scene
        What to run.
    screen
        Shows the run, on rank 0.
    comm
        MPI communicator of the run; by default all ranks of the world.
    began
        `time.perf_counter()` when the command began, for the total time.
    resume
        Whether to resume the run in the directory, if it has a checkpoint.
    shells
        Lends the shell of the run to it; by default it is built for this run.

    Attributes
    ----------
    ended
        Result of an earlier run to which nothing remains to be added, or None.
    interrupts
        The signals that interrupt the run: an observer.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be imported or finds no C compiler.
    OutputError
        If, before anything is computed, the directory cannot be written or the run in it cannot
        be resumed; on every rank.
    RunLost
        If the directory cannot be written later on.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        *,
        screen: Screen | None = None,
        comm: Any = None,
        began: float | None = None,
        resume: bool = False,
        shells: ShellPool | None = None,
    ) -> None:
        self.path, self.scene, self.comm = path, scene, comm
        self.ended: Result | None = None
        self._screen, self._resume, self._shells = screen, resume, shells
        self._began = perf_counter() if began is None else began
        self._stack = ExitStack()
        self._folder: OutputFolder | None = None
        self._start: ResumePoint | None = None
        self._simulated = False

    def __enter__(self) -> Self:
        with self._stack as stack:  # closed here if anything below fails
            self._import_dolfinx(stack)
            if self._resume:
                earlier = self._find_earlier_run()
                self._start, self.ended = earlier.start, earlier.ended
            self.interrupts = Interrupts(self.comm)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        from .._form_cache import CompilerError
        from ..simulation import CheckpointError
        from .restart import FROM_START

        with self._stack:
            if isinstance(error, CheckpointError):
                problem = f"{self.path}: its checkpoint {error}; {FROM_START}"
                raise OutputError(problem) from None
            if isinstance(error, OutputWriteError):
                advice = self._advice(error)
                raise RunLost(error.problem, advice, everywhere=not self._simulated) from None
            if isinstance(error, RootError) and self.comm.rank > 0:
                raise RunLost(str(error), "see the message of rank 0", everywhere=True) from None
            if isinstance(error, CompilerError):
                raise DolfinxMissing(str(error)) from None

    def note_ended(self) -> None:
        """Show that nothing remains to be added to an earlier run."""
        if self._screen is not None and self.ended is not None:
            self._screen.note(f"{self.path}: already complete; {self.ended.message}")

    def run(self) -> Result:
        """Simulate; write all but figures.

        Returns
        -------
        Result
            As of `simulate`, with the same status and message on all ranks. If the run is
            interrupted, the result says so; a second interrupt waits for `complete`.
        """
        note = None if self._screen is None else self._screen.note
        self.scene, problem = with_unloaded_shape(self.scene, self._start, self.comm, note)
        self._folder = on_root(
            self.comm, lambda: OutputFolder(self.path, self.scene, self._start), OutputError
        )
        if self._folder is not None:
            self._stack.enter_context(self._folder)
        if self._resume:
            self._note_start()
        self._stack.enter_context(self.interrupts)
        try:
            result = self._ended_early("failed", problem) if problem else self._simulate()
            self.interrupts.hold()
        except KeyboardInterrupt:
            result = self._ended_early("interrupted")
        self._finish(result)
        return result

    def complete(self, result: Result, make: Callable[[], str | None] | None = None) -> Result:
        """Let interrupts act again, and make on rank 0 what may be interrupted or fail: figures.

        Returns the result, on rank 0 with the warning that `make` returns if it failed. Without
        `make`, nothing is written.

        Raises
        ------
        KeyboardInterrupt
            If a run is interrupted that was not before; what has been written is complete but for
            what `make` makes.
        """
        if self._folder is None:
            return result
        began, failed = perf_counter(), None
        try:
            self.interrupts.release()
            if make is None:
                return result
            failed = make()
        except KeyboardInterrupt:
            if result.status != "interrupted":
                raise
        if failed is None:
            self._finish(result, perf_counter() - began)
            return result
        result = replace(result, warnings=(*result.warnings, failed))
        with suppress(OutputError):  # as on a full disk; the summary was written before
            self._finish(result, perf_counter() - began)
        return result

    def extend(self, result: Result, compute: Callable[[], Result], what: str) -> Result:
        """Add to a result what takes further runs, on all ranks, and write it.

        Raises
        ------
        KeyboardInterrupt
            If these are interrupted; the summary then has the result as it was and says so.
        """
        try:
            result = compute()
        except KeyboardInterrupt:
            message = f"{result.message}; the {what} were interrupted"
            self._finish(replace(result, message=message))
            raise
        self.interrupts.hold()
        self._finish(result)
        return result

    # --- before the run -------------------------------------------------------------------

    def _import_dolfinx(self, stack: ExitStack) -> None:
        """Import dolfinx, with the screen shown meanwhile."""
        began = perf_counter()
        try:
            from .._mpi import MPI

            self.comm = MPI.COMM_WORLD if self.comm is None else self.comm
            if self.comm.rank > 0:
                self._screen = None
            if self._screen is not None:
                stack.enter_context(self._screen)
            from ..simulation import simulate  # noqa: F401
        except ImportError as error:
            raise DolfinxMissing(str(error)) from None
        self._import_s = perf_counter() - began

    def _find_earlier_run(self) -> EarlierRun:
        """What the directory has of an earlier run, read on rank 0; only it has the profiles."""
        from .restart import EarlierRun, find_earlier_run

        found = on_root(self.comm, lambda: find_earlier_run(self.path, self.scene), OutputError)
        start = replace(found.start, profiles=()) if found and found.start else None
        others = self.comm.bcast(EarlierRun(start, found.ended) if found else None)
        return found or others

    def _note_start(self) -> None:
        """Show from where an earlier run resumes, or why it does not."""
        if self._screen is None:
            return
        if self._start is not None:
            self._screen.resumed(self._start.rows[-1], len(self._start.rows))
            return
        reason = "no checkpoint"
        if self.scene.path is not None:
            reason = "an equilibrium path cannot be resumed"
        self._screen.note(f"{self.path}: {reason}; starting from the beginning")

    # --- the run and its end --------------------------------------------------------------

    def _simulate(self) -> Result:
        """Run the simulation; its end is the same on all ranks."""
        from ..simulation import Observers, simulate

        watching = (self._folder, self._screen, self.interrupts) if self.comm.rank == 0 else ()
        observers = Observers([each for each in watching if each is not None])
        result = simulate(
            self.scene, observer=observers, comm=self.comm, start=self._start, keep=self._keep,
            shells=self._shells,
        )  # fmt: skip
        self._simulated = True
        status, message = self.comm.bcast((result.status, result.message))
        if status == "failed" and self.interrupts.acted:  # an error that PETSc made of it
            status, message = "interrupted", f"interrupted at {result.end_time:g} min"
        return replace(result, status=status, message=message)

    def _keep(self, checkpoint: Checkpoint) -> None:
        if self._folder is not None:
            timings = self._whole(checkpoint.timings)
            self._folder.keep(replace(checkpoint, timings=timings))

    def _finish(self, result: Result, output_s: float = 0.0) -> None:
        if self._folder is not None:
            self._folder.finish(result, self._whole(result.timings, output_s))

    def _whole(self, timings: Timings, output_s: float = 0.0) -> Timings:
        """Timings of the whole command, earlier parts of the run included."""
        before = Timings() if self._start is None else self._start.checkpoint.timings
        return replace(
            timings,
            import_s=before.import_s + self._import_s,
            output_s=timings.output_s + output_s,
            total_s=before.total_s + perf_counter() - self._began,
        )

    def _ended_early(self, status: Status, message: str = "") -> Result:
        """Result of a run that ended outside of its steps, from what has been written."""
        folder = self._folder
        rows, profiles = ([], []) if folder is None else (folder.rows, folder.profiles)
        before = None if self._start is None else self._start.checkpoint
        when = f"at {rows[-1].time_min:g} min" if rows else "before the first equilibrium"
        return Result(
            history=History(rows, kinks(self.scene)),
            profiles=Profiles(tuple(profiles), discretise(self.scene).zones if rows else ()),
            status=status,
            message=message or f"{status} {when}",
            end_time=rows[-1].time_min if rows else 0.0,
            dofs=0,
            steps=max(0, len(rows) - 1),
            rejected_steps=before.recorder.rejected if before else 0,
            newton_iterations=before.recorder.iterations if before else 0,
            timings=before.timings if before else Timings(),
        )

    def _advice(self, error: OutputWriteError) -> str:
        """What to do when the directory can no longer be written; in the summary, if it can be."""
        if self._folder is None:
            return "fix this, then rerun the scene"
        with suppress(OutputError):
            result = self._ended_early("failed", error.problem)
            self._folder.summarise(result, self._whole(result.timings))
        return f"fix this, then rerun {'with --resume' if self._folder.can_resume else 'the scene'}"
