"""Logs are the same bytes whether cameras are read or not; by whichever renderer, but for the
settings in their first line.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from behaviors import Pilot
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal.engines import is_installed
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder


class _Reader:
    """Reads every fifth period's frames."""

    def __init__(self) -> None:
        self.frames = 0
        self._periods = 0

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        self._periods += 1
        if self._periods % 40 == 0:
            for name in ("front", "ventral"):
                pilot.vehicle.use_camera(name)
                self.frames += pilot.channel.camera(name).latest() is not None


def log(folder: Path, read: bool, **settings: object) -> bytes:
    prepared = prepare(missions.find("first_flight"), "marker_yard")
    values = parse_parameters(prepared.graph, {})
    plan = Plan.alone(prepared, values, settings={"noise": 1.0, **settings})
    reader = _Reader()
    folder.mkdir()
    flown = fly(plan, lambda: Recorder(folder), [reader] if read else [])
    assert flown.alone.outcome == "done" and (reader.frames > 20) == read
    return (folder / "events.jsonl").read_bytes()


def test_the_log_does_not_tell_whether_anybody_looked(tmp_path: Path) -> None:
    alone = log(tmp_path / "alone", read=False)
    assert log(tmp_path / "raster", read=True) == alone
    settings, events = alone.split(b"\n", 1)
    if is_installed("bullet"):
        tiny = log(tmp_path / "tiny", read=True, renderer="tiny").split(b"\n", 1)
        assert tiny == [settings.replace(b'"renderer":"raster"', b'"renderer":"tiny"'), events]
    noisy = {"front": {"noise": 3.0, "distortion": (-0.2, 0.05, 0.0, 0.0, 0.0), "rate": 30.0}}
    assert log(tmp_path / "noisy", read=True, cameras=noisy).split(b"\n", 1)[1] == events
