"""The command, called within the process of the tests or started as one of its own."""

import inspect
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from typer.testing import CliRunner, Result

from fenics_yeast.command.main import app
from fenics_yeast.output.interrupts import SIGNALS

COMMAND = [sys.executable, "-c", "from fenics_yeast.command.main import main; main()"]
# What a run leaves that saves one time, and two.
FILES = {
    "checkpoint.npz",
    "scene.toml", "history.csv", "profiles.npz", "run.json", "figures/shapes.png",
    "figures/volume.png", "surface.pvd", "surface/0000.vtu",
}  # fmt: skip
TWO_SAVED = FILES | {"surface/0001.vtu"}
# Before 8.2, click mixes the two outputs unless told not to.
_MIXES = "mix_stderr" in inspect.signature(CliRunner).parameters
_OPTIONS: dict[str, Any] = {"mix_stderr": False} if _MIXES else {}


def call(*arguments: str) -> Result:
    """Run the command; `stdout` and `stderr` of the result are apart."""
    return CliRunner(**_OPTIONS).invoke(app, arguments)


def hear() -> None:
    """Let a new process hear what is ignored in the background or under nohup (`preexec_fn`)."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[Any]) -> None:
    """Wait while a process goes on."""
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
