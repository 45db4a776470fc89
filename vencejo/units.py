"""Quantities: numbers with units, and the dimensions that values must have.

Values are converted to SI units and radians. A dimension counts powers of the base units; the
ratio (``30 %``) is the dimension of zero powers, and a *bare* number, one written without a unit,
has no dimension (``None``) and fits every one.
"""

from __future__ import annotations

import re
from math import pi
from typing import NamedTuple

from vencejo.errors import UserError, Where, nearest


class Dimension(NamedTuple):
    """Powers of metre, second, radian, kilogram and ampere."""

    length: int = 0
    time: int = 0
    angle: int = 0
    mass: int = 0
    current: int = 0

    def times(self, other: Dimension, sign: int = 1) -> Dimension:
        """The dimension of a product (or, with ``sign=-1``, of a quotient)."""
        result = Dimension(*(a + sign * b for a, b in zip(self, other, strict=True)))
        # A radian is metres over metres: ω·r is a speed.
        return result._replace(angle=0) if result.angle and result.length else result

    def __str__(self) -> str:
        return NAMES.get(self) or "·".join(
            f"{unit}{power if power != 1 else ''}"
            for unit, power in zip(("m", "s", "rad", "kg", "A"), self, strict=True)
            if power
        )


RATIO = Dimension()
LENGTH = Dimension(length=1)
TIME = Dimension(time=1)
ANGLE = Dimension(angle=1)
SPEED = Dimension(length=1, time=-1)
ACCELERATION = Dimension(length=1, time=-2)
TURN_RATE = Dimension(time=-1, angle=1)
FREQUENCY = Dimension(time=-1)
MASS = Dimension(mass=1)
FORCE = Dimension(length=1, time=-2, mass=1)
ENERGY = Dimension(length=2, time=-2, mass=1)
POWER = Dimension(length=2, time=-3, mass=1)
INERTIA = Dimension(length=2, mass=1)
VOLTAGE = Dimension(length=2, time=-3, mass=1, current=-1)
RESISTANCE = Dimension(length=2, time=-3, mass=1, current=-2)

NAMES = {
    RATIO: "a ratio",
    LENGTH: "a length",
    TIME: "a time",
    ANGLE: "an angle",
    SPEED: "a speed",
    ACCELERATION: "an acceleration",
    TURN_RATE: "a turn rate",
    FREQUENCY: "a frequency",
    MASS: "a mass",
    FORCE: "a force",
    ENERGY: "an energy",
    POWER: "a power",
    INERTIA: "a moment of inertia",
    VOLTAGE: "a voltage",
    RESISTANCE: "a resistance",
}
EXAMPLES = {
    RATIO: "30 %",
    LENGTH: "2 m",
    TIME: "10 s",
    ANGLE: "90 deg",
    SPEED: "1.5 m/s",
    ACCELERATION: "2 m/s2",
    TURN_RATE: "30 deg/s",
    FREQUENCY: "20 Hz",
    MASS: "0.4 kg",
    FORCE: "4 N",
    ENERGY: "11 Wh",
    POWER: "50 W",
    INERTIA: "0.003, in kg m²",
    VOLTAGE: "11.1 V",
    RESISTANCE: "0.06 ohm",
}

_BASE: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, LENGTH),
    "cm": (0.01, LENGTH),
    "mm": (0.001, LENGTH),
    "km": (1000.0, LENGTH),
    "s": (1.0, TIME),
    "ms": (0.001, TIME),
    "min": (60.0, TIME),
    "h": (3600.0, TIME),
    "rad": (1.0, ANGLE),
    "deg": (pi / 180, ANGLE),
    "Hz": (1.0, FREQUENCY),
    "kg": (1.0, MASS),
    "g": (0.001, MASS),
    "N": (1.0, FORCE),
    "W": (1.0, POWER),
    "J": (1.0, ENERGY),
    "Wh": (3600.0, ENERGY),
    "V": (1.0, VOLTAGE),
    "ohm": (1.0, RESISTANCE),
    "%": (0.01, RATIO),
}


def _derived() -> dict[str, tuple[float, Dimension]]:
    units = dict(_BASE)
    for top in ("m", "cm", "mm", "km", "rad", "deg"):
        for below in ("s", "min", "h"):
            size, dimension = _BASE[top]
            per, time = _BASE[below]
            units[f"{top}/{below}"] = (size / per, dimension.times(time, -1))
        for square in ("s2", "s^2"):
            units[f"{top}/{square}"] = (size, dimension.times(TIME, -1).times(TIME, -1))
    return units


UNITS: dict[str, tuple[float, Dimension]] = _derived()
"""Every unit by its name: its size in SI and its dimension."""

UNSIGNED = r"(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""A decimal number; with a leading zero (`010`) it is a text."""
NUMBER = rf"[+-]?{UNSIGNED}"
_NUMBER = re.compile(NUMBER)
_QUANTITY = re.compile(rf"({NUMBER})\s*(%|[A-Za-z][A-Za-z0-9/^]*)")
_UNIT_WORD = re.compile(r"[a-zA-Z%°µ]")


def parse_number(text: str) -> int | float | None:
    """The number of a text such as ``4``, ``-0.5`` or ``1e-3``; None for any other text."""
    if not _NUMBER.fullmatch(text):
        return None
    # Python refuses to read an integer of thousands of digits.
    return float(text) if any(mark in text for mark in ".eE") or len(text) > 300 else int(text)


def parse_quantity(text: str) -> tuple[float, Dimension] | None:
    """The SI value and dimension of a text such as ``12 s``; None when it is no known quantity."""
    match = _QUANTITY.fullmatch(text)
    if not match or match[2] not in UNITS:
        return None
    return in_unit(float(match[1]), match[2]), UNITS[match[2]][1]


def in_unit(value: float, unit: str) -> float:
    """The SI value of ``value`` units; dividing by whole numbers makes ``10 cm`` exactly 0.1."""
    size = UNITS[unit][0]
    inverse = round(1 / size) if size < 1 else 0
    return value / inverse if inverse and abs(inverse * size - 1) < 1e-12 else value * size


def read_quantity(text: str, dimension: Dimension, where: Where | None = None) -> float:
    """The SI value of a text that must be a quantity of ``dimension``, or a bare number.

    Raises UserError (``wrong-type``, ``unknown-unit``, ``wrong-dimension``).
    """
    number = parse_number(text)
    if number is not None:
        return float(number)
    example = example_of(dimension)
    quantity = parse_quantity(text)
    if quantity is None:
        match = re.match(rf"{NUMBER}\s*(.*)", text)
        if match and match[1] and _UNIT_WORD.match(match[1]):
            known = [name for name, (_, d) in UNITS.items() if d == dimension]
            raise UserError(
                "unknown-unit",
                f"'{match[1]}' is no unit",
                where,
                nearest(match[1], known, otherwise=f"{example} ({', '.join(known)})"),
            )
        if re.match(r"[+-]?0[0-9]", text):
            example = f"a number has no leading zero; {example}"
        raise UserError("wrong-type", f"'{text}' is not {dimension}", where, example)
    value, found = quantity
    if found != dimension:
        raise UserError(
            "wrong-dimension",
            f"'{text}' is {found}, but {dimension} is needed here",
            where,
            example,
        )
    return value


def example_of(dimension: Dimension) -> str:
    """A hint that shows how a quantity is written: ``write a time like 10 s``."""
    return f"write {NAMES.get(dimension, 'it')} like {EXAMPLES.get(dimension, '1.0')}"


def format_quantity(value: float, dimension: Dimension | None) -> str:
    """Format an SI value with a common unit: ``1.5 m/s``, ``90 deg``, ``30 %``."""
    if dimension is None:
        return f"{value:g}"
    if dimension == RATIO:
        return f"{value * 100:g} %"
    if dimension == ANGLE:
        return f"{value * 180 / pi:g} deg"
    if dimension == TURN_RATE:
        return f"{value * 180 / pi:g} deg/s"
    si = {LENGTH: "m", TIME: "s", SPEED: "m/s", FREQUENCY: "Hz", MASS: "kg", ACCELERATION: "m/s2"}
    return f"{value:g} {si.get(dimension, '')}".rstrip()
