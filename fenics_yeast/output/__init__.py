"""The output directory of a run: written as the run goes, read back, resumed, interrupted.

Rank 0 alone writes. Reading needs no dolfinx.
"""

from __future__ import annotations

from .folder import MERIDIAN, SERIES, SHAPES, SURFACES, VOLUME, OutputError, replace_file, writing
from .interrupts import SIGNALS, interrupt
from .job import DolfinxMissing, Job, RunLost, Screen, run_into
from .reading import (
    load_ending,
    load_error_bars,
    load_history,
    load_profiles,
    load_result,
    load_scene,
    load_status,
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
    "load_ending",
    "load_error_bars",
    "load_history",
    "load_profiles",
    "load_result",
    "load_scene",
    "load_status",
    "replace_file",
    "run_into",
    "writing",
]
