"""Text files that users write: scenes, fits and tables."""

import tomllib
from pathlib import Path
from typing import Any

from .errors import SceneError

_LARGEST = 10_000_000  # bytes


def read_text(path: str | Path, expected: str, missing: str = "no such file") -> str:
    """Return the text of a file, which may be one without end.

    `expected` says what it should be, as "a scene file"; `missing` what is wrong if there is none.

    Raises
    ------
    SceneError
        If the file cannot be read, is larger than 10 MB or not UTF-8.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(_LARGEST + 1)
        text = content.decode("utf-8-sig")
    except FileNotFoundError:
        raise SceneError(f"{path}: {missing}") from None
    except UnicodeDecodeError as error:
        at = f"byte {error.start + 1}"
        raise SceneError(f"{path}: not UTF-8 at {at}; save the file as UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{path}: cannot be read: {reason}") from None
    if len(content) > _LARGEST:
        raise SceneError(f"{path}: larger than 10 MB; expected {expected}")
    return text


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Return the tables of a text; `source` is its name in error messages.

    Raises
    ------
    SceneError
        If it is not TOML.
    """
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise SceneError(f"{source}: not TOML: {error}") from None
    except RecursionError:
        raise SceneError(f"{source}: brackets are nested too deeply") from None
