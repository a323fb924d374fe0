"""Runs the cases of a sweep side by side: in processes of this machine, or on the ranks of MPI.

A case runs alone in its process, into a folder of its own. What ends a case ends no other one:
neither a solver that gives up, nor a process that is killed. Running cases are stopped between
two accepted steps, never half-way through compiling or writing.
"""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Event, Lock, Thread
from typing import Any, Protocol

from ..output import SIGNALS, DolfinxMissing, OutputError, RunLost, run_into, writing
from ..scene import SceneError
from ..simulation import Result
from .cases import Case
from .table import TABLE, CaseRow, finished_row, read_table, row_of, was_cut_short, write_table

# A process that runs cases has one of each.
_STOP = Event()  # its case ends with the step that it is at
_BUSY = Lock()  # held while it runs a case

_KILLED = "its process was killed; the machine may have too little memory for so many at once"
_Ended = Iterator[tuple[Case, str]]  # a case that has ended, and what its folder cannot tell


class SweepScreen(Protocol):
    """Somebody who is told of a sweep as it goes."""

    def begun(self, cases: int, skipped: Sequence[CaseRow]) -> None:
        """Take note of how many cases there are, and which of them were finished before."""

    def ended(self, row: CaseRow) -> None:
        """Take note of a case that has ended."""


def run_sweep(
    directory: Path,
    keys: Sequence[str],
    cases: Sequence[Case],
    *,
    jobs: int = 1,
    comm: Any = None,
    screen: SweepScreen | None = None,
) -> list[CaseRow]:
    """Run the cases that are not finished, each into its folder; write the table as they end.

    Without a communicator the cases run in new processes, which load the main module as
    `multiprocessing` does: in a script this call belongs below ``if __name__ == "__main__"``.

    Parameters
    ----------
    directory
        The folder of the sweep, made where missing.
    keys, cases
        What is varied, and the cases; see `sweep.plan`.
    jobs
        Number of processes.
    comm
        MPI communicator over whose ranks the cases are spread, in place of processes. Every rank
        calls this.
    screen
        Is told of each case; on rank 0 alone.

    Returns
    -------
    list of CaseRow
        A row for each case, in their order; under MPI on rank 0 alone.

    Raises
    ------
    DolfinxMissing
        If dolfinx cannot be loaded.
    OutputError
        If the folder cannot be written, or holds a table that no sweep has left.
    KeyboardInterrupt
        If the sweep is interrupted, once the running cases have stopped.
    """
    problem = None
    if comm is None or comm.rank == 0:
        try:
            _claim(directory)
        except OutputError as error:
            problem = str(error)
    if comm is not None:
        problem = comm.bcast(problem)
    if problem is not None:
        raise OutputError(problem)
    if comm is not None and comm.rank > 0:
        _serve(comm)
        return []
    rows = {case.name: row for case in cases if (row := finished_row(directory, case))}
    left = [case for case in cases if case.name not in rows]
    if screen is not None:
        screen.begun(len(cases), list(rows.values()))
    ended = _on_ranks(directory, left, comm) if comm else _in_processes(directory, left, jobs)
    with closing(ended):  # type: ignore[type-var]
        for case, message in ended:
            rows[case.name] = row = _row(directory, case, message)
            write_table(directory, keys, _in_order(cases, rows))
            if screen is not None:
                screen.ended(row)
    write_table(directory, keys, _in_order(cases, rows))
    return _in_order(cases, rows)


def _claim(directory: Path) -> None:
    """Make the folder; one that holds a table of somebody else is refused."""
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
    if (directory / TABLE).exists():
        read_table(directory)


def _in_order(cases: Sequence[Case], rows: dict[str, CaseRow]) -> list[CaseRow]:
    return [rows[case.name] for case in cases if case.name in rows]


def _row(directory: Path, case: Case, message: str) -> CaseRow:
    """Row of a case that has ended; failed where its folder does not tell how."""
    try:
        row = None if message else row_of(directory, case)
    except (OutputError, SceneError) as error:
        row, message = None, str(error)
    message = message or "it ended without a summary"
    return row or CaseRow(case.name, case.values, "failed", message)


# In a process of its own ----------------------------------------------------------------------


class _UntilStopped:
    """A screen that shows nothing and ends its run where that is asked for."""

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


def _work(directory: Path, case: Case) -> str:
    """Run a case, on from where it was interrupted; give what its folder cannot tell."""
    from mpi4py import MPI

    def run(resume: bool) -> Result:
        place, screen, alone = directory / case.name, _UntilStopped(), MPI.COMM_SELF
        return run_into(place, case.scene, screen=screen, comm=alone, resume=resume)

    with _BUSY:
        try:
            try:
                result = run(resume=was_cut_short(directory, case))
            except OutputError:  # its checkpoint is damaged
                result = run(resume=False)
        except OutputError as error:
            return str(error)
        except RunLost as error:
            return error.problem
        if result.status == "interrupted" and not _STOP.is_set():
            raise KeyboardInterrupt  # that was meant for the whole sweep
    return ""


def _begin(parent: Connection) -> None:
    """Make a new process ready: it ends its case when asked to, or when nobody is left to ask."""

    def watch() -> None:
        parent.poll(None)  # nothing is sent: the other end is closed, or gone with its process
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


def _in_processes(directory: Path, cases: Sequence[Case], jobs: int) -> _Ended:
    """Cases as they end. Those that were under way when a process died run again, one by one."""
    waiting, suspects = deque(cases), deque[Case]()
    while waiting or suspects:
        batch, width = (suspects, 1) if suspects else (waiting, min(jobs, len(waiting)))
        running: dict[Future[str], Case] = {}
        try:
            with _processes(width) as pool:
                while batch or running:
                    while batch and len(running) < width:
                        future = _submit(pool, directory, batch[0])
                        running[future] = batch.popleft()
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        message = _message(future)
                        yield running.pop(future), message
        except BrokenProcessPool:
            if width == 1 and running:
                yield running.popitem()[1], _KILLED
            suspects.extend(running.values())


@contextmanager
def _processes(width: int) -> Iterator[ProcessPoolExecutor]:
    """Pool of processes; left early, it stops their cases and waits for them."""
    context = get_context("spawn")
    theirs, ours = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(width, context, initializer=_begin, initargs=(theirs,))
    try:
        yield pool
    finally:
        try:
            ours.close()
            pool.shutdown(cancel_futures=True)
        except KeyboardInterrupt:  # once more: somebody is in a hurry
            for process in active_children():
                process.kill()
            raise
        finally:
            theirs.close()


def _submit(pool: ProcessPoolExecutor, directory: Path, case: Case) -> Future[str]:
    """Hand a case to the pool. The processes that this starts never hear Ctrl-C, nor does the
    compiler below them: a terminal sends it to all.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return pool.submit(_work, directory, case)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _message(future: Future[str]) -> str:
    try:
        return future.result()
    except (BrokenProcessPool, DolfinxMissing):
        raise
    except Exception as error:
        return f"{type(error).__name__}: {error}"


# Ranks of MPI ---------------------------------------------------------------------------------


def _serve(comm: Any) -> None:
    """Run the cases that rank 0 hands out, until it has no more."""
    for number in SIGNALS:
        signal.signal(number, lambda *_: _STOP.set())
    with _executor(comm):
        return


def _on_ranks(directory: Path, cases: Sequence[Case], comm: Any) -> _Ended:
    """Cases as they end, one at a time on each rank; rank 0 takes from the end of the list."""
    with _executor(comm) as executor:
        waiting: dict[Future[str], Case] = {
            executor.submit(_work, directory, case): case for case in cases
        }
        try:
            while waiting:
                for future in [future for future in waiting if future.done()]:
                    message = _message(future)
                    yield waiting.pop(future), message
                own = next((future for future in reversed(waiting) if future.cancel()), None)
                if own is not None:
                    case = waiting.pop(own)
                    yield case, _work(directory, case)
                elif waiting:
                    wait(waiting, return_when=FIRST_COMPLETED)
        finally:
            for future in waiting:
                future.cancel()


def _executor(comm: Any) -> Any:
    """Executor on rank 0 of a communicator, whose context on the others serves it."""
    import petsc4py
    from mpi4py import MPI
    from mpi4py.futures import MPICommExecutor

    # On all ranks PETSc would wait for all of them wherever one of them first needs it.
    petsc4py.init(["-no_signal_handler"], comm=MPI.COMM_SELF)
    return MPICommExecutor(comm, root=0)
