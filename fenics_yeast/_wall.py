"""The table `[wall]` of a scene: thickness and material of the cell wall."""

from __future__ import annotations

from pydantic import Field, field_validator

from fenics_yeast._quantities import Length, Pressure, refusal
from fenics_yeast._table import Table


class Wall(Table):
    """The cell wall: its thickness and the Ogden energy of its material, equation (9)."""

    thickness: Length = Field(gt=0, description="thickness of the wall (µm)")
    shear_modulus: Pressure = Field(gt=0, description="shear modulus µ (MPa)")
    ogden_exponent: float = Field(
        default=2.0, description="Ogden's exponent α, any number but 0 (1)"
    )

    @field_validator("ogden_exponent")
    @classmethod
    def _not_zero(cls, value: float) -> float:
        if value == 0:
            raise refusal("", allowed="any number but 0 is allowed")
        return value
