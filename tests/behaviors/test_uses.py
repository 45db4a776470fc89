"""Behaviours in Python files beside a mission."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from behaviors import Registry, load_all
from tests.behaviors.flying import Rig
from vencejo.errors import Fault, UserError, Where
from vencejo.nodes import Scalar

CLIMB = """
from behaviors import Behavior, BehaviorParams, param
from hal import Velocity

class _Helper(Behavior):
    pass

class ClimbTo(Behavior):
    '''Climb to a height.'''
    class Params(BehaviorParams):
        height: float = param(unit="m")

    def step(self, flight):
        flight.command(Velocity(z=1.0))
        return "done" if flight.observation.position.z >= self.params.height else None

Again = ClimbTo
"""


def named(folder: Path, *names: str) -> list[tuple[Scalar, Path]]:
    return [(Scalar(name, Where("m.yaml", 3, 8 + i)), folder) for i, name in enumerate(names)]


def refusal(folder: Path, *names: str) -> Fault:
    with pytest.raises(UserError) as raised:
        load_all(named(folder, *names))
    (fault,) = raised.value.faults
    assert fault.where and str(folder) not in str(raised.value)
    return fault


def test_a_file_that_is_named_twice_runs_once(tmp_path: Path) -> None:
    counts = "from pathlib import Path\nwith open(Path(__file__).parent / 'runs', 'a') as file:\n"
    (tmp_path / "climb.py").write_text(CLIMB + counts + "    file.write('x')\n")
    own = load_all(named(tmp_path, "climb.py", "./climb.py", "climb.py"))
    assert list(own) == ["climb_to"]
    assert (tmp_path / "runs").read_text() == "x"


def test_an_own_behaviour_flies(tmp_path: Path) -> None:
    (tmp_path / "climb.py").write_text(CLIMB)
    own = load_all(named(tmp_path, "climb.py"))
    assert list(own) == ["climb_to"]
    rig = Rig(
        """
mission: own
states:
  takeoff: {do: takeoff, on: {done: climb}}
  climb: {do: climb_to, with: {height: 5 m}, on: {done: land}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
""",
        own=own,
    )
    rig.until_in("land")
    assert rig.vehicle.position.z == pytest.approx(5.0, abs=0.1)
    rig.run(30)
    assert rig.pilot.outcome == "done"


def test_files_of_a_folder_beside_it_may_be_named(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "climb.py").write_text(CLIMB)
    assert "climb_to" in load_all(named(tmp_path, "mine/climb.py"))


@pytest.mark.parametrize("name", ["../other.py", "/etc/hostname.py"])
def test_nothing_outside_the_folder_is_run(tmp_path: Path, name: str) -> None:
    (tmp_path / "other.py").write_text("raise RuntimeError('was run')")
    folder = tmp_path / "missions"
    folder.mkdir()
    fault = refusal(folder, name)
    assert (fault.code, fault.where) == ("outside-folder", Where("m.yaml", 3, 8))
    assert fault.hint


def test_a_link_out_of_the_folder_is_outside(tmp_path: Path) -> None:
    folder = tmp_path / "missions"
    folder.mkdir()
    (tmp_path / "other.py").write_text(CLIMB)
    (folder / "linked.py").symlink_to(tmp_path / "other.py")
    assert refusal(folder, "linked.py").code == "outside-folder"


def test_a_missing_file(tmp_path: Path) -> None:
    fault = refusal(tmp_path, "climb.py")
    assert (fault.code, fault.where) == ("no-such-file", Where("m.yaml", 3, 8))
    assert fault.hint == "no Python file lies beside the mission"
    (tmp_path / "climbs.py").write_text(CLIMB)
    assert refusal(tmp_path, "climb.py").hint == "did you mean 'climbs.py'?"


@pytest.mark.parametrize(
    ("text", "line", "told"),
    [
        ("import sys\n\nvalue = {}['key']\n", 3, "KeyError: 'key'"),
        ("x = 1\ndef step(:\n", 2, "SyntaxError"),
        ("import no_such_module_here\n", 1, "ModuleNotFoundError"),
        ("def f():\n    raise SystemExit(3)\n\nf()\n", 2, "SystemExit"),
        ("\nraise KeyboardInterrupt\n", 2, "KeyboardInterrupt"),
        ("class E(Exception):\n    def __str__(self): raise self\n\nraise E\n", 4, ": E"),
        ("eval('1 +')\n", 1, "SyntaxError"),
        ("import sys\n\nsys.setrecursionlimit('x')\n", 3, "TypeError"),
        (CLIMB.replace('unit="m"', 'unit="furlong"'), 10, "there is no unit 'furlong'"),
        (CLIMB + "\nClimbTo.publishes = list[int]\nClimbTo.events = 3\n", 1, "AttributeError"),
    ],
)
def test_broken_code_is_told_with_its_own_line(
    tmp_path: Path, text: str, line: int, told: str
) -> None:
    (tmp_path / "broken.py").write_text(text)
    fault = refusal(tmp_path, "broken.py")
    assert fault.code == "broken-code"
    assert fault.where == Where("broken.py", line, 1)
    assert told in fault.message
    assert fault.hint == "named under `uses` at m.yaml:3:8"


@pytest.mark.parametrize(
    ("methods", "line", "told"),
    [
        ("pass", 3, "'Own' has no `step`"),
        ("def step(self): ...", 4, "`step` of 'Own' does not take the argument `flight`"),
        ("step = 3", 3, "`step` of 'Own' is no method"),
        (
            "def step(self, flight): ...\n    def start(self, flight): ...",
            5,
            "`start` of 'Own' does not take the argument `progress`",
        ),
        (
            "def step(self, flight): ...\n    def start(self, flight, progress, more): ...",
            5,
            "`start` of 'Own' cannot be called with self, flight, progress: missing a required "
            "argument: 'more'",
        ),
        (
            "def step(self, flight): ...\n    def stop(self): ...",
            5,
            "`stop` of 'Own' does not take the argument `flight`",
        ),
        (
            "def step(self, flight): ...\n    def progress(self, flight): ...",
            5,
            "`progress` of 'Own' cannot be called with self: missing a required argument: 'flight'",
        ),
        (
            "def step(self, flight): ...\n    def __init__(self): ...",
            5,
            "`__init__` of 'Own' does not take the argument `params`",
        ),
        ("def step(self, flight): yield", 4, "`step` of 'Own' has a `yield` in it"),
        ("async def step(self, flight): ...", 4, "`step` of 'Own' is `async`"),
        ("async def step(self, flight): yield", 4, "`step` of 'Own' has a `yield` in it"),
        (
            "def step(self, flight): ...\n    controls = 'motion'",
            3,
            "`controls` of 'Own' is 'motion', not some words",
        ),
        (
            "def step(self, flight): ...\n    requires = (3,)",
            3,
            "`requires` of 'Own' is (3,), not some words",
        ),
    ],
)
def test_a_class_that_its_calls_cannot_reach(
    tmp_path: Path, methods: str, line: int, told: str
) -> None:
    (tmp_path / "own.py").write_text(
        f"from behaviors import Behavior\n\nclass Own(Behavior):\n    {methods}\n"
    )
    fault = refusal(tmp_path, "own.py")
    assert (fault.code, fault.where) == ("bad-behaviour", Where("own.py", line, 1))
    assert fault.message.startswith(told)
    assert fault.hint and fault.hint.startswith("write `")


def test_all_classes_of_a_file_are_looked_at(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(
        "from behaviors import Behavior\nclass A(Behavior): ...\nclass B(Behavior): ...\n"
    )
    with pytest.raises(UserError) as raised:
        load_all(named(tmp_path, "own.py"))
    assert [fault.where for fault in raised.value.faults] == [
        Where("own.py", 2, 1),
        Where("own.py", 3, 1),
    ]


def test_arguments_may_have_other_names_and_defaults(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(
        "from behaviors import Behavior\n\nclass Own(Behavior):\n"
        "    def __init__(self, *all): super().__init__(*all)\n"
        "    def start(self, f, where=None, *more): ...\n"
        "    step = lambda self, f: None\n"
        "    def stop(self, *all, **named): ...\n"
    )
    assert list(load_all(named(tmp_path, "own.py"))) == ["own"]


@pytest.mark.parametrize("head", ["async def leds():\n    pass", "def leds():\n    yield"])
def test_an_action_whose_call_does_nothing(tmp_path: Path, head: str) -> None:
    (tmp_path / "leds.py").write_text(f"from behaviors import action\n\n@action\n{head}\n")
    fault = refusal(tmp_path, "leds.py")
    assert fault.code == "broken-code"
    assert "an action is neither `async` nor has it a `yield`" in fault.message


def test_an_installed_behaviour_that_cannot_be_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "torn_plugin.py").write_text("\nimport sys\nsys.exit('no')\n")
    monkeypatch.syspath_prepend(tmp_path)
    point = EntryPoint("torn", "torn_plugin:Torn", "vencejo.behaviors")
    monkeypatch.setattr("behaviors.registry.plugins", lambda group: {"torn": point})
    with pytest.raises(UserError) as raised:
        Registry()["torn"]
    (fault,) = raised.value.faults
    assert (fault.code, fault.where) == ("broken-code", Where("torn_plugin.py", 3))
    assert fault.message == "the installed behaviour 'torn' cannot be loaded: SystemExit: no"
    assert fault.hint == "it is torn_plugin:Torn of no package"


def test_what_has_no_behaviour(tmp_path: Path) -> None:
    (tmp_path / "none.py").write_text("from behaviors import Behavior\n")
    fault = refusal(tmp_path, "none.py")
    assert (fault.code, fault.where) == ("no-behaviour", Where("m.yaml", 3, 8))
    assert fault.hint and "class" in fault.hint
    (tmp_path / "notes.txt").write_text("hello")
    fault = refusal(tmp_path, "notes.txt")
    assert (fault.code, fault.hint) == ("not-python", "its name ends in .py")


def test_names_are_taken_once(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(CLIMB)
    (tmp_path / "b.py").write_text(CLIMB)
    fault = refusal(tmp_path, "a.py", "b.py")
    assert (fault.code, fault.where) == ("name-taken", Where("m.yaml", 3, 9))
    assert fault.message == "'b.py' has a behaviour 'climb_to', but there is one already"
    assert fault.hint == "give the class another name, or set its `name`"
    (tmp_path / "c.py").write_text(
        CLIMB.replace("class ClimbTo", "class Land").replace("ClimbTo", "Land")
    )
    assert refusal(tmp_path, "c.py").code == "name-taken"
    (tmp_path / "d.py").write_text(
        "from behaviors import action\n\n@action\ndef limits() -> None:\n    'Taken.'\n"
    )
    fault = refusal(tmp_path, "d.py")
    assert fault.message == "'d.py' has a function 'limits', but there is one already"
    assert fault.hint == "give the function another name"


LEDS = """
from behaviors import action

said = []

@action
def leds(color: str, rate: float = 1.0) -> None:
    if color == "grey":
        raise OSError("no such light")
    said.append((color, rate))

def helper(): ...
"""
CALLS = """
states:
  a: {entry: {call: {leds: {color: %s}}}, on: {error.execution: c}, after: {50 ms: b}}
  b: {type: final}
  c: {type: final, outcome: broken}
"""


@pytest.mark.parametrize(
    ("color", "outcome", "said"), [("red", "done", [("red", 1.0)]), ("grey", "broken", [])]
)
def test_an_action_is_called(
    tmp_path: Path, color: str, outcome: str, said: list[tuple[str, float]]
) -> None:
    (tmp_path / "leds.py").write_text(LEDS)
    own = load_all(named(tmp_path, "leds.py"))
    assert list(own) == ["leds"]
    rig = Rig(CALLS % color, own=own)
    rig.run(1)
    implementation = own["leds"].implementation
    assert (rig.pilot.outcome, implementation.__globals__["said"]) == (outcome, said)


@pytest.mark.parametrize(
    ("call", "code", "hint"),
    [
        ("led", "unknown-function", "did you mean 'leds'?"),
        ("leds", "missing-key", None),
        ("{leds: {colour: red}}", "unknown-key", "did you mean 'color'?"),
        ("{leds: {color: red, rate: fast}}", "wrong-type", None),
        (
            "helper",
            "unknown-function",
            "known: camera, leds, lights, limits, save_picture, swap_battery",
        ),
    ],
)
def test_a_call_is_checked(tmp_path: Path, call: str, code: str, hint: str | None) -> None:
    (tmp_path / "leds.py").write_text(LEDS)
    own = load_all(named(tmp_path, "leds.py"))
    with pytest.raises(UserError) as raised:
        Rig(CALLS.replace("{leds: {color: %s}}", call), own=own)
    (fault,) = raised.value.faults
    assert (fault.code, fault.hint) == (code, hint)
