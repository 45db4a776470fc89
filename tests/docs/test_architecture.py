"""docs/architecture.md shows the imports as they are and names what there is."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest

from docs.draw_architecture import IMAGE, OPENED, Edges, House, draw, reachable, read_house, reduced

ROOT = Path(__file__).parents[2]
DOCUMENTS = ["docs/architecture.md", "CONTRIBUTING.md"]
ROOMS = ("vencejo", "fsm", "worlds", "hal", "behaviors", "runner", "cli", "tests", "bench", "docs")
ENTRY_POINTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
_CODE_BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
_QUALIFIED = re.compile(r"[a-z_]+(\.\w+)*:[A-Za-z_]\w*(\.\w+)*")
_MODULE = re.compile(rf"({'|'.join(ROOMS)})(\.\w+)+")
_PATH = re.compile(r"[\w.-]*/[\w./-]*|[\w-]+\.(md|py|toml|yaml|txt)|Makefile")


@pytest.fixture(scope="module")
def house() -> House:
    return read_house()


def exists(word: str) -> bool | None:
    """Whether there is what a word between backticks names; None where it is no name or path."""
    if word in ENTRY_POINTS:
        return True
    if _QUALIFIED.fullmatch(word) or _MODULE.fullmatch(word):
        module, _, inside = word.partition(":")
        try:
            found: object = import_module(module)
            for name in inside.split(".") if inside else ():
                found = getattr(found, name)
        except (ImportError, AttributeError):
            return False
        return True
    return (ROOT / word).exists() if _PATH.fullmatch(word) else None


def names_in(document: str) -> list[str]:
    text = _CODE_BLOCK.sub("", (ROOT / document).read_text("utf-8"))
    return [word for word in re.findall(r"`([^`]+)`", text) if exists(word) is not None]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_name_and_path_exists(document: str) -> None:
    assert [word for word in names_in(document) if not exists(word)] == []


def test_the_document_leads_to_many_places() -> None:
    assert len(set(names_in("docs/architecture.md"))) > 80


@pytest.mark.parametrize(
    ("word", "answer"),
    [
        ("hal.base", True),
        ("hal.bass", False),
        ("vencejo.backends", True),
        ("vencejo.back", False),
        ("runner.loop:fly", True),
        ("runner.loop:soar", False),
        ("runnner.loop:fly", False),
        ("hal.base:BaseVehicle.fly", True),
        ("hal.base:BaseVehicle.soar", False),
        ("fsm/language/keys.py", True),
        ("fsm/keys.py", False),
        ("missions/", True),
        ("CHANGES.md", False),
        ("vehicle.collision", None),
        ("forest:3", None),
        ("wait()", None),
        ("-p speed=3m/s", None),
    ],
)
def test_what_counts_as_a_name(word: str, answer: bool | None) -> None:
    assert exists(word) is answer


def test_the_picture_is_that_of_the_imports(house: House) -> None:
    assert IMAGE.read_text("utf-8") == draw(house), "draw it anew: python -m docs.draw_architecture"


def test_the_picture_changes_with_every_import(house: House) -> None:
    picture = draw(house)
    for name, others in house.imports.items():
        for other in others:
            fewer = {**house.imports, name: others - {other}}
            if "." in name or name not in OPENED:
                assert draw(replace(house, imports=fewer)) != picture, f"{name} → {other}"


def test_the_arrows_are_the_fewest_that_say_it_all(house: House) -> None:
    for edges in (house.packages, *(house.parts(package) for package in OPENED)):
        arrows = reduced(edges)
        assert follows(arrows) == follows(edges)
        for name, others in arrows.items():
            for other in others:
                assert follows({**arrows, name: others - {other}}) != follows(edges)


def follows(edges: Edges) -> Edges:
    return {name: reachable(edges, name) for name in edges}


def test_the_house_is_that_of_the_repository(house: House) -> None:
    assert {*house.packages} == {*ROOMS[:7]}
    assert {"runner", "hal"} <= house.packages["cli"]
    assert house.packages["vencejo"] == frozenset()
    assert "fsm.chart" in house.parts("fsm")["fsm.engine"]
    assert "hal.sim.bullet_renderers" in house.entry_points
