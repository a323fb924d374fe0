"""The table `[wall]` of a scene: thickness and material of the cell wall."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

from .errors import BRANCH, refusal
from .table import ListOf, Table
from .units import Length, Pressure
from .zone import Zone

_LEAST_EXPONENT = 1e-3  # in size; below it the energy is lost to cancellation
_LAW: Any = Field(default="ogden", description="material law: Ogden")


class WallZone(Zone):
    """Part of the wall that is thicker or stiffer than the rest."""

    thickness: Length | None = Field(default=None, gt=0, description="thickness of the wall (µm)")
    shear_modulus: Pressure | None = Field(
        default=None, gt=0, description="shear modulus µ, for a wall of one Ogden term (MPa)"
    )
    modulus_factor: float | None = Field(
        default=None, gt=0, description="ratio of its moduli to those of the rest (1)"
    )

    @model_validator(mode="after")
    def _differs_from_the_rest(self) -> Self:
        if self.shear_modulus is not None and self.modulus_factor is not None:
            raise refusal("expected either shear_modulus or modulus_factor", key="modulus_factor")
        if self.thickness is self.shear_modulus is self.modulus_factor is None:
            raise refusal("expected a thickness, a shear_modulus or a modulus_factor")
        return self


class _Wall(Table):
    """Keys that all walls share."""

    thickness: Length = Field(gt=0, description="thickness of the wall (µm)")
    bending: bool = Field(
        default=True, description="whether the wall resists bending; false: a membrane"
    )
    energy_per: Literal["reference", "grown"] = Field(
        default="reference",
        description="volume to which the energy density refers: reference or grown",
    )
    thickness_change: Literal["none", "elastic"] = Field(
        default="none", description="whether elastic stretch thins the wall"
    )
    zone: ListOf[WallZone] = Field(
        default=(), description="parts of the wall that differ from the rest"
    )

    @field_validator("zone")
    @classmethod
    def _has_one_modulus(cls, zones: tuple[WallZone, ...]) -> tuple[WallZone, ...]:
        for i, zone in enumerate(zones):
            if zone.shear_modulus is not None and "shear_modulus" not in cls.model_fields:
                raise refusal("this law needs modulus_factor instead", key=f"{i}.shear_modulus")
        return zones

    @property
    def thicknesses(self) -> tuple[float, ...]:
        """Thickness of each zone, then that of the rest (µm)."""
        return (*(zone.thickness or self.thickness for zone in self.zone), self.thickness)


def _exponent(value: float) -> float:
    if value == 0:
        raise refusal("must not be 0")
    if abs(value) < _LEAST_EXPONENT:
        raise refusal(f"must be at least {_LEAST_EXPONENT:g} in magnitude")
    return value


_Exponent = Annotated[float, AfterValidator(_exponent)]


class Wall(_Wall):
    """A wall with the one-term Ogden energy of the paper, equation (9)."""

    law: Literal["ogden"] = _LAW
    shear_modulus: Pressure = Field(gt=0, description="shear modulus µ (MPa)")
    ogden_exponent: _Exponent = Field(default=2.0, description="Ogden exponent α, not 0 (1)")


class OgdenWall(_Wall):
    """A wall with an Ogden energy of several terms."""

    law: Literal["ogden"] = _LAW
    shear_moduli: ListOf[Pressure] = Field(
        description="modulus of each term; their sum is the shear modulus (MPa)"
    )
    ogden_exponents: ListOf[_Exponent] = Field(description="Ogden exponent of each term, not 0 (1)")

    @field_validator("shear_moduli")
    @classmethod
    def _stiff_at_rest(cls, moduli: tuple[float, ...]) -> tuple[float, ...]:
        if not sum(moduli) > 0:
            raise refusal("the sum of the moduli must be > 0")
        return moduli

    @field_validator("ogden_exponents")
    @classmethod
    def _one_per_modulus(
        cls, exponents: tuple[float, ...], info: ValidationInfo
    ) -> tuple[float, ...]:
        moduli = info.data.get("shear_moduli")
        if moduli is not None and len(exponents) != len(moduli):
            raise refusal(f"expected {len(moduli)} exponents, one per modulus")
        return exponents

    @property
    def shear_modulus(self) -> float:
        """Shear modulus at small strain (MPa)."""
        return sum(self.shear_moduli)


class LinearWall(_Wall):
    """A Saint Venant–Kirchhoff wall: stress linear in the Green-Lagrange strain."""

    law: Literal["linear"] = Field(description="material law: Saint Venant–Kirchhoff")
    young_modulus: Pressure = Field(gt=0, description="Young's modulus E (MPa)")
    poisson_ratio: float = Field(gt=-1, lt=1, description="Poisson's ratio ν in plane stress (1)")

    @property
    def shear_modulus(self) -> float:
        """Shear modulus (MPa)."""
        return self.young_modulus / (2 * (1 + self.poisson_ratio))


def _law(value: object) -> str | None:
    if isinstance(value, _Wall):
        return f"{BRANCH}{_KINDS[type(value)]}"
    if not isinstance(value, Mapping):
        return None
    law = value.get("law", "ogden")
    lists = "ogden_exponents" in value and "shear_modulus" not in value
    terms = law == "ogden" and ("shear_moduli" in value or lists)
    return f"{BRANCH}ogden terms" if terms else f"{BRANCH}{law}"


_KINDS: dict[type[Any], str] = {Wall: "ogden", OgdenWall: "ogden terms", LinearWall: "linear"}

AnyWall = Annotated[
    Annotated[Wall, Tag(f"{BRANCH}ogden")]
    | Annotated[OgdenWall, Tag(f"{BRANCH}ogden terms")]
    | Annotated[LinearWall, Tag(f"{BRANCH}linear")],
    Discriminator(_law),
]
