"""How a command ends: its exit status, the line that says why, and the signals that end it."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import typer

from ..output import SIGNALS, interrupt

BROKEN, BAD_INPUT, NO_EQUILIBRIUM, FAILED, INTERRUPTED = 1, 2, 3, 4, 130
EXIT = {
    "finished": 0,
    "no-equilibrium": NO_EQUILIBRIUM,
    "failed": FAILED,
    "interrupted": INTERRUPTED,
}
# Set by mpirun and srun for each rank. Without them MPI is not even loaded: a process that has
# initialised it can start no other one that would.
_LAUNCHED = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK")


def fail(message: str, status: int) -> NoReturn:
    """Say in a line of rank 0 what ends the command, and end it."""
    comm = launched()
    if comm is None or comm.rank == 0:
        kind = "" if status in (NO_EQUILIBRIUM, INTERRUPTED) else "error: "
        typer.echo(kind + message, err=True)
    raise typer.Exit(status)


def abandon(message: str) -> NoReturn:
    """End all ranks from rank 0, which alone knows that its output folder is lost."""
    comm = launched()
    if comm is not None:
        typer.echo(f"error: {message}", err=True)
        comm.Abort(FAILED)
    fail(message, FAILED)


def launched() -> Any:
    """Communicator of all ranks under mpirun; None where there is one alone, or no MPI."""
    if not any(name in os.environ for name in _LAUNCHED):
        return None
    try:
        from mpi4py import MPI
    except ImportError:
        return None
    return MPI.COMM_WORLD if MPI.COMM_WORLD.size > 1 else None


def on_terminal() -> bool:
    """Whether somebody looks at the output, and lines can be drawn anew."""
    # Open MPI gives every rank a pseudo-terminal, wherever its output goes.
    fancy = sys.stdout.isatty() and not any(name in os.environ for name in _LAUNCHED)
    return fancy and os.environ.get("TERM") != "dumb"


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Treat the signals of batch systems and of closed terminals as Ctrl-C."""
    previous = {number: signal.getsignal(number) for number in SIGNALS}
    for number, handler in previous.items():
        if handler is not signal.SIG_IGN:  # as nohup wants
            signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
