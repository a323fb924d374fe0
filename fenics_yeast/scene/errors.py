"""Errors of a scene: the exception, refusals by validators, keys and values as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pydantic import BaseModel
from pydantic_core import PydanticCustomError


class SceneError(ValueError):
    """A scene that cannot be used.

    The message is one line that names the file, the key, its value and what is allowed.
    """

    def __init__(self, message: str) -> None:
        super().__init__("".join(c if c.isprintable() else repr(c)[1:-1] for c in message))


BRANCH = "as "  # begins the name of a kind of value where a key takes several kinds


def refusal(reason: str, *, allowed: str = "", key: str = "") -> PydanticCustomError:
    """Give the error with which a validator refuses a value for a reason of its own.

    `allowed` stands in for the field's general description of what is allowed; `key` is the
    culprit's path below the table whose validator speaks.
    """
    context = {"reason": reason, "allowed": allowed, "key": key}
    return PydanticCustomError("refused", "refused", context)


def key_text(path: Sequence[int | str]) -> str:
    """Write a path as a dotted key, entries of lists in brackets, long parts shortened."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part[:40]}" for part in path)
    return "".join(parts).removeprefix(".")


def value_text(value: object) -> str:
    """Write a value as it would stand in TOML, shortened."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value[:40]}..."' if len(value) > 40 else f'"{value}"'
    elif isinstance(value, Mapping | BaseModel):
        text = "{...}"
    elif isinstance(value, list | tuple):
        entries = ("[...]" if isinstance(v, list | tuple) else value_text(v) for v in value[:6])
        text = f"[{', '.join(entries)}{', ...' if len(value) > 6 else ''}]"
    elif isinstance(value, int) and abs(value) >= 10**20:
        text = "a number of more than 20 digits"
    else:
        text = str(value)
    return text
