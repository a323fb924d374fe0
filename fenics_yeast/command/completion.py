"""Keys and values of scenes, as the shell completes them after `--set` and `--vary`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from ..scene import Scene


def assignments(incomplete: str) -> list[tuple[str, str]]:
    """What may follow, with its description: ``growth.time=``, or ``numerics.preset=paper``."""
    key, equals, _ = incomplete.partition("=")
    fields = dict(_fields(Scene, ""))
    if not equals:
        found = [(f"{name}=", field.description or "") for name, field in fields.items()]
    elif key in fields:
        found = [(f"{key}={choice}", "") for choice in _choices(fields[key].annotation)]
    else:
        found = []
    return [(text, what) for text, what in found if text.startswith(incomplete)]


def _fields(model: type[BaseModel], before: str) -> Iterator[tuple[str, FieldInfo]]:
    """Dotted keys of all that has a value; of tables of several kinds, the keys of each."""
    for name, field in model.model_fields.items():
        tables = list(_tables(field.annotation))
        if not tables:
            yield before + name, field
        for table in tables:
            yield from _fields(table, f"{before}{name}.")


def _tables(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _tables(part)


def _choices(annotation: Any) -> list[str]:
    if get_origin(annotation) is Literal:
        return [str(choice) for choice in get_args(annotation)]
    return [choice for part in get_args(annotation) for choice in _choices(part)]
