"""Checkpoints: everything that determines how a run continues, and their file format."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from io import BytesIO
from typing import Any, Self, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from ..solve import ChordState, ControllerState, StabilityState, StepperState
from .history import Row
from .profiles import Profile
from .recorder import RecorderState
from .result import Timings
from .step_errors import StepErrorState

Values = NDArray[Any]

FORMAT = 6
_FORMAT, _DIGEST = "format", "sha256"


@dataclass(frozen=True)
class ResumePoint:
    """State from which to resume a run: a checkpoint with the rows and profiles before it."""

    checkpoint: Checkpoint
    rows: tuple[Row, ...]
    profiles: tuple[Profile, ...]


class CheckpointError(Exception):
    """A checkpoint that cannot be used; the message is the end of a line about its file."""


@dataclass(frozen=True)
class Checkpoint:
    """Everything that determines how a run continues from an accepted state.

    The arrays are in the order of `Ordering`, the same on any number of ranks.

    Attributes
    ----------
    scene
        The scene as TOML.
    stepper, chord, controller, stability, errors
        States of the time stepper with the shell, the solver's tangent, the step control, the
        count of negative modes and the errors of the steps.
    step_reduced
        Whether fixed steps were reduced to the stability limit of the method.
    recorder
        How much of the run has been recorded.
    timings
        Where the time went so far.
    """

    scene: str
    stepper: StepperState
    chord: ChordState | None
    controller: ControllerState
    stability: StabilityState
    errors: StepErrorState
    step_reduced: bool
    recorder: RecorderState
    timings: Timings

    def to_bytes(self) -> bytes:
        """Return the content of a file ``.npz``."""
        arrays = dict(_flat(self)) | {_FORMAT: np.array(FORMAT)}
        content = BytesIO()
        np.savez(content, **arrays, **{_DIGEST: np.array(_digest(arrays))})
        return content.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes) -> Self:
        """Read the content that `to_bytes` returned.

        Raises
        ------
        CheckpointError
            If it is damaged or has the format of another version.
        """
        try:
            with np.load(BytesIO(content)) as file:
                arrays = dict(file)
            found, digest = int(arrays[_FORMAT]), str(arrays.pop(_DIGEST))
        except Exception:  # NumPy, zip and zlib raise many kinds of error for a damaged file
            raise CheckpointError("is damaged") from None
        if found != FORMAT:
            raise CheckpointError(f"has format {found}, and this version reads format {FORMAT}")
        if digest != _digest(arrays):
            raise CheckpointError("is damaged")
        try:
            return _built(cls, arrays, "")
        except KeyError as error:
            raise CheckpointError(f"lacks {error.args[0]}") from None


def _digest(arrays: Mapping[str, Values]) -> str:
    total = hashlib.sha256()
    for name, values in sorted(arrays.items()):
        total.update(f"{name} {values.dtype.str} {values.shape} ".encode())
        total.update(np.ascontiguousarray(values).tobytes())
    return total.hexdigest()


def _flat(record: Any, prefix: str = "") -> Iterator[tuple[str, Values]]:
    """Yield the arrays of a dataclass and of those within it, by dotted name; skip None."""
    for field in fields(record):
        name, value = prefix + field.name, getattr(record, field.name)
        if is_dataclass(value):
            yield from _flat(value, name + ".")
        elif value is not None:
            yield name, np.array(value)


def _built(cls: Any, arrays: Mapping[str, Values], prefix: str) -> Any:
    """Return an object of a dataclass from the arrays of `_flat`."""
    values: dict[str, Any] = {}
    for name, hint in get_type_hints(cls).items():
        key, alternatives = prefix + name, set(get_args(hint)) - {type(None)}
        kind = alternatives.pop() if type(None) in get_args(hint) else hint
        if is_dataclass(kind):
            there = any(found.startswith(key + ".") for found in arrays)
            values[name] = _built(kind, arrays, key + ".") if there or kind is hint else None
        elif key not in arrays and kind is not hint:
            values[name] = None
        elif get_origin(kind) is tuple:
            values[name] = tuple(arrays[key].tolist() if arrays[key].ndim == 1 else arrays[key])
        else:
            values[name] = kind(arrays[key][()]) if kind in (str, bool, int, float) else arrays[key]
    return cls(**values)
