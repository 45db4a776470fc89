"""Signals and the notes, each by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from cli.narrator import clock, note
from cli.signals import Interrupts
from tests.cli.run_cli import run_cli
from vencejo.errors import Stopped


def test_interrupts_count_and_the_third_stops_the_program() -> None:
    stops = Interrupts()
    stops.request()
    assert stops.count == 1
    stops.request()
    assert stops.count == 2
    with pytest.raises(Stopped):
        stops.request()


def test_sigterm_counts_as_two() -> None:
    stops = Interrupts()
    stops.request(2)
    assert stops.count == 2


def test_the_clock_reads_minutes_and_seconds() -> None:
    assert clock(83.42) == "1:23.4"


@pytest.mark.parametrize(
    ("kind", "fields", "text"),
    [
        ("log", {"text": "hello"}, "hello"),
        ("enter", {"state": "a"}, None),
        ("event", {"name": "done", "state": "up", "taken": True}, None),
        ("event", {"name": "failed", "state": "up", "taken": False}, "up failed"),
        (
            "event",
            {"name": "failed", "state": "up", "fields": {"reason": "too heavy"}, "taken": False},
            "up failed: too heavy",
        ),
        # What a state handles is told with the state that it leads to.
        (
            "event",
            {"name": "failed", "state": "up", "fields": {"reason": "too heavy"}, "taken": True},
            None,
        ),
        (
            "error",
            {"message": "x: no value", "where": "m.yaml:3:9"},
            "error: x: no value (m.yaml:3:9)",
        ),
        ("reaction", {"event": "link.lost", "does": "land"}, "nobody handles link.lost: landing"),
        (
            "reaction",
            {"event": "operator.takeover", "does": "suspend"},
            "nobody handles operator.takeover: the mission stands still",
        ),
        ("landing", {"by": "host"}, "landing past the mission"),
        (
            "refused",
            {"setpoint": "Velocity", "reason": "on the ground"},
            "the vehicle refuses a set-point (on the ground)",
        ),
        ("authority", {"authority": "mission", "reason": None}, "commanded by: mission"),
        (
            "authority",
            {"authority": "autopilot", "reason": "failsafe"},
            "commanded by: autopilot (failsafe)",
        ),
        ("link", {"link": "lost", "age": 3.0}, "the link is lost"),
    ],
)
def test_notes_are_for_people(kind: str, fields: dict[str, object], text: str | None) -> None:
    assert note(kind, fields) == text


def test_a_run_has_a_picture(hop: str) -> None:
    assert run_cli("run", hop).code == 0
    (folder,) = Path("runs").iterdir()
    assert (folder / "flight.png").read_bytes().startswith(b"\x89PNG")


def test_a_killed_run_can_be_drawn(hop: str, undrawn: None) -> None:
    run_cli("run", hop)
    (folder,) = Path("runs").iterdir()
    (folder / "summary.json").unlink()
    telemetry = folder / "telemetry.csv"
    text = telemetry.read_text()
    telemetry.write_text(text[: len(text) * 2 // 3])
    result = run_cli("picture", str(folder))
    assert result.code == 0, result.err
    assert (folder / "flight.png").exists()
