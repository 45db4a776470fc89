"""The guide on one page: it leaves nothing out, and it stays short."""

from __future__ import annotations

import re
from functools import cache
from typing import get_args

import pytest

from behaviors import drone_vocabulary
from fsm.language.keys import AT, Place
from fsm.values.functions import FUNCTIONS
from fsm.values.types import NAMED
from tests.cli.run_cli import run_cli
from vencejo.units import UNITS
from worlds import world_names

VOCABULARY = drone_vocabulary()


@cache
def page() -> str:
    result = run_cli("guide")
    assert (result.code, result.err) == (0, "")
    return result.out


def test_it_is_one_page() -> None:
    assert len(page().split()) <= 6500


@pytest.mark.parametrize("place", get_args(Place))
def test_every_key_is_explained(place: Place) -> None:
    for name, key in AT[place].items():
        lines = [line for line in page().splitlines() if line.startswith(f"- `{name}`")]
        assert any(line.endswith(f": {key.help}") for line in lines), name
        for word in key.kind.options:
            assert any(re.search(rf"\b{word}\b", line.partition(":")[0]) for line in lines), word


@pytest.mark.parametrize("name", VOCABULARY.behaviors)
def test_every_behaviour_is_explained(name: str) -> None:
    behavior = VOCABULARY.behaviors[name]
    section = page().partition("## Behaviours")[2].partition(f"\n`{name}`: ")[2]
    lines = section.partition("\n\n`")[0].splitlines()
    for parameter in behavior.parameters.values():
        (line,) = [line for line in lines if line.startswith(f"- `{parameter.name}`: ")]
        assert str(parameter.type) in line and line.endswith(parameter.help)
        assert parameter.live == ("live)" in line) and parameter.required == ("required" in line)
    (outcomes,) = [line for line in lines if line.startswith("- outcomes: ")]
    for word, fields in behavior.outcomes.items():
        assert re.search(rf"\b{word}\b", outcomes) and all(field in outcomes for field in fields)
    for event, fields in behavior.events.items():
        (line,) = [line for line in lines if line.startswith(f"- raises `{event}`")]
        assert all(field in line for field in fields)
    assert all(f"`{name}.{value}`" in section for value in behavior.publishes)


def test_events_functions_types_units_and_worlds_are_listed() -> None:
    text = page()
    for event, fields in VOCABULARY.events.items():
        (line,) = [line for line in text.splitlines() if line.startswith(f"- `{event}`")]
        assert all(f"`event.{field}`" in line for field in fields)
        assert VOCABULARY.is_urgent(event) == ("urgent" in line)
    for function in VOCABULARY.functions.values():
        begin = f"- `{function.name}`: {function.help}"
        (line,) = [line for line in text.splitlines() if line.startswith(begin)]
        assert all(f"`{parameter}`" in line for parameter in function.parameters)
    for name in FUNCTIONS:
        assert f"`{name}(" in text
    for word in (*NAMED, *UNITS, *world_names(), "vehicle.position", "vehicle.home", "forest:1"):
        assert f"`{word}`" in text


def test_its_examples_have_no_mistake() -> None:
    from pathlib import Path

    examples = re.findall(r"```yaml\n(.*?)```", page(), re.DOTALL)
    assert len(examples) == 3
    for number, example in enumerate(examples):
        Path(f"{number}.yaml").write_text(example)
    assert run_cli("check", "--strict", "0.yaml", "1.yaml", "2.yaml").code == 0
