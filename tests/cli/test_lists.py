from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from behaviors import Registry
from runner.missions import SHIPPED
from tests.cli.run_cli import run_cli
from tests.missions.shipped import FLEETS
from worlds import world_names


def test_bare_says_what_to_do_first() -> None:
    result = run_cli()
    assert result.code == 0
    assert "drone-cli run first_flight" in result.out


def test_version() -> None:
    assert run_cli("--version").out.startswith("drone-cli, version ")


@pytest.mark.parametrize("command", ["run", "check", "missions", "behaviors", "worlds", "new"])
def test_every_command_has_help(command: str) -> None:
    result = run_cli(command, "--help")
    assert result.code == 0
    assert result.out.startswith(f"Usage: drone-cli {command}")


def test_missions_are_listed_with_what_they_do() -> None:
    out = run_cli("missions").out
    for path in SHIPPED.glob("*.yaml"):
        assert path.stem in out
    names = [entry["mission"] for entry in json.loads(run_cli("missions", "--json").out)]
    assert names == sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def test_a_mission_tells_its_parameters() -> None:
    result = run_cli("missions", "first_flight")
    assert "altitude  a length (default: 2 m)" in result.out
    facts = json.loads(run_cli("missions", "first_flight", "--json").out)
    assert facts["parameters"]["side"]["default"] == 4.0


def test_a_copy_can_be_changed_and_is_run_by_name() -> None:
    result = run_cli("missions", "first_flight", "--copy")
    assert result.code == 0
    copied = Path("missions/first_flight.yaml")
    assert copied.read_bytes() == (SHIPPED / "first_flight.yaml").read_bytes()
    copied.write_text(copied.read_text().replace("Take off", "Mine, take off"))
    assert "Mine, take off" in run_cli("missions", "first_flight").out
    assert run_cli("missions", "first_flight", "--copy").code == 2


def test_a_list_survives_a_mission_with_a_mistake() -> None:
    Path("missions").mkdir()
    Path("missions/broken.yaml").write_text("states: [")
    result = run_cli("missions")
    assert result.code == 0
    assert "(has a mistake" in result.out


def test_fleets_are_listed_as_such() -> None:
    folder = Path("missions")
    folder.mkdir()
    (folder / "cat.yaml").write_bytes((SHIPPED / "first_flight.yaml").read_bytes())
    fleet = "fleet: chase\ndescription: Two of them.\nvehicles: {tom: {mission: cat.yaml}}\n"
    (folder / "chase.yaml").write_text(fleet)
    (folder / "torn.yaml").write_text(fleet.replace("cat", "dog"))
    rows = json.loads(run_cli("missions", "--json").out)
    assert {row["mission"] for row in rows if row["fleet"]} == {"chase", "torn", *FLEETS}
    assert [row for row in rows if row["mission"] in ("chase", "torn")] == [
        {"mission": "chase", "description": "Two of them.", "fleet": True},
        {
            "mission": "torn",
            "description": "(has a mistake: there is no file 'dog.yaml')",
            "fleet": True,
        },
    ]
    assert re.search(r"^chase +\(fleet\) Two of them\.$", run_cli("missions").out, re.MULTILINE)


def test_a_name_too_long_for_a_file_is_no_mission() -> None:
    assert [run_cli("check", "x" * 300 + end).code for end in ("", ".yaml")] == [2, 2]


def test_behaviors_are_listed_and_explained() -> None:
    out = run_cli("behaviors").out
    for name in Registry():
        assert name in out
        explained = run_cli("behaviors", name)
        assert explained.code == 0
        facts = json.loads(run_cli("behaviors", name, "--json").out)
        assert facts["help"]
        for parameter, about in facts["parameters"].items():
            assert parameter in explained.out
            assert about["type"]


def test_an_unknown_behaviour_gets_the_nearest() -> None:
    result = run_cli("behaviors", "gotoo")
    assert result.code == 2
    assert "did you mean 'goto'?" in result.err


def test_worlds_are_listed_and_shown() -> None:
    for name in world_names():
        assert name in run_cli("worlds").out
        assert run_cli("worlds", name).code == 0
    beacons = json.loads(run_cli("worlds", "beacons", "--json").out)
    assert [5.0, 0.0, 3.0] in beacons["places"].values()
    assert beacons["things"] == {"beacon": ["b1", "b2", "b3"]}
    assert run_cli("worlds", "yrad").code == 2


def test_a_world_is_shown_by_its_contents() -> None:
    out = run_cli("worlds", "forest:3").out
    assert "tree  tree_1, tree_2, tree_3" in out and "more" in out
    town = json.loads(run_cli("worlds", "road_town", "--json").out)
    assert town["things"]["road"] == ["main", "west", "branch"]
    assert "roads" in run_cli("worlds").out.partition("by number")[2]


OWN = """
from behaviors import Behavior, BehaviorParams, action, param

class Wiggle(Behavior):
    \"\"\"Shake the vehicle.\"\"\"
    class Params(BehaviorParams):
        width: float = param(0.3, unit="m", help="to each side")
    outcomes = {"done": None, "bored": None}
    def step(self, flight):
        return "done"

@action
def leds(color: str, n: int = 3):
    \"\"\"Show it.\"\"\"
"""


def test_behaviours_of_ones_own_are_listed_and_explained(write: Callable[[str, str], str]) -> None:
    write("mine.py", OWN)
    listed = run_cli("behaviors", "--uses", "mine.py").out.splitlines()
    assert listed[:2] == ["wiggle  Shake the vehicle.", "leds    Show it."]
    rows = json.loads(run_cli("behaviors", "--uses", "mine.py", "--json").out)
    assert [row.keys() for row in rows] == [{"behavior", "help"}, {"function", "help"}]
    explained = run_cli("behaviors", "wiggle", "--uses", "mine.py").out
    assert "  width  a length (default: 0.3 m)  to each side" in explained
    assert "\noutcomes:\n  done\n  bored\n  failed  event: reason\n" in explained
    facts = json.loads(run_cli("behaviors", "wiggle", "--uses", "mine.py", "--json").out)
    assert facts["parameters"]["width"]["default"] == 0.3
    explained = run_cli("behaviors", "leds", "--uses", "mine.py").out
    assert "  color  a text (required)\n  n      a whole number (default: 3)\n" in explained
    # Those installed are still there.
    assert run_cli("behaviors", "goto", "--uses", "mine.py") == run_cli("behaviors", "goto")


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("gone.py", None, "gone.py: error: there is no file 'gone.py' [no-such-file]"),
        ("none.py", "x = 1\n", "none.py: error: there is no behaviour in 'none.py' [no-behaviour]"),
        ("torn.py", "x = = 1\n", "torn.py:1:1: error: 'torn.py' cannot be loaded: SyntaxError"),
        ("mine.txt", OWN, "mine.txt: error: 'mine.txt' is no Python file [not-python]"),
    ],
)
def test_a_file_without_behaviours_is_told(
    name: str, text: str | None, told: str, write: Callable[[str, str], str]
) -> None:
    if text is not None:
        write(name, text)
    for arguments in ((), ("wiggle",)):
        result = run_cli("behaviors", *arguments, "--uses", name)
        assert (result.code, result.out) == (2, "")
        assert result.err.startswith(told)


def test_an_unknown_behaviour_of_ones_own_gets_the_nearest(
    write: Callable[[str, str], str],
) -> None:
    write("mine.py", OWN)
    result = run_cli("behaviors", "wigle", "--uses", "mine.py")
    assert (result.code, result.out) == (2, "")
    assert "did you mean 'wiggle'?" in result.err


@pytest.mark.parametrize(
    ("list_", "word", "text"),
    [("behaviors", "behavior", "help"), ("worlds", "world", "description")],
)
def test_the_lists_as_json_are_those_for_people(list_: str, word: str, text: str) -> None:
    rows = json.loads(run_cli(list_, "--json").out)
    assert rows and all(row.keys() == {word, text} and row[text] for row in rows)
    names = [row[word] for row in rows]
    assert len(set(names)) == len(names)
    table = run_cli(list_).out.partition("\n\n")[0]
    assert [line.split()[0] for line in table.splitlines()] == names
