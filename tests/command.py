"""The command, called within the process of the tests or started as one that hears signals."""

import inspect
import signal
from typing import Any

from typer.testing import CliRunner, Result

from fenics_yeast.cli import app
from fenics_yeast.interrupts import SIGNALS

# Before 8.2, click mixes the two outputs unless told not to.
_MIXES = "mix_stderr" in inspect.signature(CliRunner).parameters
_OPTIONS: dict[str, Any] = {"mix_stderr": False} if _MIXES else {}


def call(*arguments: str) -> Result:
    """Run the command; `stdout` and `stderr` of the result are apart."""
    return CliRunner(**_OPTIONS).invoke(app, arguments)


def hear() -> None:
    """Let a process hear what one in the background or under nohup ignores: a `preexec_fn`."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
