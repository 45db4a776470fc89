# ruff: noqa: E501  (tables keep their lines)
"""Quantities and dimensions."""

from __future__ import annotations

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vencejo.errors import UserError, Where
from vencejo.units import (
    ACCELERATION,
    ANGLE,
    ENERGY,
    FORCE,
    LENGTH,
    MASS,
    POWER,
    RATIO,
    SPEED,
    TIME,
    TURN_RATE,
    UNITS,
    Dimension,
    format_quantity,
    in_unit,
    parse_number,
    parse_quantity,
    read_quantity,
)


@pytest.mark.parametrize(
    ("text", "value", "dimension"),
    [
        ("12 s", 12.0, TIME),
        ("250 ms", 0.25, TIME),
        ("2min", 120.0, TIME),
        ("1.5 m/s", 1.5, SPEED),
        ("10 km/h", 10 / 3.6, SPEED),
        ("50 cm", 0.5, LENGTH),
        ("-3 m", -3.0, LENGTH),
        ("30 deg", pi / 6, ANGLE),
        ("20 deg/s", pi / 9, TURN_RATE),
        ("30 %", 0.3, RATIO),
        ("2 m/s2", 2.0, ACCELERATION),
        ("2 m/s^2", 2.0, ACCELERATION),
        ("4 N", 4.0, FORCE),
        ("11 Wh", 39600.0, ENERGY),
        ("1e3 g", 1.0, MASS),
    ],
)
def test_quantity(text: str, value: float, dimension: Dimension) -> None:
    found = parse_quantity(text)
    assert found is not None
    assert found[0] == pytest.approx(value, rel=1e-15)
    assert found[1] == dimension


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("10 cm", 0.1),
        ("30 %", 0.3),
        ("70 cm", 0.7),
        ("3 mm", 0.003),
        ("100 ms", 0.1),
        ("7 g", 0.007),
    ],
)
def test_decimal_units_are_exact(text: str, value: float) -> None:
    found = parse_quantity(text)
    assert found is not None
    assert found[0] == value


@pytest.mark.parametrize(
    "text", ["", "m", "12", "12 x", "12 s s", "1,5 m", "0x1 m", "1_0 m", "s 12"]
)
def test_no_quantity(text: str) -> None:
    assert parse_quantity(text) is None


@pytest.mark.parametrize(
    ("text", "number"),
    [("4", 4), ("-0.5", -0.5), ("1e-3", 0.001), (".5", 0.5), ("5.", 5.0), ("010", None), ("-05", None), ("0.5", 0.5), ("0", 0), ("1:30", None),
     ("0x10", None), ("1_000", None), ("", None), ("nan", None), ("inf", None), ("٣", None)],
)  # fmt: skip
def test_number(text: str, number: float | None) -> None:
    found = parse_number(text)
    assert found == number
    assert type(found) is type(number)


@pytest.mark.parametrize(
    ("text", "dimension", "code", "hint"),
    [
        ("12 s", SPEED, "wrong-dimension", "1.5 m/s"),
        ("12 lightyears", LENGTH, "unknown-unit", "km"),
        ("12 mmm", LENGTH, "unknown-unit", "'mm'"),
        ("fast", SPEED, "wrong-type", "1.5 m/s"),
        ("", TIME, "wrong-type", "10 s"),
        ("1,5 m", LENGTH, "wrong-type", "2 m"),
    ],
)
def test_what_does_not_fit(text: str, dimension: Dimension, code: str, hint: str) -> None:
    where = Where("m.yaml", 3, 7)
    with pytest.raises(UserError) as raised:
        read_quantity(text, dimension, where)
    (fault,) = raised.value.faults
    assert (fault.code, fault.where) == (code, where)
    assert hint in (fault.hint or "")


def test_a_bare_number_fits_every_dimension() -> None:
    assert read_quantity("4", LENGTH) == read_quantity("4", TIME) == 4.0


def test_dimensions_multiply() -> None:
    assert SPEED.times(TIME) == LENGTH
    assert LENGTH.times(TIME, -1) == SPEED
    assert TURN_RATE.times(LENGTH) == SPEED, "a radian is metres over metres"
    assert FORCE.times(LENGTH) == ENERGY
    assert ENERGY.times(TIME, -1) == POWER
    assert str(SPEED) == "a speed"
    assert str(LENGTH.times(LENGTH)) == "m2"


@pytest.mark.parametrize(
    ("value", "dimension", "text"),
    [(1.5, SPEED, "1.5 m/s"), (pi / 2, ANGLE, "90 deg"), (0.3, RATIO, "30 %"), (2.0, None, "2"),
     (pi, TURN_RATE, "180 deg/s"), (3.0, LENGTH.times(LENGTH), "3")],
)  # fmt: skip
def test_format(value: float, dimension: Dimension | None, text: str) -> None:
    assert format_quantity(value, dimension) == text


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(UNITS)))
def test_a_quantity_reads_as_its_number_times_its_unit(value: float, unit: str) -> None:
    size, dimension = UNITS[unit]
    assert read_quantity(f"{value!r} {unit}", dimension) == pytest.approx(value * size)
    assert in_unit(value, unit) == pytest.approx(value * size)


@given(st.text(max_size=20) | st.from_regex(r"[+-]?[0-9.eE]{0,500} ?[a-z%/]{0,4}", fullmatch=True))
def test_any_text_gives_a_number_or_a_user_error(text: str) -> None:
    try:
        assert isinstance(read_quantity(text, LENGTH), float)
    except UserError as error:
        assert error.code in ("wrong-type", "unknown-unit", "wrong-dimension")


DIMENSIONS = st.tuples(st.integers(-3, 3), st.integers(-3, 3)).map(lambda t: Dimension(*t))


@given(DIMENSIONS, DIMENSIONS)
def test_a_product_divided_is_what_it_was(a: Dimension, b: Dimension) -> None:
    assert a.times(b) == b.times(a)
    assert a.times(b).times(b, -1) == a
