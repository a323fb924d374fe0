"""Run a scene into an output directory, on any number of ranks."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

from ..scene import Scene
from ..simulation import History, Observer, Profiles, Result, Row, Status, Timings, discretise
from .errors import DolfinxMissing, OutputError, OutputWriteError, RunLost
from .files import writing
from .folder import OutputFolder
from .interrupts import Interrupts

if TYPE_CHECKING:
    from ..simulation import Checkpoint, ResumePoint
    from .restart import EarlierRun


T = TypeVar("T")


class Screen(Observer, Protocol):
    """An observer that shows a run; a context manager."""

    def __enter__(self) -> object: ...

    def __exit__(self, *_: object) -> None: ...

    def resumed(self, row: Row, rows: int) -> None:
        """Show the row from which an earlier run resumes, and their number."""

    def note(self, line: str) -> None:
        """Show a line."""

    def refining(self, part: str) -> None:
        """Show which part of the numerics is refined for the error bars."""


class Job:
    """A run of a scene into an output directory; a context manager.

        with Job(Path("out/bud"), scene) as job:
            result = job.run()
            job.complete(result, lambda: draw(job.path, result))

    Every rank of the communicator does this; only rank 0 writes.

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
        Whether to resume a run of the scene in the directory, if there is one.

    Attributes
    ----------
    path, scene, comm
        As given.
    ended
        Result of an earlier run, if nothing remains to be computed, or None.
    interrupts
        Signals that interrupt the run, an observer.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be loaded, or finds no C compiler.
    OutputError
        On every rank, before anything is computed, if the directory cannot be written, or if the
        run in it cannot be resumed.
    RunLost
        If the directory cannot be written later.
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
    ) -> None:
        self.path, self.scene, self.comm = path, scene, comm
        self.ended: Result | None = None
        self._screen, self._resume, self._began = screen, resume, began
        self._stack = ExitStack()
        self._folder: OutputFolder | None = None
        self._start: ResumePoint | None = None
        self._simulated = False

    def __enter__(self) -> Self:
        with self._stack as stack:  # closed here if anything below fails
            importing = perf_counter()
            try:
                from mpi4py import MPI

                self.comm = MPI.COMM_WORLD if self.comm is None else self.comm
                if self.comm.rank > 0:
                    self._screen = None
                if self._screen is not None:
                    stack.enter_context(self._screen)
                from ..simulation import simulate  # noqa: F401
            except ImportError as error:
                raise DolfinxMissing(str(error)) from None
            self._import_s = perf_counter() - importing
            self._began = importing if self._began is None else self._began
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
        from ..simulation import CheckpointError, RootError

        with self._stack:
            if isinstance(error, CheckpointError):
                problem = f"{self.path}: its checkpoint {error}; rerun the scene without --resume"
                raise OutputError(problem) from None
            if isinstance(error, OutputWriteError):
                advice = self._lose(error)
                raise RunLost(error.problem, advice, everywhere=not self._simulated) from None
            if isinstance(error, RootError):  # on other ranks than 0
                raise RunLost(str(error), "see the message of rank 0", everywhere=True) from None
            if isinstance(error, CompilerError):
                raise DolfinxMissing(str(error)) from None

    def note_ended(self) -> None:
        """Show that an earlier run had ended."""
        if self._screen is not None and self.ended is not None:
            self._screen.note(f"{self.path}: already complete: {self.ended.message}")

    def run(self) -> Result:
        """Simulate, and write everything but figures.

        Returns
        -------
        Result
            As from `simulate`, with the same status and message on all ranks. It reports an
            interrupt; further ones wait for `complete`.
        """
        from ..simulation import Observers, simulate

        self._folder = self._open()
        if self._folder is not None:
            self._stack.enter_context(self._folder)
        self._note_start()
        self._stack.enter_context(self.interrupts)
        observers: list[Observer] = []
        if self.comm.rank == 0:
            watching = (self._folder, self._screen, self.interrupts)
            observers = [each for each in watching if each is not None]
        try:
            result = simulate(
                self.scene,
                observer=Observers(observers),
                comm=self.comm,
                start=self._start,
                keep=self._keep,
            )
            self._simulated = True
            status, message = self.comm.bcast((result.status, result.message))
            if status == "failed" and self.interrupts.acted:
                status, message = "interrupted", f"interrupted at {result.end_time:g} min"
            result = replace(result, status=status, message=message)
            self.interrupts.hold()
        except KeyboardInterrupt:
            result = self._cut_short("interrupted")
        self._finish(result)
        return result

    def complete(self, result: Result, make: Callable[[], object] | None = None) -> None:
        """Let interrupts act again, and make figures and the like on rank 0.

        Raises
        ------
        KeyboardInterrupt
            If this is interrupted and the run was not; only what was being made is missing.
        """
        if self._folder is None:
            return
        began = perf_counter()
        try:
            self.interrupts.release()
            if make is not None:
                with writing(self.path):
                    make()
        except KeyboardInterrupt:
            if result.status != "interrupted":
                raise
        self._finish(result, perf_counter() - began)

    def extend(self, result: Result, compute: Callable[[], Result], what: str) -> Result:
        """Extend a result by further runs, on all ranks, and write it.

        Raises
        ------
        KeyboardInterrupt
            If these are interrupted; the directory keeps the result as it was, with a note.
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

    # --- the directory, on rank 0 ------------------------------------------------------------

    def _find_earlier_run(self) -> EarlierRun:
        """Return the earlier run in the directory, its profiles only on rank 0."""
        from .restart import EarlierRun, find_earlier_run

        earlier = self._on_root(lambda: find_earlier_run(self.path, self.scene))
        others = None
        if earlier is not None:
            start = earlier.start and replace(earlier.start, profiles=())
            others = EarlierRun(start, earlier.ended)
        others = self.comm.bcast(others)
        return others if earlier is None else earlier

    def _open(self) -> OutputFolder | None:
        return self._on_root(lambda: OutputFolder(self.path, self.scene, self._start))

    def _on_root(self, act: Callable[[], T]) -> T | None:
        """Act on rank 0; every rank learns whether that worked."""
        from ..simulation import RootError, on_root

        try:
            return on_root(self.comm, act)
        except RootError as error:
            cause = error.__cause__
            if cause is not None and not isinstance(cause, OutputError):
                raise cause from None
            raise OutputError(str(cause or error)) from None

    def _note_start(self) -> None:
        """Show where an earlier run resumes, or why it does not."""
        if self._screen is None or not self._resume:
            return
        if self._start is not None:
            self._screen.resumed(self._start.rows[-1], len(self._start.rows))
        elif self.scene.path is not None:
            self._screen.note("a path cannot be resumed; starting from the beginning")
        else:
            self._screen.note(f"{self.path}: no checkpoint; starting from the beginning")

    def _keep(self, checkpoint: Checkpoint) -> None:
        if self._folder is not None:
            timings = self._whole(checkpoint.timings)
            self._folder.keep(replace(checkpoint, timings=timings))

    def _finish(self, result: Result, output_s: float = 0.0) -> None:
        if self._folder is not None:
            self._folder.finish(result, self._whole(result.timings, output_s))

    def _whole(self, timings: Timings, output_s: float = 0.0) -> Timings:
        """Return the timings of the whole command, including earlier parts of the run."""
        assert self._began is not None
        before = Timings() if self._start is None else self._start.checkpoint.timings
        return replace(
            timings,
            import_s=before.import_s + self._import_s,
            output_s=timings.output_s + output_s,
            total_s=before.total_s + perf_counter() - self._began,
        )

    def _cut_short(self, status: Status, message: str = "") -> Result:
        """Return the result of a run that ended outside its steps, from its directory."""
        rows = () if self._folder is None else self._folder.rows
        profiles = () if self._folder is None else self._folder.profiles
        when = f"at {rows[-1].time_min:g} min" if rows else "before the first equilibrium"
        before = None if self._start is None else self._start.checkpoint
        return Result(
            history=History(rows),
            profiles=Profiles(profiles, discretise(self.scene).zones),
            status=status,
            message=message or f"{status} {when}",
            end_time=rows[-1].time_min if rows else 0.0,
            dofs=0,
            steps=max(0, len(rows) - 1),
            rejected_steps=0 if before is None else before.recorder.rejected,
            newton_iterations=0 if before is None else before.recorder.iterations,
            timings=Timings() if before is None else before.timings,
        )

    def _lose(self, error: OutputWriteError) -> str:
        """Write the summary if there is room; return what to do about an unwritable directory."""
        advice = "fix this, then rerun the scene"
        if self._folder is not None and self._folder.complete:
            advice = f"to create missing figures, run: fenics-yeast plot {self.path}"
        elif self._folder is not None:
            with suppress(OutputError):
                result = self._cut_short("failed", error.problem)
                self._folder.summarise(result, self._whole(result.timings))
            if self._folder.can_resume:
                advice = "fix this, then rerun with --resume"
        return advice


def run_into(
    path: Path,
    scene: Scene,
    *,
    screen: Screen | None = None,
    comm: Any = None,
    began: float | None = None,
    resume: bool = False,
) -> Result:
    """Run a scene; write history, profiles and summary to a directory.

    Parameters and errors are those of `Job`.

    Raises
    ------
    KeyboardInterrupt
        If it is interrupted between its end and the last line of its summary.
    """
    with Job(path, scene, screen=screen, comm=comm, began=began, resume=resume) as job:
        if job.ended is not None:
            job.note_ended()
            return job.ended
        result = job.run()
        job.complete(result)
        return result
