"""The schema of world files says what the loader says, as far as a schema can."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from tests.worlds.faults import SHAPE_FAULTS
from vencejo.nodes import Mapping, Scalar, YamlNode, read_file, read_text
from vencejo.units import parse_number
from worlds import find_world, world_names
from worlds.world_schema import HELP, world_schema

SCHEMA = Draft202012Validator(world_schema())


def plain(node: YamlNode) -> Any:
    """The values that a YAML 1.2 reader gives for a file."""
    if isinstance(node, Mapping):
        return {key.text: plain(value) for key, value in node}
    if not isinstance(node, Scalar):
        return [plain(item) for item in node.items]
    words = {"true": True, "false": False}
    number = parse_number(node.text)
    if node.null or not node.plain:
        return None if node.null else node.text
    return words.get(node.text, node.text if number is None else number)


def test_it_is_a_schema() -> None:
    Draft202012Validator.check_schema(world_schema())


@pytest.mark.parametrize("name", world_names())
def test_it_takes_the_shipped_worlds(name: str) -> None:
    assert list(SCHEMA.iter_errors(plain(read_file(find_world(name).source)))) == []


def test_it_takes_the_example_of_the_guide() -> None:
    guide = (Path(__file__).parents[2] / "docs" / "worlds.md").read_text()
    for block in guide.split("```yaml\n")[1:]:
        text = block.split("```")[0]
        if text.startswith(("world:", "# file: ")):
            assert list(SCHEMA.iter_errors(plain(read_text(text, "guide")))) == []


@pytest.mark.parametrize("text", [text for text, _ in SHAPE_FAULTS])
def test_it_refuses_what_the_loader_refuses(text: str) -> None:
    assert not SCHEMA.is_valid(plain(read_text(text, "w.yaml")))


def test_every_key_is_explained() -> None:
    explained = set()

    def look(schema: Any) -> None:
        if isinstance(schema, list):
            for part in schema:
                look(part)
        elif isinstance(schema, dict):
            for key, value in schema.get("properties", {}).items():
                assert value["description"] == HELP[key]
                explained.add(key)
            for part in schema.values():
                look(part)

    look(world_schema())
    assert explained == set(HELP)
