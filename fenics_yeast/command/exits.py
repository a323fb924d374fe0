"""How a command ends: exit status, message and signals."""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import typer

from ..output import SIGNALS, interrupt
from ..simulation import EXIT_STATUS

BROKEN, BAD_INPUT = 1, 2
FAILED, INTERRUPTED = EXIT_STATUS["failed"], EXIT_STATUS["interrupted"]
_NO_ERROR = EXIT_STATUS["no-equilibrium"], INTERRUPTED
# Set by mpirun and srun for each rank. Without them MPI is not loaded, because a process that has
# initialised it cannot start another that would.
_LAUNCHED = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK")


def fail(message: str, status: int) -> NoReturn:
    """End the command with a message from rank 0."""
    comm = launched()
    if comm is None or comm.rank == 0:
        kind = "" if status in _NO_ERROR else "error: "
        typer.echo(kind + message, err=True)
    raise typer.Exit(status)


def abandon(message: str) -> NoReturn:
    """End all ranks from rank 0, where the output directory became unwritable."""
    comm = launched()
    if comm is not None:
        typer.echo(f"error: {message}", err=True)
        comm.Abort(BROKEN)
    fail(message, BROKEN)


def launched() -> Any:
    """Return the communicator of all ranks under mpirun; None for one rank, or without MPI."""
    if not is_rank():
        return None
    try:
        from .._mpi import MPI
    except ImportError:
        return None
    return MPI.COMM_WORLD if MPI.COMM_WORLD.size > 1 else None


def is_rank() -> bool:
    """Return whether mpirun or srun started this process, perhaps as the only rank."""
    return any(name in os.environ for name in _LAUNCHED)


def on_terminal() -> bool:
    """Return whether output goes to a terminal on which lines can be redrawn."""
    # Open MPI gives every rank a pseudo-terminal, even if its output goes elsewhere.
    fancy = sys.stdout.isatty() and not is_rank()
    return fancy and os.environ.get("TERM") != "dumb"


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Treat the signals of batch systems and of closed terminals as Ctrl-C."""
    previous = {number: signal.getsignal(number) for number in SIGNALS}
    for number, handler in previous.items():
        if handler is not signal.SIG_IGN:  # ignored under nohup
            signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
