"""`drone-cli run --post`: events that come from outside at given times."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.cli.run_cli import Result, run_cli

pytestmark = pytest.mark.usefixtures("undrawn")

MISSION = """\
mission: tag
events: {tag.seen: {id: number, at: point}, tag.gone: {}}
data: {n: 0, level: 0.0}
states:
  up: {do: takeoff, on: {done: wait}}
  wait:
    on:
      tag.seen:
        - {guard: event.id > 1, actions: [{set: {n: "${n + event.id}"}}], target: down}
        - {actions: [{set: {n: $event.id}}]}
      battery.low: {actions: [{set: {level: $event.level}}], target: down}
    after: {20 s: down}
  down: {do: land, on: {done: over}}
  over: {type: final, output: {n: $n, level: $level}}
"""


@pytest.fixture(autouse=True)
def mission() -> None:
    Path("tag.yaml").write_text(MISSION)


def fly(*posts: str) -> Result:
    given = [word for post in posts for word in ("--post", post)]
    return run_cli("run", "tag.yaml", "--json", "--no-picture", *given)


def events(summary: dict[str, Any]) -> list[dict[str, Any]]:
    lines = (Path(summary["run_folder"]) / "events.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines[1:]]


def test_an_event_comes_at_its_time_and_in_the_order_of_times() -> None:
    result = fly("4 s:tag.seen{id: 3, at: [1, 2]}", "3s : tag.seen {id: 1, at: home}")
    assert (result.code, result.err) == (0, "")
    summary = json.loads(result.out)
    assert summary["output"] == {"n": 4, "level": 0.0}
    heard = [entry for entry in events(summary) if entry.get("name") == "tag.seen"]
    assert [(entry["t"], entry["fields"]["id"]) for entry in heard] == [(3.0, 1), (4.0, 3)]
    assert heard[1]["fields"]["at"] == {"x": 1.0, "y": 2.0}


@pytest.mark.parametrize(("given", "level"), [("", None), ("{level: 12 %}", 0.12)])
def test_a_low_battery_has_the_level_of_the_vehicle_unless_given(
    given: str, level: float | None
) -> None:
    summary = json.loads(fly(f"3s:battery.low{given}").out)
    found = summary["output"]["level"]
    assert found == level if level else 0.98 < found < 1.0
    assert summary["entered"][-2] == {"t": 3.0, "state": "down", "why": "battery.low"}


def test_what_nobody_hears_is_a_warning_and_what_is_urgent_has_its_reaction() -> None:
    result = fly("3s:tag.gone", "5s:operator.abort")
    assert result.code == 1
    assert "warning: nobody here hears 'tag.gone' [unheard-event]" in result.err
    assert "tag.gone: warning" in result.err and "operator.abort: warning" not in result.err
    assert json.loads(result.out)["outcome"] == "aborted"


def test_an_event_declared_without_fields_may_have_any_as_where_it_is_sent() -> None:
    assert fly("3s:tag.gone{id: 3}", "5s:battery.low").code == 0


def test_an_event_after_the_end_is_told() -> None:
    result = fly("3s:battery.low", "2 min:tag.gone")
    assert result.code == 0
    assert result.err.splitlines()[-1] == "--post 120s:tag.gone: the flight was over before"


def test_posts_are_settings_and_are_repeated() -> None:
    summary = json.loads(fly("3s:tag.seen{id: 2, at: [1, 2, 3]}").out)
    (post,) = summary["settings"]["post"]
    assert post == {
        **{"t": 3.0, "event": "tag.seen"},
        "fields": {"id": 2, "at": {"$point": [1.0, 2.0, 3.0]}},
    }
    folder = summary["run_folder"]
    again = json.loads(run_cli("run", "--again", folder, "--runs-dir", "again", "--json").out)
    first, second = (
        (Path(each) / "events.jsonl").read_bytes() for each in (folder, again["run_folder"])
    )
    assert first == second


@pytest.mark.parametrize(
    ("post", "code", "told"),
    [
        ("6s:tag.sen", "unknown-event", "did you mean 'tag.seen'?"),
        ("6s:done", "unknown-event", "known: "),
        ("6s:tag.seen", "missing-key", "'id' is missing"),
        ("6s:tag.seen{id: 3, at: home, k: 3}", "unknown-key", "known: at, id"),
        ("6s:tag.seen{id: x, at: home}", "wrong-type", "'x' is not a number"),
        ("6s:tag.seen{id: 3, at: [1 s, 2]}", "wrong-dimension", "tag.seen"),
        ("6s:battery.low{level: 3 m}", "wrong-dimension", "battery.low"),
        ("6s:error.execution", "bad-event", "the engine's own"),
        ("6s:tag.seen{id: 3", "bad-event", "'tag.seen{id: 3}'"),
        ("6s:", "bad-event", "no event"),
        ("battery.low", "bad-post", "--post 6s:battery.low"),
        ("-3s:battery.low", "bad-post", "0 s or later"),
        ("3m:battery.low", "wrong-dimension", "a time is needed"),
        ("soon:battery.low", "wrong-type", "'soon' is not a time"),
    ],
)
def test_a_wrong_post_is_a_fault_before_the_flight(post: str, code: str, told: str) -> None:
    result = fly(post)
    assert result.code == 2
    assert f"--post {post}: error: " in result.err
    assert f"[{code}]" in result.err and told in result.err
    assert not Path("runs").exists()


def test_a_foreign_document_takes_any_event() -> None:
    Path("c.scxml").write_text(
        '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" initial="s">'
        '<state id="s"><transition event="go.now" target="f"/></state><final id="f"/></scxml>'
    )
    assert run_cli("run", "c.scxml", "--post", "1s:go.now{x: 3}").code == 0
