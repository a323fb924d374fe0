"""The table `[growth]` of a scene: where, above which stress, how fast and when the wall grows."""

from __future__ import annotations

from math import inf
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, create_model, model_validator

from .errors import BRANCH, refusal
from .table import Table
from .units import Length, Pressure, Time
from .zone import Zone

# `from` is a word of Python's own, which no class body may define.
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


class Polarity(Table):
    """How growth falls off around a point, as a Gaussian of the arc length from it.

    Around a fixed point of the wall (`follow = "point"`: a pole, or `centre`) the arc length is
    that of the unloaded wall, so that the pattern is carried along by the wall. With
    `follow = "tip"` it is that of the grown wall from its pole: the pattern stays at the tip, in
    its size, and the wall moves out of it.
    """

    pole: Literal["top", "bottom", "both"] | None = Field(
        default=None,
        description="pole around which it lies; left out: that of the zone, or the top one",
    )
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

    @model_validator(mode="after")
    def _polarity_is_about_its_zone(self) -> Self:
        """Put polarity around the zone's own pole, or each of them, unless a point was given."""
        polarity = self.polarity
        if polarity is None or polarity.centre is not None:
            return self
        given = polarity.model_fields_set
        pole = polarity.pole if "pole" in given else None
        if pole == "both" and self.zone.pole != "both":
            allowed = 'around both poles it lies in a zone with pole = "both"'
            raise refusal("", allowed=allowed, key="polarity.pole")
        values = dict(polarity) | {"pole": pole or self.zone.pole or "top"}
        self.__dict__["polarity"] = Polarity.model_construct(given, **values)  # frozen
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
