"""Errors of a scene: the exception, refusals by validators, keys and values as strings."""

from collections.abc import Mapping, Sequence

from pydantic import BaseModel
from pydantic_core import PydanticCustomError


class SceneError(ValueError):
    """A scene that cannot be used.

    The message is one line that names the file, the key, its value and what must hold.
    """

    def __init__(self, message: str) -> None:
        super().__init__("".join(c if c.isprintable() else repr(c)[1:-1] for c in message))


BRANCH = "as "  # begins the name of a kind of value where a key takes several kinds


def refusal(must: str = "", *, reason: str = "", key: str = "") -> PydanticCustomError:
    """Return the error with which a validator refuses a value.

    It says what is wrong (`reason`) and what must hold (`must`, by default what the field says).
    `key` is the dotted key of the value, below the table whose validator raises the error.
    """
    context = {"must": must, "reason": reason, "key": key}
    return PydanticCustomError("refused", "refused", context)


def key_text(path: Sequence[int | str]) -> str:
    """Write a path as a dotted key, entries of lists in brackets, long parts shortened."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part[:40]}" for part in path)
    return "".join(parts).removeprefix(".")


def value_text(value: object) -> str:
    """Write a value as in TOML, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value[:40]}..."' if len(value) > 40 else f'"{value}"'
    if isinstance(value, Mapping | BaseModel):
        return "{...}"
    if isinstance(value, list | tuple):
        entries = ("[...]" if isinstance(v, list | tuple) else value_text(v) for v in value[:6])
        return f"[{', '.join(entries)}{', ...' if len(value) > 6 else ''}]"
    if isinstance(value, int) and abs(value) >= 10**20:
        return "a number of more than 20 digits"
    return str(value)
