"""The wind of a world, as world files and the command line write it.

The short form is a text, ``5 m/s@270 deg``, with any further keys behind it:
``5 m/s@270 deg, gusts=8 m/s, turbulence=light``. Bearings are those of weather reports: where the
wind comes from, clockwise from north, in degrees.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

from vencejo.errors import UserError, Where
from vencejo.nodes import Mapping, Scalar, YamlNode, kind, read_text
from vencejo.units import SPEED, TIME
from worlds.values import SIZE, Field, Misfit, Value, above_zero, array, degrees, quantity, record
from worlds.world import Gusts, Wind

TURBULENCE = {"light": 15 * 1852 / 3600, "moderate": 30 * 1852 / 3600, "severe": 45 * 1852 / 3600}
"""Wind 20 feet above ground, m/s: 15, 30 and 45 knots (MIL-F-8785C, 3.7)."""
NATURAL = "natural"
"""The word for the turbulence that the mean wind makes."""
_TWENTY_FEET = 6.096
STILL = "none"
"""The word for no wind."""
_STRONGEST = 100.0
"""The largest speed of a wind, m/s."""
_SPEED = quantity(SPEED, 0.0, _STRONGEST)
_EXAMPLE = "write 5 m/s@270 deg: its speed, and the compass bearing it comes from"
_LONGEST = 1e5
_DURATION, _EVERY = 5.0, 20.0


def _turbulence(node: YamlNode) -> float | str:
    word = node.text if isinstance(node, Scalar) else ""
    if word == NATURAL:
        return NATURAL
    if word in TURBULENCE:
        return TURBULENCE[word]
    try:
        return _SPEED.read(node)
    except UserError as error:
        words = ", ".join((NATURAL, *TURBULENCE))
        fault = replace(error.faults[0], hint=f"a speed, or one of {words}")
        raise UserError.of([fault]) from None


def _gusts(to: float, duration: float, every: float | None, at: tuple[float, ...]) -> Gusts:
    if every is not None and at:
        raise Misfit("bad-gusts", "gusts come at given times or every so often, not both", "at")
    mean = _EVERY if every is None else every
    if not at and mean <= duration:
        message = f"gusts of {duration:g} s cannot come every {mean:g} s"
        raise Misfit("bad-gusts", message, "every", "the time between two begins with the first")
    if any(later - earlier < duration for earlier, later in pairwise(at)):
        message = f"these gusts overlap: each takes {duration:g} s"
        raise Misfit("bad-gusts", message, "at", "give their times in order, further apart")
    return Gusts(to, duration, mean, at)


_GUSTS = record(
    "gusts",
    {
        "to": Field(_SPEED),
        "duration": Field(above_zero(TIME, _LONGEST), _DURATION),
        "every": Field(above_zero(TIME, _LONGEST), None),
        "at": Field(array("times are a list", quantity(TIME, 0.0, _LONGEST), 1), ()),
    },
    _gusts,
)


def _any_gusts(node: YamlNode) -> Gusts:
    if isinstance(node, Scalar):
        return Gusts(_SPEED.read(node), _DURATION, _EVERY)
    return _GUSTS.read(node)


def _wind(**given: Any) -> Wind:
    bearing, gusts = given.pop("from"), given["gusts"]
    if gusts is not None and gusts.to <= given["speed"]:
        message = f"gusts to {gusts.to:g} m/s are no more than the wind of {given['speed']:g} m/s"
        raise Misfit("bad-gusts", message, "gusts", "`to` is the speed of the wind at their peak")
    roughness = given["roughness"]
    if roughness is not None and roughness >= given["height"]:
        message = f"a roughness of {roughness:g} m is not below the height of the wind"
        raise Misfit("out-of-range", message, "roughness", "grass is 3 cm, a town 1 m")
    turbulence = given.pop("turbulence")
    wind = Wind(bearing=bearing, **given)
    speed = wind.speed * wind.share_at(_TWENTY_FEET) if turbulence == NATURAL else turbulence
    return replace(wind, turbulence=speed)


_RECORD = record(
    "a wind",
    {
        "speed": Field(_SPEED),
        "from": Field(degrees(360.0)),
        "height": Field(SIZE, 10.0),
        "roughness": Field(SIZE, None),
        "gusts": Field(Value(_any_gusts, {"anyOf": [_SPEED.schema, _GUSTS.schema]}), None),
        "turbulence": Field(
            Value(_turbulence, {"anyOf": [{"enum": [NATURAL, *TURBULENCE]}, _SPEED.schema]}), 0.0
        ),
    },
    _wind,
)


def _short(text: Scalar) -> Mapping:
    """The map that a short form stands for."""
    first, *others = text.text.split(",")
    speed, at, bearing = first.partition("@")
    if not at or text.null:
        raise UserError(
            "wrong-type", f"a wind is needed here, not {kind(text)}", text.where, _EXAMPLE
        )
    pairs = [("speed", speed), ("from", bearing)]
    for other in others:
        key, equals, value = other.partition("=")
        if not equals:
            message = f"'{other.strip()}' is no key with a value"
            raise UserError("wrong-type", message, text.where, "write it like gusts=8 m/s")
        pairs.append((key, value))
    keys = [key.strip() for key, _ in pairs]
    for key in keys:
        if keys.count(key) > 1:
            raise UserError("duplicate-key", f"'{key}' is given twice", text.where)
    entries: list[tuple[Scalar, YamlNode]] = [
        (Scalar(key.strip(), text.where), Scalar(value.strip(), text.where)) for key, value in pairs
    ]
    return Mapping(entries, text.where)


def _read(node: YamlNode) -> Wind | None:
    if isinstance(node, Scalar):
        if node.text == STILL:
            return None
        node = _short(node)
    return _RECORD.read(node)


WIND = Value(
    _read, {"anyOf": [{"type": "string", "pattern": rf"^({STILL}|.+@.+)$"}, _RECORD.schema]}
)


def read_wind(text: str, name: str) -> Wind | None:
    """The wind of a text: the short form, or a map in braces; None for none.

    ``name`` stands for its place in errors. Raises UserError with every fault.
    """
    if text.lstrip().startswith("{"):
        return WIND.read(read_text(text, name))
    return WIND.read(Scalar(text.strip(), Where(name)))
