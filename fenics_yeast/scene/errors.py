"""What is wrong with a scene, told in one line."""

from __future__ import annotations

from collections.abc import Mapping
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from .units import Unit


class SceneError(ValueError):
    """A scene that cannot be used.

    The message is one line that names the file, the key, its value and what is allowed.
    """

    def __init__(self, message: str) -> None:
        super().__init__("".join(c if c.isprintable() else repr(c)[1:-1] for c in message))


BRANCH = "as "  # begins the name of a kind of value where a key takes several kinds

_Path = tuple[int | str, ...]
_ABSENT = object()
_SEVERAL = (UnionType, Union, Annotated)
_WANTED = {int: "a whole number", float: "a number", str: "a text in quotes"}
_LISTS = {"min": "[40, 70, 90]", "MPa": '["2 atm", "0.2 atm"]'}
_NO_KIND = ("union_tag_invalid", "union_tag_not_found")
_REASONS = {"finite_number": "not finite"}


def explain(model: type[BaseModel], data: object, error: ValidationError) -> str:
    """Say what pydantic found wrong in `data`, meant to be a `model`.

    The first problem is told, with its key, value and what is allowed; the others are counted.
    """
    problems = [
        problem
        for problem in error.errors(include_url=False)
        if problem["type"] != "default_factory_not_called"  # only follows from another one
    ]
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"{_explain(model, data, problems[0])}{more}"


def _explain(model: type[BaseModel], data: object, problem: ErrorDetails) -> str:
    context = problem.get("ctx", {})
    path = tuple(part for part in problem["loc"] if not str(part).startswith(BRANCH))
    if context.get("key"):
        keys = context["key"].split(".")
        path += tuple(int(key) if key.isdigit() else key for key in keys)
    if problem["type"] in _NO_KIND and isinstance(_look_up(data, path), Mapping):
        path += (_kind_key(_field_at(model, data, path)[0]),)
    value = _look_up(data, path)
    given = " is missing" if value is _ABSENT else f" = {value_text(value)}"
    what = key_text(path) + given
    if problem["type"] in ("extra_forbidden", "invalid_key"):
        return f"{what}: {_nearest(model, data, path)}"
    reason = context.get("reason") or _REASONS.get(problem["type"])
    allowed = context.get("allowed") or _allowed(model, data, path)
    return f"{what}: {reason}; {allowed}" if reason else f"{what}: {allowed}"


def _look_up(data: Any, path: _Path) -> object:
    for part in path:
        try:
            data = value_of(data, str(part)) if isinstance(data, BaseModel) else data[part]
        except (AttributeError, LookupError, TypeError):
            return _ABSENT
    return data


def fields_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of a table by the names that they have in a scene file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def value_of(table: BaseModel, key: str) -> object:
    """Value of a table at a key that it has in a scene file; AttributeError if it has none."""
    names = {field.alias: name for name, field in type(table).model_fields.items() if field.alias}
    return getattr(table, names.get(key, key))


def _models_of(annotation: Any) -> list[type[BaseModel]]:
    """Tables that a value may be."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    kinds = get_args(annotation) if get_origin(annotation) in _SEVERAL else ()
    return [model for kind in kinds for model in _models_of(kind)]


def _kind_key(annotation: Any) -> str:
    """Key whose value tells several kinds of table apart: a choice that differs among them."""
    tables = [fields_of(model) for model in _models_of(annotation)]
    return next(
        key
        for key, field in tables[0].items()
        if get_origin(field.annotation) is Literal
        and len({get_args(fields[key].annotation) for fields in tables if key in fields}) > 1
    )


def _model_of(annotation: Any, value: object = None) -> type[BaseModel] | None:
    """Table that a value is meant to be; the first one where that cannot be told."""
    models = _models_of(annotation)
    if len(models) > 1:
        key = _kind_key(annotation)
        kind = _look_up(value, (key,))
        alike = [m for m in models if kind in get_args(fields_of(m)[key].annotation)]
        alike = alike or [m for m in models if not fields_of(m)[key].is_required()]
        keys = set(value) if isinstance(value, Mapping) else set()
        models = sorted(alike or models, key=lambda m: -len(keys & set(fields_of(m))))
    return models[0] if models else None


def _entry(annotation: Any) -> tuple[Any, list[Any]]:
    """Annotation and metadata of the entries of a list, or of the list among several kinds."""
    if get_origin(annotation) in _SEVERAL:
        found = map(_entry, get_args(annotation))
        return next((entry for entry in found if entry[0] is not None), (None, []))
    if get_origin(annotation) is not tuple:
        return None, []
    entry = get_args(annotation)[0]
    if get_origin(entry) is not Annotated:
        return entry, []
    kind, *metadata = get_args(entry)
    return kind, metadata


def _field_at(model: type[BaseModel], data: object, path: _Path) -> tuple[Any, list[Any]]:
    """Annotation and metadata of the field at `path` below `model`."""
    annotation: Any = model
    metadata: list[Any] = []
    value = data
    for part in path:
        if isinstance(part, int):  # an entry of a list
            annotation, metadata = _entry(annotation)
        else:
            models = _models_of(annotation)
            key = _kind_key(annotation) if len(models) > 1 else None
            if part == key:  # one of the kinds
                kinds = [k for m in models for k in get_args(fields_of(m)[key].annotation)]
                kinds = list(dict.fromkeys(kinds))
                annotation, metadata = Literal[tuple(kinds)], []
            elif field := fields_of(_model_of(annotation, value) or model).get(part):
                annotation, metadata = field.annotation, field.metadata
        value = _look_up(value, (part,))
    return annotation, metadata


def _allowed(model: type[BaseModel], data: object, path: _Path) -> str:
    """Say what is allowed at `path` below `model`, from the field found there."""
    annotation, metadata = _field_at(model, data, path)
    if get_origin(annotation) in (UnionType, Union):
        first = get_args(annotation)[0]  # the kind that is told; None or a table is another
        annotation, *own = get_args(first) if get_origin(first) is Annotated else (first,)
        metadata = metadata + own
    if _model_of(annotation):
        return f"the table [{key_text(path)}] is wanted"
    if get_origin(annotation) is Literal:
        return "allowed: " + ", ".join(value_text(choice) for choice in get_args(annotation))
    if get_origin(annotation) is tuple and _models_of(get_args(annotation)[0]):
        return f"a list of tables is wanted, [[{key_text(path)}]]"
    if get_origin(annotation) is tuple:
        marks = get_args(get_args(annotation)[0])
        entry = next((mark for mark in marks if isinstance(mark, Unit)), None)
        if entry is None:
            return "a list of numbers is wanted, e.g. [2.0, -2.0]"
        return f"a list of {entry.kind.split()[1]}s is wanted, e.g. {_LISTS[entry.symbol]}"
    unit = next((mark for mark in metadata if isinstance(mark, Unit)), None)
    kind = unit.kind if unit else _WANTED.get(annotation, "another value")
    words = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}
    bounds = " and ".join(
        f"{word} {getattr(mark, name)}"
        for name, word in words.items()
        for mark in metadata
        if hasattr(mark, name)
    )
    example = f", e.g. {unit.example} (bare numbers are {unit.symbol})" if unit else ""
    return " ".join(filter(None, (kind, bounds, "is wanted"))) + example


def _nearest(model: type[BaseModel], data: object, path: _Path) -> str:
    """Suggest a known key for the unknown one at the end of `path`."""
    import difflib  # late: most scenes are right

    *parents, key = path
    table, value = model, data
    for part in parents:
        field, value = fields_of(table).get(str(part)), _look_up(value, (part,))
        table = (_model_of(field.annotation, value) if field else None) or table
    if near := difflib.get_close_matches(str(key), fields_of(table), n=1):
        return f"unknown key; did you mean {key_text((*parents, near[0]))}?"
    for name, field in fields_of(model).items():
        other = _model_of(field.annotation)
        if other and key in fields_of(other):
            return f"unknown key; did you mean {name}.{key}?"
    return f"unknown key; known here: {', '.join(fields_of(table))}"


def key_text(path: _Path) -> str:
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
