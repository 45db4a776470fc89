"""The run folder: what a flight leaves behind. Written in flight by appending only.

``events.jsonl`` holds one JSON object a line and nothing of this machine or this moment, so that
equal runs give equal bytes; ``docs/runs.md`` describes it and ``telemetry.csv``.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import asdict, is_dataclass
from hashlib import sha256
from pathlib import Path
from typing import IO, Any

from behaviors import Pilot
from fsm.machine import Record
from hal.vehicle import Observation
from vencejo.errors import UserError, Where
from vencejo.geometry import roll_pitch_of
from worlds import World

FORMAT = "vencejo.events"
FORMAT_VERSION = 1
TELEMETRY_COLUMNS = "t,vehicle,x,y,z,vx,vy,vz,roll,pitch,yaw,battery,mode,state"
_ROW = "%.3f,%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.5f,%.5f,%.5f,%.5f,%s,%s\n"
_ROWS_AT_ONCE = 40
"""Rows of telemetry written together: what a killed run may lose is one second."""


def as_json(value: Any) -> Any:
    """What json cannot write by itself: points as lists, records as maps."""
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    return str(value)


_encode = json.JSONEncoder(
    ensure_ascii=False, allow_nan=False, separators=(",", ":"), default=as_json
).encode


def new_folder(parent: Path, stamp: str, mission: str) -> Path:
    """Make ``<parent>/<stamp>-<mission>[-n]``, a name nobody has. Raises UserError."""
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in range(1, 10_000):
            folder = parent / (f"{stamp}-{mission}" + (f"-{number}" if number > 1 else ""))
            try:
                folder.mkdir()
            except FileExistsError:
                continue
            return folder
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(
            "no-run-folder", f"cannot make a run folder: {reason}", Where(str(parent)), "--runs-dir"
        ) from None
    raise UserError("no-run-folder", "too many runs of one second", Where(str(parent)))


class Recorder:
    """Appends what happens to the files of one run folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._sequence = 0
        self._rows: list[tuple[Observation, str, str]] = []
        self._state = ""
        self._events: IO[str] = (folder / "events.jsonl").open("w", encoding="utf-8", newline="\n")
        self._telemetry: IO[str] = (folder / "telemetry.csv").open(
            "w", encoding="utf-8", newline="\n"
        )
        self._telemetry.write(TELEMETRY_COLUMNS + "\n")

    def keep(self, files: Iterable[Path], base: Path) -> None:
        """Copy what a person wrote, as flown; what lies in ``base`` keeps its place below it."""
        for path in files:
            inside = path.is_relative_to(base)
            copy = self.folder / (path.relative_to(base) if inside else path.name)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)

    def keep_world(self, world: World) -> None:
        """Copy a world and the files it names; a generated one is written down."""
        self.keep(world.files, world.source.parent)
        if not world.files:
            (self.folder / f"{world.name}.yaml").write_text(world.text, "utf-8")

    def header(self, facts: Mapping[str, Any]) -> None:
        """The first line: what makes this run what it is."""
        first = {"format": FORMAT, "version": FORMAT_VERSION, **facts}
        self._events.write(_encode(first) + "\n")
        self._events.flush()

    def take(self, pilot: Pilot) -> list[Record]:
        """Write one period of a pilot: its records, now empty, and a row of telemetry."""
        records = pilot.instance.records
        seen = pilot.flight.world
        vehicle = pilot.vehicle.name
        if records:
            pilot.instance.records = []
            for kind, fields in records:
                line = {"seq": self._sequence, "t": seen.time, "vehicle": vehicle, "kind": kind}
                self._events.write(_encode({**line, **fields}) + "\n")
                self._sequence += 1
            self._events.flush()
            self._state = "|".join(pilot.instance.paths())
        # Formatted many at a time: one by one they would take twice as long.
        self._rows.append((seen, vehicle, self._state))
        if len(self._rows) == _ROWS_AT_ONCE:
            self._write_rows()
        return records

    def _write_rows(self) -> None:
        self._telemetry.write("".join([_row(*row) for row in self._rows]))
        self._telemetry.flush()
        self._rows.clear()

    def close(self) -> None:
        """Everything is on disk after this; closing again does nothing."""
        if not self._telemetry.closed:
            self._write_rows()
        self._events.close()
        self._telemetry.close()

    def write(self, name: str, content: Mapping[str, Any]) -> None:
        """A JSON file beside the log, for people to read too."""
        text = json.dumps(content, indent=2, ensure_ascii=False, default=as_json)
        (self.folder / name).write_text(text + "\n", encoding="utf-8")


def _row(seen: Observation, vehicle: str, state: str) -> str:
    roll, pitch = roll_pitch_of(seen.attitude)
    place = (seen.time, vehicle, *seen.position, *seen.velocity)
    return _ROW % (*place, roll, pitch, seen.yaw, seen.battery, seen.mode, state)


def file_hash(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    return sha256(path.read_bytes()).hexdigest()
