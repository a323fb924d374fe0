"""One-line messages about what pydantic found wrong in a scene."""

from collections.abc import Mapping
from types import UnionType
from typing import Annotated, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from .errors import BRANCH, key_text, value_text
from .keys import ABSENT, Path, field_at, fields_of, kind_key, look_up, model_of, models_of
from .units import Unit

_KINDS = {bool: "true or false", int: "an integer", float: "a number", str: "a string"}
_LISTS = {"min": "[40, 70, 90]", "MPa": '["2 atm", "0.2 atm"]', "µm": "[0, 1.2, 2.5]"}
_UNKNOWN = ("extra_forbidden", "invalid_key")
_BOUNDS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
_NO_KIND = ("union_tag_invalid", "union_tag_not_found")
_REASONS = {"finite_number": "not finite"}


def explain(model: type[BaseModel], data: object, error: ValidationError) -> str:
    """Describe what pydantic found wrong in `data`, meant to be a `model`, on one line.

    Only one problem is described, by its key, its value and what must hold; the others are counted.
    An unknown key comes first, as it may be a misspelt one that is missing.
    """
    problems = [
        problem
        for problem in error.errors(include_url=False)
        if problem["type"] != "default_factory_not_called"  # only follows from another one
    ]
    problems.sort(key=lambda problem: problem["type"] not in _UNKNOWN)
    others = len(problems) - 1
    more = f" (and {others} more error{'s' * (others > 1)})" if others else ""
    return f"{_explain(model, data, problems[0])}{more}"


def _explain(model: type[BaseModel], data: object, problem: ErrorDetails) -> str:
    context = problem.get("ctx", {})
    path = tuple(part for part in problem["loc"] if not str(part).startswith(BRANCH))
    if context.get("key"):
        keys = context["key"].split(".")
        path += tuple(int(key) if key.isdigit() else key for key in keys)
    if problem["type"] in _NO_KIND and isinstance(look_up(data, path), Mapping):
        path += (kind_key(field_at(model, data, path)[0]),)
    value = look_up(data, path)
    given = " is missing" if value is ABSENT else f" = {value_text(value)}"
    what = key_text(path) + given
    if problem["type"] in _UNKNOWN:
        return f"{what}: {_nearest(model, data, path)}"
    reason = context.get("reason") or _REASONS.get(problem["type"])
    expected = context.get("must") or f"expected {_expected(model, data, path)}"
    return f"{what}: {reason}; {expected}" if reason else f"{what}: {expected}"


def _expected(model: type[BaseModel], data: object, path: Path) -> str:
    """Describe the values that the field at `path` below `model` takes."""
    annotation, metadata = field_at(model, data, path)
    tabular = False
    if get_origin(annotation) in (UnionType, Union):
        first, *others = get_args(annotation)  # the kind to describe, and None or a table
        tabular = any(model_of(other) for other in others)
        annotation, *own = get_args(first) if get_origin(first) is Annotated else (first,)
        metadata = metadata + own
    if model_of(annotation):
        return f"a table [{key_text(path)}]"
    if get_origin(annotation) is Literal:
        return "one of " + ", ".join(value_text(choice) for choice in get_args(annotation))
    if get_origin(annotation) is tuple and models_of(get_args(annotation)[0]):
        return f"a list of tables [[{key_text(path)}]]"
    if get_origin(annotation) is tuple:
        marks = get_args(get_args(annotation)[0])
        entry = next((mark for mark in marks if isinstance(mark, Unit)), None)
        if entry is None:
            return "a list of numbers, e.g. [2.0, -2.0]"
        return f"a list of {entry.kind.split()[1]}s, e.g. {_LISTS[entry.symbol]}"
    unit = next((mark for mark in metadata if isinstance(mark, Unit)), None)
    bounds = " and ".join(
        f"{sign} {getattr(mark, name)}"
        for name, sign in _BOUNDS.items()
        for mark in metadata
        if hasattr(mark, name)
    )
    kind = unit.kind if unit else _KINDS.get(annotation, "another value")
    example = f", e.g. {unit.example} (plain numbers are in {unit.symbol})" if unit else ""
    table = f", or a table [{key_text(path)}]" if tabular else ""
    return " ".join(filter(None, (kind, bounds))) + example + table


def _nearest(model: type[BaseModel], data: object, path: Path) -> str:
    """Suggest a known key for the unknown one at the end of `path`."""
    import difflib  # late: most scenes are right

    *parents, key = path
    annotation, content = field_at(model, data, parents)[0], look_up(data, parents)
    table = model_of(annotation, content) or model
    kinds = models_of(annotation)
    if any(key in fields_of(kind) for kind in kinds if kind is not table):
        name = kind_key(annotation)
        kind = value_text(get_args(fields_of(table)[name].annotation)[0])
        return f"not a key of {name} = {kind}; remove it (keys: {', '.join(fields_of(table))})"
    if near := difflib.get_close_matches(str(key), fields_of(table), n=1):
        return f"unknown key; did you mean {key_text((*parents, near[0]))}?"
    for name, field in fields_of(model).items():
        other = model_of(field.annotation)
        if other and key in fields_of(other):
            return f"unknown key; did you mean {name}.{key}?"
    return f"unknown key; known keys: {', '.join(fields_of(table))}"
