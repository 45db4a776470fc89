"""Values of world files: what is read, and the sentences about what is not."""

from __future__ import annotations

import pytest

from vencejo.errors import UserError, Where
from vencejo.nodes import Scalar
from vencejo.units import ANGLE, LENGTH, RATIO, SPEED
from worlds.values import Value, above_zero, degrees, quantity

WHERE = Where("w.yaml", 2, 7)


def read(value: Value[float], text: str) -> float:
    return value.read(Scalar(text, WHERE))


@pytest.mark.parametrize(
    ("value", "text", "expected"),
    [
        (quantity(LENGTH), "-250 cm", -2.5),
        (quantity(LENGTH, 1.0, 5.0), "1", 1.0),
        (quantity(LENGTH, 1.0, 5.0), "5 m", 5.0),
        (quantity(RATIO, 0.0, 1.0), "30 %", 0.3),
        (above_zero(SPEED, 10.0), "36 km/h", 10.0),
        (degrees(90.0), "45", 45.0),
        (degrees(90.0), "-90 deg", -90.0),
    ],
)
def test_what_is_read(value: Value[float], text: str, expected: float) -> None:
    assert read(value, text) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("value", "text", "told"),
    [
        (quantity(LENGTH, 1.0, 5.0), "7 m", "out-of-range: a length of 7 m; it must be 1 m to 5 m"),
        (quantity(LENGTH, 1.0, 5.0), "0.9", "out-of-range: a length of 0.9; it must be 1 m to 5 m"),
        (quantity(LENGTH), "1e999", "out-of-range: a length of 1e999; it must be a finite number"),
        (above_zero(SPEED, 10.0), "0 m/s", "bad-size: a speed of 0 m/s; it must be above 0"),
        (
            above_zero(SPEED, 10.0),
            "11",
            "out-of-range: a speed of 11; it must be -10 m/s to 10",
        ),
        (quantity(ANGLE), "5 m", "wrong-dimension"),
    ],
)
def test_what_is_not_read_says_why(value: Value[float], text: str, told: str) -> None:
    with pytest.raises(UserError) as refused:
        read(value, text)
    (fault,) = refused.value.faults
    assert f"{fault.code}: {fault.message}".startswith(told)
    assert fault.where == WHERE
