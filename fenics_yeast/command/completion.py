"""Shell completion of keys and values after `--set` and `--vary`."""

from typing import Any, Literal, get_args, get_origin

from ..scene import Scene, keys_of


def assignments(incomplete: str) -> list[tuple[str, str]]:
    """Return completions with descriptions: ``growth.time=``, ``numerics.preset=paper``."""
    key, equals, _ = incomplete.partition("=")
    fields = dict(keys_of(Scene))
    if not equals:
        found = [(f"{name}=", field.description or "") for name, field in fields.items()]
    elif key in fields:
        found = [(f"{key}={choice}", "") for choice in _choices(fields[key].annotation)]
    else:
        found = []
    return [(text, what) for text, what in found if text.startswith(incomplete)]


def _choices(annotation: Any) -> list[str]:
    if get_origin(annotation) is Literal:
        return [str(choice) for choice in get_args(annotation)]
    return [choice for part in get_args(annotation) for choice in _choices(part)]
