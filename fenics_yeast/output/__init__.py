"""The output directory of a run: written during the run, read, resumed, interrupted.

Only rank 0 writes. Reading needs no dolfinx.
"""

from .errors import DolfinxMissing, OutputError, RunLost
from .files import FIGURES, MERIDIAN, SERIES, SHAPES, SURFACES, VOLUME, replace_file, writing
from .interrupts import SIGNALS, interrupt
from .job import Job, Screen
from .reading import read_history, read_profiles, read_result, read_scene
from .summary import Summary, read_summary

__all__ = [
    "FIGURES",
    "MERIDIAN",
    "SERIES",
    "SHAPES",
    "SIGNALS",
    "SURFACES",
    "VOLUME",
    "DolfinxMissing",
    "Job",
    "OutputError",
    "RunLost",
    "Screen",
    "Summary",
    "interrupt",
    "read_history",
    "read_profiles",
    "read_result",
    "read_scene",
    "read_summary",
    "replace_file",
    "writing",
]
