"""The output directory of a run: written as the run goes, read back, resumed, interrupted.

Rank 0 alone writes. Reading needs no dolfinx.
"""

from __future__ import annotations

from .folder import MERIDIAN, SERIES, SHAPES, SURFACES, VOLUME, OutputError, replace_file, writing
from .interrupts import SIGNALS, interrupt
from .job import DolfinxMissing, Job, RunLost, Screen, run_into
from .reading import (
    read_ending,
    read_error_bars,
    read_history,
    read_profiles,
    read_result,
    read_scene,
    read_status,
)

__all__ = [
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
    "interrupt",
    "read_ending",
    "read_error_bars",
    "read_history",
    "read_profiles",
    "read_result",
    "read_scene",
    "read_status",
    "replace_file",
    "run_into",
    "writing",
]
