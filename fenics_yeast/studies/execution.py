"""Run the cases of a sweep in parallel: in processes of this machine, or on MPI ranks.

Each case runs in its own process and directory, so that neither a failed solver nor a killed
process ends other cases. Running cases stop between two accepted steps, never while compiling or
writing.
"""

import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from functools import cache
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, TypeVar

from ..output import SIGNALS, DolfinxMissing, FolderLock, Job, OutputError, RunLost, writing
from ..scene import SceneError
from ..simulation import Result, on_root
from .cases import Case
from .table import TABLE, CaseRow, GrowingTable, is_unfinished, read_table, row_of

if TYPE_CHECKING:
    from ..simulation import ShellPool

P = ParamSpec("P")
T = TypeVar("T")

# One of each per worker process.
_STOP = Event()  # its case ends after the current step
_BUSY = Lock()  # held while it runs a case

_KILLED = "its process was killed; if memory is short, rerun with a smaller --jobs"


class SweepScreen(Protocol):
    """Interface notified of the progress of a sweep."""

    def begun(self, cases: int, skipped: Sequence[CaseRow]) -> None:
        """Receive the number of cases, and those finished before."""

    def ended(self, row: CaseRow) -> None:
        """Receive the row of a case that has ended."""


def run_sweep(
    directory: Path,
    keys: Sequence[str],
    cases: Sequence[Case],
    *,
    jobs: int = 1,
    comm: Any = None,
    screen: SweepScreen | None = None,
) -> list[CaseRow]:
    """Run the unfinished cases, each into its directory; update the table when one ends.

    Without a communicator, the cases run in new processes, which import the main module: in a
    script, put this call below ``if __name__ == "__main__"``.

    Parameters
    ----------
    directory
        The directory of the sweep, created if missing.
    keys, cases
        The varied keys, and the cases; see `plan`.
    jobs
        Number of processes.
    comm
        MPI communicator whose ranks share the cases instead of processes; all ranks must call.
    screen
        Notified of each case, on rank 0 only.

    Returns
    -------
    list of CaseRow
        A row for each case, in their order; under MPI only on rank 0.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be loaded.
    OutputError
        If the directory cannot be written, or its table is not from a sweep.
    KeyboardInterrupt
        If the sweep is interrupted, once the running cases have stopped.
    """
    claimed = (
        _claim(directory) if comm is None else on_root(comm, lambda: _claim(directory), OutputError)
    )
    if claimed is None:  # another rank than 0
        _serve(comm)
        return []
    with claimed:
        return _run_cases(directory, keys, cases, jobs, comm, screen)


def _run_cases(
    directory: Path,
    keys: Sequence[str],
    cases: Sequence[Case],
    jobs: int,
    comm: Any,
    screen: SweepScreen | None,
) -> list[CaseRow]:
    table = GrowingTable(directory, keys, cases)
    left = [case for case in cases if case.name not in table.rows]
    if screen is not None:
        screen.begun(len(cases), list(table.rows.values()))
    ended = _on_ranks(directory, left, comm) if comm else _in_processes(directory, left, jobs)
    try:
        with closing(ended):  # type: ignore[type-var]
            for row in ended:
                table.add(row)
                if screen is not None:
                    screen.ended(row)
    except KeyboardInterrupt:
        table.write()
        raise
    return table.write()


def _claim(directory: Path) -> FolderLock:
    """Create and lock the directory; refuse one whose table is not from a sweep."""
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        lock = FolderLock(directory)
    if (directory / TABLE).exists():
        read_table(directory)
    return lock


def _failed(case: Case, message: str) -> CaseRow:
    return CaseRow(case.name, case.values, "failed", message)


# In a process of its own ----------------------------------------------------------------------


class _UntilStopped:
    """A screen that shows nothing and ends its run on request."""

    def __enter__(self) -> None:
        return

    def __exit__(self, *_: object) -> None:
        return

    def accepted(self, row: object) -> None:
        if _STOP.is_set():
            raise KeyboardInterrupt

    def saved(self, profile: object) -> None:
        return

    def resumed(self, row: object, rows: int) -> None:
        return

    def note(self, line: str) -> None:
        return

    def refining(self, part: str) -> None:
        return


def stopping() -> bool:
    """Return whether the work of this process is to end soon."""
    return _STOP.is_set()


@cache
def shells_of_process() -> "ShellPool":
    """Return the shells that all cases of this process share."""
    from ..simulation import ShellPool

    return ShellPool()


def _work(directory: Path, case: Case) -> CaseRow:
    """Run or resume a case; return its row, failed if its directory does not say how it ended."""
    from .._mpi import MPI

    def run(resume: bool) -> Result:
        place, screen, alone = directory / case.name, _UntilStopped(), MPI.COMM_SELF
        with Job(
            place, case.scene, screen=screen, comm=alone, resume=resume, shells=shells_of_process()
        ) as job:
            result = job.run()
            job.complete(result)
            return result

    with _BUSY:
        try:
            try:
                result = run(resume=is_unfinished(directory, case))
            except OutputError:  # its checkpoint is damaged
                result = run(resume=False)
        except OutputError as error:
            return _failed(case, str(error))
        except RunLost as error:
            return _failed(case, error.problem)
        if result.status == "interrupted" and not _STOP.is_set():
            raise KeyboardInterrupt  # it was meant for the whole sweep
        try:
            row = row_of(directory, case)
        except (OutputError, SceneError) as error:
            return _failed(case, str(error))
    return row or _failed(case, "ended without run.json; rerun the sweep to try again")


def _begin(parent: Connection) -> None:
    """Prepare a new process: it ends its case on request, or when its parent has gone."""

    def watch() -> None:
        parent.poll(None)  # nothing is sent; the other end closes, also when its process dies
        _STOP.set()
        process = parent_process()
        if process is not None:
            process.join()
        with _BUSY:
            os._exit(1)

    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda *_: _STOP.set())
    Thread(target=watch, daemon=True).start()


# Processes of this machine --------------------------------------------------------------------


def _in_processes(directory: Path, cases: Sequence[Case], jobs: int) -> Iterator[CaseRow]:
    """Yield the rows of cases as they end. Those running when a process dies are rerun one by one.

    The next case runs while a row is used.
    """
    waiting, suspects, ended = deque(cases), deque[Case](), deque[CaseRow]()
    while waiting or suspects:
        batch, width = (suspects, 1) if suspects else (waiting, min(jobs, len(waiting)))
        running: dict[Future[CaseRow], Case] = {}
        try:
            with processes(width) as pool:
                while batch or running:
                    while batch and len(running) < width:
                        future = submit(pool, _work, directory, batch[0])
                        running[future] = batch.popleft()
                    while ended:
                        yield ended.popleft()
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        ended.append(_row(future, running[future]))
                        del running[future]
        except BrokenProcessPool:
            if width == 1 and running:
                ended.append(_failed(running.popitem()[1], _KILLED))
            suspects.extend(running.values())
        while ended:
            yield ended.popleft()


@contextmanager
def processes(width: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes; if left early, stop their cases and wait for them."""
    context = get_context("spawn")
    theirs, ours = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(width, context, initializer=_begin, initargs=(theirs,))
    try:
        yield pool
    finally:
        try:
            ours.close()
            pool.shutdown(cancel_futures=True)
        except KeyboardInterrupt:  # a second Ctrl-C: do not wait
            for process in active_children():
                process.kill()
            raise
        finally:
            theirs.close()


def submit(
    pool: ProcessPoolExecutor, work: Callable[P, T], *of: P.args, **by: P.kwargs
) -> Future[T]:
    """Submit work; new processes, and compilers below them, ignore the terminal's Ctrl-C."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return pool.submit(work, *of, **by)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _row(future: Future[CaseRow], case: Case) -> CaseRow:
    try:
        return future.result()
    except (BrokenProcessPool, DolfinxMissing):
        raise
    except Exception as error:
        return _failed(case, f"{type(error).__name__}: {error}")


# Ranks of MPI ---------------------------------------------------------------------------------


def _serve(comm: Any) -> None:
    """Run the cases that rank 0 sends, until it has no more."""
    for number in SIGNALS:
        signal.signal(number, lambda *_: _STOP.set())
    with _executor(comm):
        return


def _on_ranks(directory: Path, cases: Sequence[Case], comm: Any) -> Iterator[CaseRow]:
    """Yield the rows of cases as they end, one per rank at a time; rank 0 takes the last ones."""
    with _executor(comm) as executor:
        waiting: dict[Future[CaseRow], Case] = {
            executor.submit(_work, directory, case): case for case in cases
        }
        try:
            while waiting:
                for future in [future for future in waiting if future.done()]:
                    row = _row(future, waiting[future])
                    del waiting[future]
                    yield row
                own = next((future for future in reversed(waiting) if future.cancel()), None)
                if own is not None:
                    yield _work(directory, waiting.pop(own))
                elif waiting:
                    wait(waiting, return_when=FIRST_COMPLETED)
        finally:
            for future in waiting:
                future.cancel()


def _executor(comm: Any) -> Any:
    """Return an executor on rank 0; on other ranks, its context runs what it submits."""
    import petsc4py
    from mpi4py.futures import MPICommExecutor

    from .._mpi import MPI

    # Otherwise PETSc would wait for all ranks whenever one of them first needs it.
    petsc4py.init(["-no_signal_handler"], comm=MPI.COMM_SELF)
    return MPICommExecutor(comm, root=0)
