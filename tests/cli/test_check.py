from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from fsm import read_mission
from fsm.scxml import write_scxml
from tests.cli.run_cli import run_cli

Write = Callable[[str, str], str]

START = "states:\n  up: {do: takeoff, on: {done: down}}\n"
END = "  down: {do: land, on: {done: over}}\n  over: {type: final}\n"

# Name → (text, place of the fault, what the message or its hint says).
FAULTS: dict[str, tuple[str, str, str]] = {
    "empty": ("", ":1:1", "the file is empty"),
    "not YAML": ("states: [a", ":2:1", "no YAML"),
    "a list": ("- a\n", ":1:1", "must be a map"),
    "tab": ("states:\n\tup: {}\n", ":2:1", "indent with spaces"),
    "unknown key": (START + END + "statse: {}\n", ":5:1", "did you mean 'states'?"),
    "duplicate key": (START + END + "  up: {}\n", ":5:3", "stands twice"),
    "custom tag": ("mission: !x a\n" + START + END, ":1:10", "the tag '!x'"),
    "unknown behaviour": (
        "states:\n  up: {do: takeof, on: {done: down}}\n" + END,
        ":2:12",
        "did you mean 'takeoff'?",
    ),
    "missing parameter": (
        "states:\n  up: {do: goto, on: {done: down, blocked: down}}\n" + END,
        ":2:12",
        "needs the parameter 'to'",
    ),
    "wrong type": (
        "states:\n  up: {do: takeoff, with: {altitude: high}, on: {done: down}}\n" + END,
        ":2:38",
        "write a length like 2 m",
    ),
    "bad unit": (
        "states:\n  up: {do: takeoff, with: {altitude: 2 metres}, on: {done: down}}\n" + END,
        ":2:38",
        "'metres' is no unit",
    ),
    "wrong dimension": (
        "states:\n  up: {do: takeoff, with: {altitude: 2 s}, on: {done: down}}\n" + END,
        ":2:38",
        "is a time, but a length is needed",
    ),
    "default outside its bounds": (
        "parameters: {a: {default: 9 m, max: 5 m}}\n" + START + END,
        ":1:27",
        "outside its own bounds",
    ),
    "out of range": (
        "states:\n  up: {do: takeoff, with: {altitude: 500 m}, on: {done: down}}\n" + END,
        ":2:38",
        "allowed is 0.3 m … 120 m",
    ),
    "unknown target": (
        "states:\n  up: {do: takeoff, on: {done: dwon}}\n" + END,
        ":2:32",
        "did you mean 'down'?",
    ),
    "unhandled outcome": (
        "states:\n  up: {do: takeoff, after: {9 s: down}}\n" + END,
        ":2:3",
        "on: {done: …}",
    ),
    "no way out": (START + END + "  lost: {}\n", ":5:3", "nothing ever leaves 'lost'"),
    "bad expression": (
        START + "  down: {do: land, on: {done: over}, when: {1 +: over}}\n  over: {type: final}\n",
        ":3:48",
        "no expression",
    ),
    "unknown name": (
        START + "  down: {do: land, on: {done: over}, when: {batery > 3: over}}\n"
        "  over: {type: final}\n",
        ":3:45",
        "'batery' is unknown",
    ),
    "unknown function": (
        START + "  down: {do: land, on: {done: over}, when: {abss(1) > 3: over}}\n"
        "  over: {type: final}\n",
        ":3:45",
        "did you mean 'abs'?",
    ),
    "unquoted expression": (
        "states:\n  up: {do: takeoff, with: {altitude: ${1 + 1}}, on: {done: down}}\n" + END,
        ":2:",
        "needs quotes",
    ),
    "unknown world": ("world: yrad\n" + START + END, ":1:8", "did you mean 'yard'?"),
    "missing uses file": ("uses: [mine.py]\n" + START + END, ":1:8", "no file 'mine.py'"),
}


@pytest.mark.parametrize("case", FAULTS)
@pytest.mark.parametrize("command", ["check", "run"])
def test_a_fault_has_its_place_and_a_way_out(case: str, command: str, write: Write) -> None:
    text, place, expected = FAULTS[case]
    write("m.yaml", text)
    result = run_cli(command, "m.yaml")
    assert result.code == 2, result.out
    assert f"m.yaml{place}" in result.err
    assert expected in result.err
    assert "Traceback" not in result.err
    assert result.err.count(" error: ") == 1, result.err
    assert not Path("runs").exists()


def test_all_faults_are_reported_at_once(write: Write) -> None:
    write(
        "m.yaml",
        "states:\n  up: {do: takeof, on: {done: dwon}}\n  down: {do: land, on: {done: over}}\n"
        "  over: {type: final}\n  hang: {}\n",
    )
    result = run_cli("check", "m.yaml")
    assert result.code == 2
    assert "'takeof'" in result.err
    assert "'dwon'" in result.err


def test_good_missions_may_fly(hop: str) -> None:
    result = run_cli("check", hop, "first_flight")
    assert result.code == 0
    assert result.out.splitlines()[0] == "hop.yaml: may fly, 3 states"
    assert result.err == ""


def test_strict_counts_warnings(write: Write) -> None:
    write("m.yaml", START + END + "  spare: {after: {1 s: over}}\n")
    assert run_cli("check", "m.yaml").code == 0
    result = run_cli("check", "m.yaml", "--strict")
    assert result.code == 2
    assert "nothing leads to the state 'spare'" in result.err


def test_json_reports_every_mission(hop: str, write: Write) -> None:
    write("bad.yaml", "states: {}\n")
    result = run_cli("check", hop, "bad.yaml", "--json")
    good, bad = json.loads(result.out)
    assert result.code == 2
    counts = {"errors": 0, "warnings": 0, "faults": []}
    looked_at = {"unknown": [], "moving": [], "complete": True}
    assert good == {"mission": "hop.yaml", "states": 3, **looked_at, **counts}
    assert bad["faults"][0]["code"] == "no-states"
    assert bad["faults"][0]["where"].startswith("bad.yaml:1:")


def test_a_file_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_bytes(b"mission: \xff\xfe")
    result = run_cli("check", "m.yaml")
    assert result.code == 2
    assert "no UTF-8 text" in result.err


SCXML = """<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
<state id="a"><transition event="t" target="b"/></state><final id="b"/></scxml>"""


def test_scxml_is_checked_too(tmp_path: Path) -> None:
    path = tmp_path / "doc.scxml"
    path.write_text(SCXML)
    good = run_cli("check", str(path))
    assert (good.code, good.out) == (0, f"{path}: may fly, 2 states\n")
    path.write_text(SCXML.replace('target="b"', 'target="c"'))
    wrong = run_cli("check", str(path))
    assert wrong.code == 2
    assert f"{path}:2:45: error: there is no state 'c' [unknown-target]" in wrong.err


def test_what_fails_at_run_time_in_a_document_is_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "doc.scxml"
    path.write_text(
        '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0"><state id="a">\n'
        '<transition event="t" cond="n +" target="a"/>'
        '<transition event="u" cond="n" target="a"/></state></scxml>'
    )
    result = run_cli("check", str(path))
    assert (result.code, result.out) == (0, f"{path}: may fly, 1 state, 2 warnings\n")
    hint = "  hint: it raises error.execution at run time\n"
    assert result.err == (
        f"{path}:2:32: warning: nothing follows [bad-expression]\n{hint}"
        f"{path}:2:74: warning: there is no variable 'n' [unknown-name]\n{hint}"
    )
    assert run_cli("check", "--strict", str(path)).code == 2


def test_a_mission_that_went_out_as_scxml_is_checked_as_one(hop: str, tmp_path: Path) -> None:
    path = tmp_path / "hop.scxml"
    path.write_text(write_scxml(read_mission(Path(hop))))
    good = run_cli("check", str(path))
    assert good.code == 0
    path.write_text(path.read_text().replace("<v:do>takeoff", "<v:do>takeof"))
    wrong = run_cli("check", str(path))
    assert wrong.code == 2
    assert "did you mean 'takeoff'?" in wrong.err


MIXED = """\
statess: {spare: {}}
states:
  up: {do: takeoff, onn: {done: down, link.lost: hang}, after: {1 ms: down}}
  down: {do: land, with: {timeout: 2 m}, on: {done: ovr}}
  hang: {do: hover, when: {vehicle.battery < 20 %: down}}
"""


def test_faults_of_form_and_of_meaning_are_reported_together_errors_first(write: Write) -> None:
    write("m.yaml", MIXED)
    result = run_cli("check", "m.yaml")
    places = [line.split(": ")[0] for line in result.err.splitlines() if line.startswith("m.yaml:")]
    assert result.code == 2
    assert places == [
        "m.yaml:1:1", "m.yaml:3:21", "m.yaml:4:36", "m.yaml:4:53", "m.yaml:3:65", "m.yaml",
    ]  # fmt: skip
    assert result.err.splitlines()[-1] == "m.yaml: 4 errors, 1 warning"


def test_what_only_may_follow_from_a_mistake_is_not_told_but_all_else_is(write: Write) -> None:
    text = (
        "states:\n  up: {do: takeof, with: {altitude: $hight}, on: {done: down, oops: down}}\n"
        "  down: {do: land}\n  lost: {do: hover, on: {link.lsot: down}}\n"
    )
    write("m.yaml", text)
    result = run_cli("check", "m.yaml", "--json")
    found = [(f["where"], f["code"]) for f in json.loads(result.out)[0]["faults"]]
    # `up` may end with `oops`; whether `lost` is left, or reached, its mistake leaves open.
    assert found == [
        ("m.yaml:2:12", "unknown-behaviour"),
        ("m.yaml:2:38", "unknown-name"),
        ("m.yaml:3:3", "unhandled-outcome"),
        ("m.yaml:3:3", "no-way-out"),
        ("m.yaml:4:26", "unknown-event"),
    ]


def test_a_world_that_is_not_there_hides_nothing(write: Write) -> None:
    write("m.yaml", "world: yrad\nuses: [mine.py]\n" + START.replace("down", "dwon") + END)
    result = run_cli("check", "m.yaml", "--json")
    codes = [fault["code"] for fault in json.loads(result.out)[0]["faults"]]
    assert codes == ["unknown-world", "no-such-file", "unknown-target"]


UNSAFE = (
    "states:\n  up: {do: takeoff, on: {done: down, link.lost: hang}}\n"
    "  hang: {do: hover, when: {vehicle.battery < 20 %: down}}\n" + END
)


def test_a_mission_that_may_stay_in_the_air_is_warned_of(write: Write) -> None:
    write("m.yaml", UNSAFE)
    result = run_cli("check", "m.yaml")
    assert result.code == 0
    assert "m.yaml:2:49: warning: 'link.lost' may leave the vehicle in the air" in result.err
    assert "up, then 'link.lost' → hang, where it stays [never-lands]" in result.err
    assert result.out == "m.yaml: may fly, 4 states, 1 warning\n"
    assert run_cli("check", "m.yaml", "--strict").code == 2


def test_annotations_for_github(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    write("a,b.yaml", START.replace("down}", "dwon}") + END)
    assert "::error" not in run_cli("check", "a,b.yaml").out
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    assert run_cli("check", "a,b.yaml").out == (
        "::error file=a%2Cb.yaml,title=unknown-target,line=2,col=32::"
        "there is no state 'dwon' to go to%0Ahint: did you mean 'down'?\n"
    )
    write("m.yaml", UNSAFE)
    assert run_cli("check", "m.yaml").out.startswith("::warning file=m.yaml,title=never-lands,")


def test_what_a_backend_offers_is_compared_without_opening_it(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("m.yaml", START + END)
    assert run_cli("check", "m.yaml", "--backend", "sim").code == 0
    monkeypatch.setattr("hal.sim.MODELS", None)
    monkeypatch.setattr("hal.sim.CAPABILITIES", frozenset({"takeoff", "position"}), raising=False)
    result = run_cli("check", "m.yaml", "--backend", "sim")
    assert result.code == 2
    assert "m.yaml:3:3: error: 'land' needs 'land', which the backend 'sim' does not offer" in (
        result.err
    )
    assert "it offers: position, takeoff" in result.err
    result = run_cli("check", "m.yaml", "--backend", "simm")
    assert (result.code, "did you mean 'sim'?" in result.err) == (2, True)


CODE = """
from pathlib import Path
from behaviors import Behavior

Path("was_run").touch()

class FlyCircle(Behavior):
    outcomes = {"done": None, "dizzy": None}

class Other(Behavior):
    name = "spin"
"""
TRUSTING = (
    "uses: [mine.py]\nstates:\n"
    "  up: {do: fly_circle, with: {turns: 2}, on: {done: on, dizzy: down, circle.turned: down},"
    " when: {fly_circle.angle > 3: down}}\n  on: {do: spin, on: {done: down}}\n" + END
)


def test_without_code_own_behaviours_are_taken_on_trust(write: Write) -> None:
    write("mine.py", CODE)
    write("m.yaml", TRUSTING)
    result = run_cli("check", "m.yaml", "--no-code")
    verdict, unknown = result.out.splitlines()
    assert (result.code, verdict) == (0, "m.yaml: may fly, 4 states, 1 warning"), result.err
    assert unknown.startswith("  known in flight only: where '")
    assert "[not-proven]" in result.err
    assert not Path("was_run").exists()
    write("m.yaml", TRUSTING.replace("do: spin", "do: spinn"))
    assert "did you mean 'spin'?" in run_cli("check", "m.yaml", "--no-code").err
    write("mine.py", "class (")
    assert run_cli("check", "m.yaml", "--no-code").code == 2
    assert not Path("was_run").exists()
    write("mine.py", CODE)
    assert run_cli("check", "m.yaml").code == 2
    assert Path("was_run").exists()


def test_the_schema_is_printed_as_json() -> None:
    printed = json.loads(run_cli("schema").out)
    assert printed["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert "states" in printed["else"]["properties"]
    assert "boxes" in json.loads(run_cli("schema", "--worlds").out)["properties"]
