"""Prepare the environment of a process that runs the command."""

import errno
import gc
import logging
import os
import sys
from pathlib import Path
from typing import Any, TextIO

# Created between two searches for garbage; imports and forms create many that all stay.
_OBJECTS = 20_000


def prepare() -> None:
    """Set what Open MPI needs, silence what users do not need to read, and protect the output."""
    sys.stdout = _Output(sys.stdout)
    gc.set_threshold(_OBJECTS)
    os.environ["MPLBACKEND"] = "agg"  # that of a notebook may not be installed here
    if "HOME" not in os.environ:  # as in a service; Open MPI 5 needs it
        os.environ["HOME"] = _home()
    # It warns at length about a read-only home directory and about its font cache.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


class _Output:
    """Standard output whose loss, by a closed pipe or a full disk, does not end a run."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream or open(os.devnull, "w")  # noqa: SIM115  # it was closed

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text, or lose it."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._lose(error)
            return len(text)

    def flush(self) -> None:
        """Flush what was written, or lose it."""
        try:
            self._stream.flush()
        except OSError as error:
            self._lose(error)

    def _lose(self, error: OSError) -> None:
        # Python would report it again when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
        if error.errno != errno.EPIPE:
            print(
                f"warning: standard output cannot be written: {error.strerror}; the results are "
                "in the output directory",
                file=sys.stderr,
            )


def _home() -> str:
    try:
        return str(Path.home())
    except RuntimeError:  # an unknown user; every run compiles its forms again
        from .._form_cache import temporary

        return str(temporary("home"))
