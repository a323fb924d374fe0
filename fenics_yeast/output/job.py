"""A scene run into an output folder, on any number of ranks: simulation and summary."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, Self

from ..scene import Scene
from ..simulation import History, Observer, Profiles, Result, Row, Status, Timings
from .folder import OutputError, OutputFolder, OutputWriteError, writing
from .interrupts import Interrupts

if TYPE_CHECKING:
    from ..simulation import Checkpoint, ResumePoint
    from .restart import EarlierRun


class DolfinxMissing(Exception):
    """dolfinx cannot be loaded or compiles nothing; the message is a line that says what to do."""


class Screen(Observer, Protocol):
    """An observer that shows a run between entry and exit."""

    def __enter__(self) -> object: ...

    def __exit__(self, *_: object) -> None: ...

    def resumed(self, row: Row, rows: int) -> None:
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


class Job:
    """A run of a scene into an output folder: a context manager.

        with Job(Path("out/bud"), scene) as job:
            result = job.run()
            job.complete(result, lambda: draw(job.path, result))

    Every rank of the communicator does this; rank 0 alone writes.

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
    resume
        Whether a run of the scene that the folder holds is taken up where it is; where there is
        none the scene is run from the beginning.

    Attributes
    ----------
    path, scene, comm
        As given.
    ended
        What an earlier run found to which nothing is to be added, or None.
    interrupts
        The signals that interrupt the run, an observer.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be loaded, or finds no C compiler.
    OutputError
        On every rank, before anything is computed, if the folder cannot be written, or if what
        it holds cannot be taken up.
    RunLost
        If the folder cannot be written later on.
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
                earlier = self._look_back()
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
                problem = f"{self.path}: its checkpoint {error}; run the scene anew"
                raise OutputError(problem) from None
            if isinstance(error, OutputWriteError):
                advice = self._lose(error)
                raise RunLost(error.problem, advice, everywhere=not self._simulated) from None
            if isinstance(error, RootError):  # on other ranks than 0
                raise RunLost(str(error), "rank 0 tells more", everywhere=True) from None
            if isinstance(error, CompilerError):
                raise DolfinxMissing(str(error)) from None

    def announce_ended(self) -> None:
        """Say that there is nothing to be added to an earlier run."""
        if self._screen is not None and self.ended is not None:
            self._screen.note(f"{self.path}: ended before: {self.ended.message}")

    def run(self) -> Result:
        """Simulate, and keep in the folder all but figures.

        Returns
        -------
        Result
            As of `simulate`, its status and message the same on all ranks. A run that is
            interrupted is told in the result; what interrupts it again waits for `complete`.
        """
        from ..simulation import Observers, simulate

        self._folder = self._open()
        if self._folder is not None:
            self._stack.enter_context(self._folder)
        self._announce_start()
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
        """Let interrupts act again, and make on rank 0 what there may be no time for.

        Raises
        ------
        KeyboardInterrupt
            If a run is interrupted that was not before: the folder holds all but what was made.
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
        """Add to a result what takes further runs, on all ranks, and keep it in the folder.

        Raises
        ------
        KeyboardInterrupt
            If these are interrupted: the folder then holds the result as it was, and says so.
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

    # --- the folder, on rank 0 ------------------------------------------------------------

    def _look_back(self) -> EarlierRun:
        """What the folder holds of an earlier run, read on rank 0; profiles are there alone."""
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

    def _on_root(self, act: Callable[[], Any]) -> Any:
        """What something gives on rank 0; every rank learns whether that worked."""
        found, problem = None, None
        if self.comm.rank == 0:
            try:
                found = act()
            except OutputError as error:
                problem = str(error)
        problem = self.comm.bcast(problem)
        if problem is not None:
            raise OutputError(problem)
        return found

    def _announce_start(self) -> None:
        """Say where an earlier run is taken up, or why it is not."""
        if self._screen is None or not self._resume:
            return
        if self._start is not None:
            self._screen.resumed(self._start.rows[-1], len(self._start.rows))
        elif self.scene.path is not None:
            self._screen.note("a path is not taken up half-way: it starts from the beginning")
        else:
            line = "no checkpoint to go on from; the run starts from the beginning"
            self._screen.note(f"{self.path}: {line}")

    def _keep(self, checkpoint: Checkpoint) -> None:
        if self._folder is not None:
            timings = self._whole(checkpoint.timings)
            self._folder.keep(replace(checkpoint, timings=timings))

    def _finish(self, result: Result, output_s: float = 0.0) -> None:
        if self._folder is not None:
            self._folder.finish(result, self._whole(result.timings, output_s))

    def _whole(self, timings: Timings, output_s: float = 0.0) -> Timings:
        """Timings of the whole command, earlier parts included, in place of a simulation's."""
        assert self._began is not None
        before = Timings() if self._start is None else self._start.checkpoint.timings
        return replace(
            timings,
            import_s=before.import_s + self._import_s,
            output_s=timings.output_s + output_s,
            total_s=before.total_s + perf_counter() - self._began,
        )

    def _cut_short(self, status: Status, message: str = "") -> Result:
        """Result of a run that ended outside of its steps, from what its folder has taken in."""
        rows = () if self._folder is None else self._folder.rows
        when = f"at {rows[-1].time_min:g} min" if rows else "before the first equilibrium"
        before = None if self._start is None else self._start.checkpoint
        return Result(
            history=History(rows),
            profiles=Profiles(() if self._folder is None else self._folder.profiles),
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
        """What to do about a folder that takes in no more; its summary tells, if there is room."""
        then = "run the scene again"
        if self._folder is not None and self._folder.complete:
            then = f"fenics-yeast plot {self.path} draws what lacks"
        elif self._folder is not None:
            with suppress(OutputError):
                result = self._cut_short("failed", error.problem)
                self._folder.summarise(result, self._whole(result.timings))
            if self._folder.can_go_on:
                then = "the same command with --resume goes on"
        return f"once that is mended, {then}"


def run_into(
    path: Path,
    scene: Scene,
    *,
    screen: Screen | None = None,
    comm: Any = None,
    began: float | None = None,
    resume: bool = False,
) -> Result:
    """Run a scene; leave its history, profiles and summary in a folder.

    Parameters and errors are those of `Job`.

    Raises
    ------
    KeyboardInterrupt
        If it is interrupted between its end and the last line of its summary.
    """
    with Job(path, scene, screen=screen, comm=comm, began=began, resume=resume) as job:
        if job.ended is not None:
            job.announce_ended()
            return job.ended
        result = job.run()
        job.complete(result)
        return result
