"""The command, called within the process of the tests or started as a process."""

import inspect
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from support import ranks
from typer.testing import CliRunner, Result

from fenics_yeast.command.main import app
from fenics_yeast.output.interrupts import SIGNALS

MAIN = "from fenics_yeast.command.main import main; main()"
COMMAND = [sys.executable, "-c", MAIN]
# What a run leaves that saves one time, and two.
FILES = {
    "checkpoint.npz",
    "scene.toml", "history.csv", "profiles.npz", "run.json", "figures/shapes.png",
    "figures/volume.png", "surface.pvd", "surface/0000.vtu",
}  # fmt: skip
TWO_SAVED = FILES | {"surface/0001.vtu"}
# Before 8.2, click mixes the two outputs by default.
_MIXES = "mix_stderr" in inspect.signature(CliRunner).parameters
_OPTIONS: dict[str, Any] = {"mix_stderr": False} if _MIXES else {}


def call(*arguments: str) -> Result:
    """Run the command; `stdout` and `stderr` of the result are apart."""
    return CliRunner(**_OPTIONS).invoke(app, arguments)


def hear() -> None:
    """Let a new process receive signals that are ignored in the background (`preexec_fn`)."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


def start(*arguments: str, before: str = "", **options: Any) -> subprocess.Popen[str]:
    """Start the command as a process that runs some Python `before`.

    It belongs to no MPI run, and receives Ctrl-C in the background too.
    """
    pipe = subprocess.PIPE
    pipes = {"stdout": pipe, "stderr": pipe, "text": True, "env": ranks.environment()}
    command = [sys.executable, "-c", f"{before}\n{MAIN}", *arguments]
    return subprocess.Popen(command, preexec_fn=hear, **pipes | options)


def finish(
    *arguments: str, timeout: float = 120, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Start the command and wait for its end."""
    with start(*arguments, **options) as process:
        output, errors = process.communicate(timeout=timeout)
    return subprocess.CompletedProcess(arguments, process.returncode, output, errors)


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[Any]) -> None:
    """Wait for something that a running process does."""
    deadline = time.monotonic() + 60
    while not condition():
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)


def lines(folder: Path) -> int:
    """Lines that the history of a run has by now."""
    history = folder / "history.csv"
    return history.read_bytes().count(b"\n") if history.exists() else 0


def tree(folder: Path) -> set[str]:
    """All files of a folder."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
