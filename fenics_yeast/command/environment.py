"""Prepare the environment of a process that runs the command."""

import logging
import os
from pathlib import Path


def prepare() -> None:
    """Set what Open MPI needs, and silence what users do not need to read."""
    if "HOME" not in os.environ:  # as in a service; Open MPI 5 needs it
        os.environ["HOME"] = _home()
    # It warns at length about a read-only home directory and about its font cache.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def _home() -> str:
    try:
        return str(Path.home())
    except RuntimeError:  # an unknown user; every run compiles its forms again
        from .._form_cache import temporary

        return str(temporary("home"))
