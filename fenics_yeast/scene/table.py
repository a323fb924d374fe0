"""Base of the tables of a scene, and the lists in them."""

from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from .errors import SceneError
from .explain import explain

T = TypeVar("T")
ListOf = Annotated[tuple[T, ...], Field(strict=False)]
"""A list in a file, a tuple in a scene."""


class Table(BaseModel):
    """A frozen table of a scene that refuses unknown keys and values of another type."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, hide_input_in_errors=True
    )

    if not TYPE_CHECKING:

        def __init__(self, **values: Any) -> None:
            try:
                super().__init__(**values)
            except ValidationError as error:
                problem = explain(type(self), values, error)
                raise SceneError(f"{type(self).__name__}: {problem}") from None

        # marks, for pydantic, an __init__ that adds nothing to validation
        __init__.__pydantic_base_init__ = True
