"""The table `[growth]` of a scene: where, above which stress, how fast and when the wall grows."""

from math import inf
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from ..geometry import Array, Curve, Poles
from .errors import BRANCH, refusal
from .table import Table
from .units import Length, Pressure, Time
from .zone import Zone


class Polarity(Table):
    """Decay of growth with the arc length from a point, as a Gaussian.

    Around a fixed point of the wall (`follow = "point"`: a pole, or `centre`), arc length is that
    of the unloaded wall: the pattern moves with the wall. With `follow = "tip"` it is that of the
    grown wall from its pole: the pattern stays at the tip and keeps its size, and the wall moves
    out of it.
    """

    pole: Poles | None = Field(
        default=None, description="pole at its centre; default: the pole of the zone, or top"
    )
    centre: Length | None = Field(
        default=None,
        ge=0,
        description="arc length from the bottom to its centre, instead of a pole (µm)",
    )
    width: Length = Field(gt=0, description="standard deviation of the Gaussian (µm)")
    weight: Literal["rate", "threshold"] = Field(
        default="rate",
        description="rate: the growth rate is multiplied by the Gaussian; "
        "threshold: the threshold is divided by it",
    )
    follow: Literal["point", "tip"] = Field(
        default="point", description="whether it stays at a point of the wall or at the tip"
    )

    @model_validator(mode="after")
    def _one_centre(self) -> Self:
        if self.centre is not None and "pole" in self.model_fields_set:
            raise refusal("expected either pole or centre, not both", key="centre")
        if self.centre is not None and self.follow == "tip":
            raise refusal('the tip is a pole; remove centre, or set follow = "point"', key="centre")
        return self

    def centres(self, curve: Curve) -> list[float]:
        """Return the arc lengths in µm around which growth decays on the unloaded wall."""
        if self.centre is not None:
            return [self.centre]
        ends = {"bottom": [0.0], "both": [0.0, curve.length]}
        return ends.get(self.pole or "top", [curve.length])

    def weight_at(self, S: Array, curve: Curve) -> Array:
        """Return the Gaussian at arc lengths in µm of the unloaded wall."""
        distances = [np.abs(S - centre) for centre in self.centres(curve)]
        return np.exp(-((np.min(distances, axis=0) / self.width) ** 2) / 2)


class Growth(Table):
    """Growth of a part of the wall where its stress exceeds a threshold, equations (12)-(13)."""

    begins: Time = Field(default=0.0, ge=0, alias="from", description="start of growth (min)")
    until: Time | None = Field(default=None, gt=0, description="end of growth (min); default: none")
    zone: Zone = Field(description="part of the wall that grows")
    threshold: Pressure = Field(gt=0, description="stress σ_trs above which it grows (MPa)")
    time: Time = Field(gt=0, description="characteristic growth time t_grw (min)")
    polarity: Polarity | None = Field(
        default=None, description="decay of growth around a point; default: uniform growth"
    )

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> Self:
        begins, ends = self.span
        if ends <= begins:
            raise refusal(f"must be later than growth.from ({begins:g} min)", key="until")
        return self

    @model_validator(mode="after")
    def _centre_polarity(self) -> Self:
        """Centre polarity at the pole of the zone, or at each of them, unless a point is given."""
        polarity = self.polarity
        if polarity is None or polarity.centre is not None:
            return self
        given = polarity.model_fields_set
        pole = polarity.pole if "pole" in given else None
        if pole == "both" and self.zone.pole != "both":
            raise refusal('"both" needs a zone with pole = "both"', key="polarity.pole")
        values = dict(polarity) | {"pole": pole or self.zone.pole or "top"}
        self.__dict__["polarity"] = Polarity.model_construct(given, **values)  # frozen
        return self

    @property
    def span(self) -> tuple[float, float]:
        """Start and end of growth (min)."""
        return self.begins, inf if self.until is None else self.until


def _table_or_list(value: object) -> str:
    return f"{BRANCH}list" if isinstance(value, list | tuple) else f"{BRANCH}table"


OneOrMore = Annotated[
    Annotated[Growth, Tag(f"{BRANCH}table")]
    | Annotated[tuple[Growth, ...], Field(strict=False, min_length=1), Tag(f"{BRANCH}list")],
    Discriminator(_table_or_list),
]
