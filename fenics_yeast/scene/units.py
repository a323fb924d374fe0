"""Quantities of a scene: numbers in µm, MPa, min and degrees, read from strings with units."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from math import inf
from numbers import Real
from typing import TYPE_CHECKING, Annotated

from pydantic import BeforeValidator

from .errors import refusal

if TYPE_CHECKING:
    from pint import UnitRegistry

# Only the units of this field: pint's own list takes 0.3 s to load, and would accept slips such as
# "5 in". Read with decimals, "100 nm" is 0.1 to the last digit.
_UNITS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
micron = 1e-6 * meter
second = [time] = s = sec
minute = 60 * second = min
hour = 3600 * second = h = hr
day = 86400 * second = d
gram = [mass] = g
newton = 1000 * gram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
atmosphere = 101325 * pascal = atm
radian = [angle] = rad
degree = 0.01745329251994329576923690768 * radian = deg
"""
# Units that need no pint, in those in which quantities are stored.
_USUAL = {
    symbol: {name: Decimal(value) for name, value in units.items()}
    for symbol, units in {
        "µm": {"µm": "1", "um": "1", "nm": "1e-3", "mm": "1e3"},
        "MPa": {"MPa": "1", "kPa": "1e-3", "Pa": "1e-6", "bar": "0.1", "atm": "0.101325"},
        "min": {"min": "1", "h": "60"},
        "µN": {"µN": "1", "uN": "1", "nN": "1e-3"},
        "degrees": {"deg": "1"},
    }.items()
}
_LARGEST = 1e30  # beyond it, products of values overflow
_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?)\s*(.*?)\s*")
_UNIT = re.compile(r"[^\W\d_]+(\s*[*/]\s*[^\W\d_]+((\^|\*\*)[23])?){0,3}")


@cache
def _registry() -> UnitRegistry[Decimal]:
    import pint  # late: 0.15 s, and a scene of plain numbers does not need it

    registry: UnitRegistry[Decimal] = pint.UnitRegistry(None, non_int_type=Decimal)
    registry.load_definitions(_UNITS.strip().splitlines())
    return registry


@dataclass(frozen=True)
class Unit:
    """The unit in which a kind of quantity is stored; reads numbers and strings with units."""

    kind: str
    symbol: str
    example: str

    def read(self, value: object) -> object:
        """Return a number in this unit; leave values of another type for pydantic to refuse."""
        if isinstance(value, str):
            number = self._convert(value)
        elif isinstance(value, bool) or not isinstance(value, Real):
            return value
        else:
            try:
                number = float(value)
            except OverflowError:
                number = inf
        if _LARGEST < abs(number) < inf:
            raise refusal(reason=f"larger than {_LARGEST:g} {self.symbol}")
        return number

    def _convert(self, text: str) -> float:
        match = _NUMBER_AND_UNIT.fullmatch(text)
        if match is None:
            raise refusal(reason="not a number with a unit")
        number, name = match[1], "deg" if match[2] == "°" else match[2]
        if not name:
            raise refusal(reason="no unit")
        if name in _USUAL.get(self.symbol, {}):
            return float(Decimal(number) * _USUAL[self.symbol][name])
        registry = _registry()
        from pint import PintError

        try:
            if _UNIT.fullmatch(name) is None:
                raise ValueError
            unit = registry.parse_units(name)
        except (PintError, ValueError, ArithmeticError):
            raise refusal(reason=f'unknown unit "{name[:20]}"') from None
        if not unit.is_compatible_with(self.symbol):
            raise refusal()
        return float(registry.Quantity(Decimal(number), unit).to(self.symbol).magnitude)


LENGTH = Unit("a length", "µm", '"100 nm"')
PRESSURE = Unit("a pressure or stress", "MPa", '"2 atm"')
TIME = Unit("a time", "min", '"45 min"')
FORCE = Unit("a force", "µN", '"1 uN"')
ANGLE = Unit("an angle", "degrees", '"24 deg"')

Length = Annotated[float, BeforeValidator(LENGTH.read), LENGTH]
Pressure = Annotated[float, BeforeValidator(PRESSURE.read), PRESSURE]
Time = Annotated[float, BeforeValidator(TIME.read), TIME]
Force = Annotated[float, BeforeValidator(FORCE.read), FORCE]
Angle = Annotated[float, BeforeValidator(ANGLE.read), ANGLE]
