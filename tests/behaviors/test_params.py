"""Parameters as classes declare them, as the language sees them."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from math import inf, pi
from pathlib import Path
from typing import Any

import pytest

from behaviors import (
    Area,
    Behavior,
    BehaviorParams,
    Heading,
    Point,
    Registry,
    Route,
    describe,
    live,
    param,
    value,
)
from behaviors.behavior import name_of
from behaviors.params import fields_of, parameters_of
from fsm.values.types import ANY, AREA, BOOL, HEADING, POINT, ROUTE, ListOf, Number, Text
from vencejo.units import ANGLE, LENGTH, SPEED, TIME

ROOT = Path(__file__).parents[2]


class Everything(BehaviorParams):
    """One of each."""

    to: Point = live(help="where to")
    speed: float = param(36.0, unit="km/h", min=0, max=72)
    angle: float = param(90.0, unit="deg", max=180.0)
    factor: float = param(0.5)
    count: int = param(3, min=1)
    quick: bool = param(True)
    side: str = param("left", choices=("left", "right"))
    heading: Heading = live("keep")
    route: Route = param()
    area: Area = param()
    items: list = param([])  # type: ignore[type-arg]
    other: Any = param(None)
    timeout: float | None = param(None, unit="s", min=0.1)
    at: Point | None = live(None)
    maybe: Heading | None = param(None)
    not_a_parameter = 7


DECLARED = parameters_of(Everything)


def test_they_are_declared_in_order() -> None:
    assert [*DECLARED][:4] == ["to", "speed", "angle", "factor"]
    assert [*DECLARED][-2:] == ["at", "maybe"]


@pytest.mark.parametrize(
    ("name", "type_"),
    [
        ("to", POINT),
        ("speed", Number(SPEED, 0.0, 20.0)),
        ("angle", Number(ANGLE, -inf, pi)),
        ("factor", Number()),
        ("count", Number(None, 1, inf, whole=True)),
        ("quick", BOOL),
        ("side", Text(("left", "right"))),
        ("heading", HEADING),
        ("route", ROUTE),
        ("area", AREA),
        ("items", ListOf()),
        ("other", ANY),
        ("timeout", Number(TIME, 0.1)),
        ("at", POINT),
        ("maybe", HEADING),
    ],
)
def test_annotations_and_units_become_types(name: str, type_: object) -> None:
    assert DECLARED[name].type == type_


def test_defaults_are_si_and_what_has_none_is_required() -> None:
    assert DECLARED["speed"].default == pytest.approx(10.0)
    assert DECLARED["angle"].default == pytest.approx(pi / 2)
    assert [name for name, p in DECLARED.items() if p.required] == ["to", "route", "area"]
    assert [name for name, p in DECLARED.items() if p.live] == ["to", "heading", "at"]
    assert DECLARED["to"].help == "where to"


def test_an_object_has_defaults_and_what_it_is_given() -> None:
    params = Everything(to=Point(1, 2, 3))
    assert (params.to, params.count, params.timeout) == ((1, 2, 3), 3, None)
    assert Everything(count=5).count == 5
    assert Everything().count == 3


def test_params_inherit() -> None:
    class More(Everything):
        """And one again."""

        count: int = param(9)
        extra: float = param(1.0, unit="m")

    assert parameters_of(More)["count"].default == 9
    assert parameters_of(More)["extra"].type == Number(LENGTH)
    assert parameters_of(More)["speed"] == DECLARED["speed"]
    assert "extra" not in DECLARED


def test_an_unknown_unit_is_named() -> None:
    with pytest.raises(ValueError, match="there is no unit 'furlong'"):

        class Wrong(BehaviorParams):
            """Not of this system."""

            way: float = param(1.0, unit="furlong")


HERE = Point(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Sighting:
    """Something seen."""

    where: Point = HERE
    distance: float = value("m")
    certain: bool = False
    id: int = 0
    raw: object = None


def test_records_become_fields() -> None:
    assert fields_of(Sighting) == {
        "where": POINT,
        "distance": Number(LENGTH),
        "certain": BOOL,
        "id": Number(),
        "raw": ANY,
    }
    assert fields_of(None) == {}


class LookForTags(Behavior):
    """Looks."""

    outcomes = {"found": Sighting, "done": None}  # noqa: RUF012
    events = {"tag.seen": Sighting}  # noqa: RUF012
    publishes = Sighting
    controls = ("gimbal",)


def test_a_behaviour_is_described() -> None:
    info = describe(LookForTags)
    assert (info.name, info.help, info.controls) == ("look_for_tags", "Looks.", ("gimbal",))
    assert info.outcomes == {"found": fields_of(Sighting), "done": {}}
    assert info.events["tag.seen"]["distance"] == Number(LENGTH)
    assert info.blank == Sighting()
    assert name_of(LookForTags) == "look_for_tags"


def test_all_shipped_behaviours_say_what_they_are_for() -> None:
    catalog = Registry()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert list(catalog) == sorted(project["entry-points"]["vencejo.behaviors"])
    assert len(catalog) == len(list(catalog))
    for name, info in catalog.items():
        assert info.help, name
        for parameter in info.parameters.values():
            assert parameter.help or parameter.unit, f"{name}.{parameter.name}"
            if isinstance(parameter.type, Number) and parameter.default is not None:
                assert parameter.type.min <= parameter.default <= parameter.type.max
    assert "goto" in catalog and "gogo" not in catalog


def test_the_camera_that_a_parameter_names_is_needed_by_default_too() -> None:
    class Look(Behavior):
        """Looks."""

        class Params(BehaviorParams):
            camera: str = param("ventral", names="camera")
            other: str | None = param(None, names="camera")

    info = describe(Look)
    assert list(info.named({})) == ["camera.ventral"]
    assert list(info.named({"camera": "front", "other": "left"})) == [
        "camera.front",
        "camera.left",
    ]
    assert list(info.named({"camera": None})) == []
