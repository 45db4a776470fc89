"""The JSON Schema and the checker agree: what the schema refuses, the checker refuses too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

jsonschema = pytest.importorskip("jsonschema")

from behaviors import drone_vocabulary  # noqa: E402
from fsm.fleet import read_fleet  # noqa: E402
from fsm.schema import mission_schema  # noqa: E402
from tests.fsm.test_faults import CASES, SHIPPED  # noqa: E402
from tests.fsm.toy import VOCABULARY, faults_of  # noqa: E402
from vencejo.errors import UserError  # noqa: E402
from vencejo.nodes import Mapping, Scalar, YamlNode, read_text  # noqa: E402
from vencejo.units import parse_number  # noqa: E402

ROOT = Path(__file__).parents[2]
FAULTS = sorted((Path(__file__).parent / "faults").glob("*.yaml"))
DRONE = mission_schema(drone_vocabulary())
TOY = mission_schema(VOCABULARY)


def plain(node: YamlNode) -> Any:
    """A node as an editor sees it, by YAML 1.2."""
    if isinstance(node, Mapping):
        return {key.text: plain(value) for key, value in node}
    if not isinstance(node, Scalar):
        return [plain(item) for item in node.items]
    if node.null:
        return None
    if node.plain and node.text in ("true", "false"):
        return node.text == "true"
    number = parse_number(node.text) if node.plain else None
    return node.text if number is None else number


def refuses(schema: dict[str, Any], text: str) -> list[str]:
    validator = jsonschema.Draft202012Validator(schema)
    return [error.message for error in validator.iter_errors(plain(read_text(text, "m.yaml")))]


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(DRONE)


@pytest.mark.parametrize("path", sorted((ROOT / "missions").glob("*.yaml")), ids=lambda p: p.stem)
def test_every_shipped_mission_validates(path: Path) -> None:
    assert refuses(DRONE, path.read_text()) == []


@pytest.mark.parametrize("text", SHIPPED)
def test_what_has_no_fault_validates(text: str) -> None:
    assert refuses(TOY, text) == []


TEXTS = {case[0]: case[1] for case in CASES} | {path.stem: path.read_text() for path in FAULTS}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_what_the_schema_refuses_the_checker_refuses(text: str) -> None:
    try:
        refused = refuses(TOY, text)
    except UserError:
        return  # no YAML at all: nothing to validate
    if refused:
        assert [f for f in faults_of(text) if f.severity == "error"], refused


FORM = (
    "bad-event", "bad-name", "empty-transition", "missing-key", "missing-parameter",
    "misplaced-for", "misplaced-include", "misplaced-initial", "no-behaviour", "no-states",
    "not-live", "not-yet", "unknown-key", "unknown-language", "unknown-parameter", "unknown-type",
    "unknown-word",
)  # fmt: skip


@pytest.mark.parametrize("code", FORM)
def test_a_mistake_of_form_is_refused_by_the_schema_too(code: str) -> None:
    text = (Path(__file__).parent / f"faults/{code}.yaml").read_text()
    assert refuses(TOY, text), text


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("stats: {a: {}}\n", "'stats' was unexpected"),
        ("states: {a: {dp: go}}\n", "was unexpected"),
        ("states: {a: {do: go, with: {heigth: 2}}}\n", "'heigth' was unexpected"),
        ("states: {a: {do: go, live: {height: 2}}}\n", "'height' was unexpected"),
        ("states: {a: {do: rise}}\n", "is not valid under any of the given schemas"),
        ("states: {a: {do: go, with: {speed: 20}}}\n", "greater than the maximum"),
        ("states: {a: {do: go, with: {color: rad}}}\n", "is not valid under any"),
        ("states: {a: {with: {x: 1}}}\n", "is not valid under any"),
        ("states: {a: {type: final, on: {done: a}}}\n", "'on' is not one of"),
        ("states: {a: {on: {done: }}}\n", "None is not valid"),
        ("states: {A: {}}\n", "does not match"),
    ],
)  # fmt: skip
def test_what_an_editor_can_show_at_once(text: str, part: str) -> None:
    assert any(part in message for message in refuses(TOY, text)), refuses(TOY, text)
    assert any(fault.severity == "error" for fault in faults_of(text))


FLEET = "fleet: f\nvehicles: {cat: {mission: cat.yaml, with: {speed: 2}}}\nuntil: time > 5 s\n"


def test_fleets_validate_too(tmp_path: Path) -> None:
    more = "{mission: cat.yaml, start: {at: [1, 2], heading: 90 deg}, color: red, model: swift}"
    for right in (
        FLEET,
        FLEET.replace("{mission: cat.yaml, with: {speed: 2}}", more),
        "fleet: f\nvehicles: {cat: {color: [1, 2, 3]}}\nuntil: time > 5 s\n",
    ):
        assert refuses(DRONE, right) == []
    for wrong in (
        FLEET.replace("mission", "misson"),
        FLEET.replace("until", "untl"),
        FLEET.replace("cat:", "Cat:"),
        "fleet: f\n",
    ):
        (tmp_path / "f.yaml").write_text(wrong)
        assert refuses(DRONE, wrong), wrong
        assert read_fleet(tmp_path / "f.yaml")[1], wrong


GRAPHS = """
states: {a: {include: scan, with: {x: 1}, breakpoint: true, on: {done: end}}, end: {type: final}}
graphs:
  scan: {parameters: {x: 0}, states: {b: {do: wait, on: {done: end}}, end: {type: final}}}
"""


def test_graphs_in_graphs_validate_too() -> None:
    assert refuses(TOY, GRAPHS) == []
    assert refuses(TOY, GRAPHS.replace("breakpoint: true", "breakpoint: 3"))
    assert refuses(TOY, GRAPHS.replace("parameters:", "paramters:"))
    assert refuses(TOY, GRAPHS.replace("include: scan", "include: [scan]"))


def test_behaviours_are_explained() -> None:
    names = {one.get("const"): one for one in DRONE["$defs"]["state"]["properties"]["do"]["anyOf"]}
    assert {"takeoff", "land", "goto"} <= set(names)
    assert names["goto"]["description"].startswith("Fly")
    (goto,) = [
        rule["then"]["properties"]
        for rule in DRONE["else"]["allOf"]
        if rule["if"]["properties"]["do"]["const"] == "goto"
    ]
    assert "(a speed, default 2.0)" in goto["with"]["properties"]["speed"]["description"]
    assert goto["on"]["properties"]["done"]["description"].startswith("goto ends with done")
