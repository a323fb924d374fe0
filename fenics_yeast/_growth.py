"""The table `[growth]` of a scene: where, above which stress, how fast and when the wall grows."""

from __future__ import annotations

from math import inf
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, create_model, model_validator

from fenics_yeast._quantities import Angle, Length, Pressure, Time, refusal
from fenics_yeast._scene_errors import BRANCH
from fenics_yeast._table import Table

_KINDS = (("pole", "half_angle"), ("from", "to"), ("from_fraction", "to_fraction"))
_WANTED = "either pole and half_angle, from and to, or from_fraction and to_fraction are wanted"

# `from` is a word of Python's own, which no class body may define.
_Stretch: Any = create_model(
    "_Stretch",
    __base__=Table,
    **{  # type: ignore[call-overload]
        "from": (
            Length | None,
            Field(default=None, ge=0, description="arc length at its lower edge (µm)"),
        ),
        "to": (
            Length | None,
            Field(default=None, gt=0, description="arc length at its upper edge (µm)"),
        ),
    },
)
_Span: Any = create_model(
    "_Span",
    __base__=Table,
    **{  # type: ignore[call-overload]
        "from": (Time, Field(default=0.0, ge=0, description="when growth begins (min)")),
        "until": (
            Time | None,
            Field(default=None, gt=0, description="when it ends, left out: never (min)"),
        ),
    },
)


class Zone(_Stretch):
    """A part of the unloaded wall.

    It is a polar cap (`pole`, `half_angle`), or what lies between two arc lengths from the bottom
    of the meridian (`from`, `to`) or between two fractions of its length (`from_fraction`,
    `to_fraction`).
    """

    pole: Literal["top", "bottom", "both"] | None = Field(
        default=None, description="pole around which it lies"
    )
    half_angle: Angle | None = Field(
        default=None, gt=0, le=180, description="polar angle from the pole to its edge (degrees)"
    )
    from_fraction: float | None = Field(
        default=None, ge=0, le=1, description="part of the meridian below it (1)"
    )
    to_fraction: float | None = Field(
        default=None, ge=0, le=1, description="part of the meridian up to its upper edge (1)"
    )

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        given = [kind for kind in _KINDS if any(getattr(self, key) is not None for key in kind)]
        if not given:
            raise refusal("", allowed=_WANTED)
        if len(given) > 1:
            key = next(key for key in given[1] if getattr(self, key) is not None)
            raise refusal("", allowed=_WANTED, key=key)
        for key in given[0]:
            if getattr(self, key) is None:
                raise refusal("", key=key)
        start, end = given[0]
        if start != "pole" and getattr(self, start) >= getattr(self, end):
            allowed = f"more than {start} ({getattr(self, start):g}) is wanted"
            raise refusal("", allowed=allowed, key=end)
        return self


class Polarity(Table):
    """How growth falls off around a point, as a Gaussian of the arc length from it.

    Around a fixed point of the wall (`follow = "point"`: a pole, or `centre`) the arc length is
    that of the unloaded wall, so that the pattern is carried along by the wall. With
    `follow = "tip"` it is that of the grown wall from its pole: the pattern stays at the tip, in
    its size, and the wall moves out of it.
    """

    pole: Literal["top", "bottom"] = Field(default="top", description="pole around which it lies")
    centre: Length | None = Field(
        default=None, ge=0, description="arc length of the point, in place of a pole (µm)"
    )
    width: Length = Field(gt=0, description="standard deviation of the Gaussian (µm)")
    weight: Literal["rate", "threshold"] = Field(
        default="rate", description="what is weighted: rate times, or threshold over the Gaussian"
    )
    follow: Literal["point", "tip"] = Field(
        default="point", description="whether it stays at a point of the wall or at the tip"
    )

    @model_validator(mode="after")
    def _one_centre(self) -> Self:
        if self.centre is not None and "pole" in self.model_fields_set:
            raise refusal("", allowed="either pole or centre is wanted", key="centre")
        if self.centre is not None and self.follow == "tip":
            raise refusal("", allowed="the tip is a pole: leave out centre or follow", key="centre")
        return self


class Growth(_Span):
    """Growth of a part of the wall where its stress exceeds a threshold, equations (12)-(13)."""

    zone: Zone = Field(description="the part of the wall that grows")
    threshold: Pressure = Field(gt=0, description="stress σ_trs above which it grows (MPa)")
    time: Time = Field(gt=0, description="characteristic time t_grw of growth (min)")
    polarity: Polarity | None = Field(
        default=None, description="how growth falls off around a point; left out: evenly spread"
    )

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> Self:
        begins, ends = self.span
        if ends <= begins:
            raise refusal("", allowed=f"a time after from ({begins:g} min)", key="until")
        return self

    @property
    def span(self) -> tuple[float, float]:
        """When growth begins and ends, min."""
        begins, ends = getattr(self, "from"), self.until
        return begins, inf if ends is None else ends


def _table_or_list(value: object) -> str:
    return f"{BRANCH}list" if isinstance(value, list | tuple) else f"{BRANCH}table"


OneOrMore = Annotated[
    Annotated[Growth, Tag(f"{BRANCH}table")]
    | Annotated[tuple[Growth, ...], Field(strict=False, min_length=1), Tag(f"{BRANCH}list")],
    Discriminator(_table_or_list),
]
