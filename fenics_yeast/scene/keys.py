"""Dotted keys of a scene, such as ``growth.0.time``: get, set, list, flatten, and their units.

A key names a value below a table by the names of a scene file; a number names an entry of a list.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from .errors import SceneError, value_text
from .units import Unit

Path = Sequence[int | str]  # a split key: names, and numbers of entries of lists

ABSENT = object()
_SEVERAL = (UnionType, Union, Annotated)


# Values ---------------------------------------------------------------------------------------


def look_up(table: Any, path: Path) -> Any:
    """Return the value at a path below a table, of a scene or of its file; `ABSENT` if none."""
    value = table
    for part in path:
        try:
            if isinstance(value, BaseModel):
                fields = type(value).model_fields.items()
                attributes = {field.alias or name: name for name, field in fields}
                value = getattr(value, attributes[str(part)])
            else:
                value = value[int(part) if isinstance(value, list | tuple) else part]
        except (LookupError, TypeError, ValueError):
            return ABSENT
    return value


def value_of(table: BaseModel, key: str) -> Any:
    """Return the value of a scene, or of one of its tables, at a dotted key.

    Raises
    ------
    KeyError
        If there is none.
    """
    value = look_up(table, key.split("."))
    if value is ABSENT:
        raise KeyError(key)
    return value


def set_value(tables: dict[str, Any], key: str, value: object) -> None:
    """Set the value at a dotted key below plain tables; create the tables that are missing.

    Raises
    ------
    ValueError
        If a part of the key is neither in a table nor an entry of a list.
    """
    *parents, last = key.split(".")
    table: Any = tables
    for parent in parents:
        table = _enter(table, parent)
    # A copy, since a later key may change it.
    table[_place(table, last)] = deepcopy(value)


def _enter(table: Any, name: str) -> Any:
    """Return the table or list of tables at a name, created if missing."""
    place = _place(table, name)
    if isinstance(table, dict) and table.get(name) is None:
        table[name] = {}
    entry = table[place]
    if isinstance(entry, list | tuple) and entry and all(isinstance(e, dict) for e in entry):
        entry = table[place] = list(entry)
    elif not isinstance(entry, dict):
        raise ValueError(f"{name[:40]} is a value, not a table")
    return entry


def _place(table: Any, name: str) -> Any:
    """Return the name in a table, or the number of an entry of a list."""
    if isinstance(table, dict):
        return name
    if not name.isdecimal() or int(name) >= len(table):
        raise ValueError(f"{name[:40]} must be the number of an entry, from 0 to {len(table) - 1}")
    return int(name)


def flatten(table: BaseModel) -> dict[str, object]:
    """Return all values below a table by their dotted keys, each list as one value."""

    def walk(values: Mapping[str, Any], before: str) -> Iterator[tuple[str, object]]:
        for name, value in values.items():
            if isinstance(value, Mapping):
                yield from walk(value, f"{before}{name}.")
            else:
                yield before + name, value

    return dict(walk(table.model_dump(by_alias=True), ""))


# Fields ---------------------------------------------------------------------------------------


def fields_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields of a table by the names that they have in a scene file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def keys_of(model: type[BaseModel], before: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """List the dotted keys below a table, each with its field.

    If a value may be one of several kinds of table, the keys of each kind are listed, so that a
    shared key comes more than once; keys below lists of tables have no number.
    """
    for name, field in fields_of(model).items():
        tables = models_of(field.annotation) or models_of(entry_of(field.annotation)[0])
        if not tables or _unit([field.annotation]):
            yield before + name, field
        for table in tables:
            yield from keys_of(table, f"{before}{name}.")


def field_at(model: type[BaseModel], data: object, path: Path) -> tuple[Any, list[Any]]:
    """Return annotation and metadata of the field at a path below a table.

    `data` is the content of the table, valid or not: it chooses among several kinds of table.
    """
    annotation: Any = model
    metadata: list[Any] = []
    value = data
    for part in path:
        if isinstance(part, int):
            annotation, metadata = entry_of(annotation)
        else:
            models = models_of(annotation)
            key = kind_key(annotation) if len(models) > 1 else None
            if part == key:
                kinds = [k for m in models for k in get_args(fields_of(m)[key].annotation)]
                annotation, metadata = Literal[tuple(dict.fromkeys(kinds))], []
            elif field := fields_of(model_of(annotation, value) or model).get(part):
                annotation, metadata = field.annotation, field.metadata
        value = look_up(value, (part,))
    return annotation, metadata


def unit_symbol(scene: BaseModel, key: str) -> str:
    """Return the unit symbol of a scene key, "" if it has none.

    Raises
    ------
    KeyError
        If the scene has no such key.
    """
    table, _, name = key.rpartition(".")
    field = fields_of(type(value_of(scene, table) if table else scene))[name]
    unit = _unit([*field.metadata, field.annotation])
    return unit.symbol if unit else ""


def _unit(marks: Sequence[Any]) -> Unit | None:
    """Return the first unit among annotations and metadata, and within them."""
    for mark in marks:
        unit = mark if isinstance(mark, Unit) else _unit(get_args(mark))
        if unit is not None:
            return unit
    return None


# Kinds of table -------------------------------------------------------------------------------


def models_of(annotation: Any) -> list[type[BaseModel]]:
    """Return the tables that a value may be."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    kinds = get_args(annotation) if get_origin(annotation) in _SEVERAL else ()
    return [model for kind in kinds for model in models_of(kind)]


def kind_key(annotation: Any) -> str:
    """Return the key that distinguishes kinds of table: the choice that differs among them."""
    tables = [fields_of(model) for model in models_of(annotation)]
    return next(
        key
        for key, field in tables[0].items()
        if get_origin(field.annotation) is Literal
        and len({get_args(fields[key].annotation) for fields in tables if key in fields}) > 1
    )


def model_of(annotation: Any, value: object = None) -> type[BaseModel] | None:
    """Return the kind of table that a value is meant to be; by default the first one."""
    models = models_of(annotation)
    if len(models) > 1:
        key = kind_key(annotation)
        kind = look_up(value, (key,))
        alike = [m for m in models if kind in get_args(fields_of(m)[key].annotation)]
        alike = alike or [m for m in models if not fields_of(m)[key].is_required()]
        keys = set(value) if isinstance(value, Mapping) else set()
        models = sorted(alike or models, key=lambda m: -len(keys & set(fields_of(m))))
    return models[0] if models else None


def entry_of(annotation: Any) -> tuple[Any, list[Any]]:
    """Return annotation and metadata of the entries of a list, or of the list among kinds."""
    if get_origin(annotation) in _SEVERAL:
        found = map(entry_of, get_args(annotation))
        return next((entry for entry in found if entry[0] is not None), (None, []))
    if get_origin(annotation) is not tuple:
        return None, []
    entry = get_args(annotation)[0]
    if get_origin(entry) is not Annotated:
        return entry, []
    kind, *metadata = get_args(entry)
    return kind, metadata


# Assignments ----------------------------------------------------------------------------------


def parse_assignment(text: str) -> tuple[str, object]:
    """Split ``TABLE.KEY=VALUE`` into a key and a value for `Scene.with_values`.

    Raises
    ------
    SceneError
        If the key, the equals sign or the value is missing.
    """
    key, _, value = (part.strip() for part in text.partition("="))
    if not key or not value:
        raise SceneError(f"{value_text(text)}: expected TABLE.KEY=VALUE, e.g. growth.time=30")
    return key, parse_value(value)


def parse_value(text: str) -> object:
    """Read a TOML value, a number (``1000.``) or an unquoted string (``30 min``)."""
    try:
        values = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        try:
            return float(text)
        except ValueError:
            return text
    return values["value"] if len(values) == 1 else text
