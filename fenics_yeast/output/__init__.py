"""The output directory of a run: written during the run, read, resumed, interrupted.

Only rank 0 writes. Reading needs no dolfinx.
"""

from .errors import DolfinxMissing, OutputError, RunLost
from .files import (
    BUCKLED,
    FIGURES,
    GIF,
    MERIDIAN,
    MODE_SURFACE,
    MP4,
    SERIES,
    SHAPES,
    SURFACES,
    VOLUME,
    replace_file,
    writing,
)  # fmt: skip
from .interrupts import SIGNALS, interrupt
from .job import Job, Screen, failed_figures
from .lock import FolderLock
from .reading import read_history, read_mode, read_profiles, read_result, read_scene
from .summary import Summary, read_summary

__all__ = [
    "BUCKLED",
    "FIGURES",
    "GIF",
    "MERIDIAN",
    "MODE_SURFACE",
    "MP4",
    "SERIES",
    "SHAPES",
    "SIGNALS",
    "SURFACES",
    "VOLUME",
    "DolfinxMissing",
    "FolderLock",
    "Job",
    "OutputError",
    "RunLost",
    "Screen",
    "Summary",
    "failed_figures",
    "interrupt",
    "read_history",
    "read_mode",
    "read_profiles",
    "read_result",
    "read_scene",
    "read_summary",
    "replace_file",
    "writing",
]
