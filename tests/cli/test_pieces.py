"""Signals, the map and the notes, each by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from cli.signals import Interrupts
from cli.sketch import Sketch
from cli.view import clock, note
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


def test_the_sketch_draws_a_square_with_marks() -> None:
    sketch = Sketch(columns=20, rows=10)
    for place in ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)):
        sketch.add(place)
    lines = sketch.draw({"H": [(0.0, 0.0)], "X": [(4.0, 4.0)]})
    assert [len(line) for line in lines] == [20] * 10
    home = next((row, line.index("H")) for row, line in enumerate(lines) if "H" in line)
    far = next((row, line.index("X")) for row, line in enumerate(lines) if "X" in line)
    assert home[0] > far[0], "north is up"
    assert home[1] < far[1], "east is right"


def test_the_sketch_grows_with_the_path() -> None:
    sketch = Sketch(columns=20, rows=10)
    sketch.add((0.0, 0.0))
    sketch.add((1000.0, -500.0))
    lines = sketch.draw({"X": [(1000.0, -500.0)]})
    assert "X" in "".join(lines)


def test_the_clock_reads_minutes_and_seconds() -> None:
    assert clock(83.42) == "1:23.4"


def test_notes_are_for_people() -> None:
    assert note("log", {"text": "hello"}) == "hello"
    assert note("enter", {"state": "a"}) is None
    failed = {"name": "failed", "state": "up", "fields": {"reason": "too heavy"}}
    assert note("event", failed) == "up failed: too heavy"


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
