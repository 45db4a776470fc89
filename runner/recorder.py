"""The recorder: writes the run folder of a flight, in flight by appending only.

``events.jsonl`` holds one JSON object a line and nothing of this machine or this moment, so that
equal runs give equal bytes; runner/run_folder.py knows the formats.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from behaviors import Pilot
from behaviors.channel import Draw
from fsm.engine.instance import Record
from hal.vehicle import Frame, Observation, Reading, Setpoint
from runner.appended_file import AppendedFile, as_json, encode, writing
from runner.frames import FrameFiles, PhotoFiles, PictureFiles
from runner.readings import ReadingFile
from runner.run_folder import (
    EVENTS,
    SUMMARY,
    Header,
    Summary,
    entry_fields,
    header_fields,
    picture_folder,
    summary_fields,
    telemetry_files,
)
from runner.telemetry import COLUMNS, row_of
from vencejo.errors import UserError, Where, reason_of
from vencejo.files import write_whole

PICTURE_RATE = 5.0
"""Annotated pictures of a name that are kept in a second, unless more are asked for."""
_ROWS_AT_ONCE = 40
"""Rows of telemetry written together: a killed run may lose one second of them."""
_Row = tuple[Observation, str, Sequence[str], Setpoint | None, str]
"""What :func:`runner.telemetry.row_of` makes a row of."""


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
        message = f"cannot make a run folder: {reason_of(error)}"
        hint = "choose another place: --runs-dir"
        raise UserError("no-run-folder", message, Where(str(parent)), hint) from None
    raise UserError("no-run-folder", "too many runs of one second", Where(str(parent)))


class Recorder:
    """Appends records, telemetry and frames to the files of one run folder.

    What cannot be written raises UserError (``cannot-record``).
    """

    def __init__(
        self, folder: Path, *, frames: bool = True, picture_rate: float = PICTURE_RATE
    ) -> None:
        """``frames``: whether the camera frames that were read, and annotated pictures, are kept;
        ``picture_rate``: the most pictures of a name that are kept in a second.
        """
        self.folder = folder
        self._sequence = 0
        self._rows: dict[str, list[_Row]] = {}
        """By vehicle, those that are not written yet."""
        self._states: dict[str, Sequence[str]] = {}
        """Paths of the active leaf states, by vehicle."""
        place = folder.absolute()  # a person's code may go to another folder in flight
        self._frames = FrameFiles(place) if frames else None
        self._unwritten_frames: list[tuple[str, str, Frame]] = []
        """Vehicle, camera and frame of every frame read but not yet written."""
        self._pictures = PictureFiles(place, picture_rate)
        self._photos = PhotoFiles(place)
        self._unwritten_photos: list[tuple[str, str, Frame]] = []
        """Vehicle, name and frame of every photo not yet written."""
        self._readings = ReadingFile(place)
        self._unwritten_readings: list[tuple[str, str, Reading]] = []
        """Vehicle, sensor and reading of every reading read but not yet written."""
        self._events = AppendedFile(folder / EVENTS)
        self._telemetry: dict[str, AppendedFile] = {}
        """By vehicle."""

    @contextmanager
    def beginning(self) -> Iterator[None]:
        """Leave no run folder behind where what the block writes cannot be written."""
        try:
            yield
        except UserError:
            with suppress(UserError):
                self.close()
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    def keep(self, files: Mapping[str, bytes]) -> None:
        """Write copies of files that the flight depends on, by their path in the folder."""
        for name, content in files.items():
            copy = self.folder / name
            with writing(copy):
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(content)

    def begin(self, header: Header) -> None:
        """Write the first lines of events and telemetry."""
        self._events.append([encode(header_fields(header))])
        for vehicle, file in telemetry_files(header.missions).items():
            path = self.folder / file
            with writing(path):
                path.parent.mkdir(parents=True, exist_ok=True)
            self._telemetry[vehicle] = AppendedFile(path)
            self._telemetry[vehicle].append([COLUMNS])
            self._rows[vehicle] = []

    def follow(self, pilot: Pilot) -> None:
        """Record the frames and readings that the behaviours of this pilot read."""
        if self._frames is not None:
            pilot.channel.on_frame = partial(self._keep_frame, pilot.vehicle.name)
            pilot.channel.on_picture = partial(self._keep_picture, pilot)
        pilot.channel.on_photo = partial(self._keep_photo, pilot.vehicle.name)
        pilot.channel.on_reading = partial(self._keep_reading, pilot.vehicle.name)

    def _keep_frame(self, vehicle: str, camera: str, frame: Frame) -> None:
        # Written after the period: a full disk is no failure of the behaviour that reads a frame.
        self._unwritten_frames.append((vehicle, camera, frame))

    def _keep_picture(self, pilot: Pilot, name: str, draw: Draw) -> None:
        self._pictures.offer(pilot.vehicle.name, name, pilot.channel.now, draw)

    @property
    def picture_folders(self) -> Sequence[Path]:
        """Where annotated pictures are, a folder of each vehicle and name, in the order in which
        they came.
        """
        return [self.folder / picture_folder(*name) for name in self._pictures.names]

    def _keep_photo(self, vehicle: str, name: str, camera: str, frame: Frame) -> None:
        self._unwritten_photos.append((vehicle, name, frame))

    def _keep_reading(self, vehicle: str, sensor: str, reading: Reading) -> None:
        self._unwritten_readings.append((vehicle, sensor, reading))

    def take(self, pilot: Pilot) -> list[Record]:
        """Write one period of a pilot: its records, now empty, and a row of telemetry."""
        records = self.take_records(pilot)
        seen = pilot.channel.world
        vehicle = pilot.vehicle.name
        # Formatted many at a time: one by one they would take twice as long.
        told = pilot.channel.commanded, pilot.manoeuvre
        rows = self._rows[vehicle]
        rows.append((seen, vehicle, self._states.get(vehicle, ()), *told))
        if len(rows) == _ROWS_AT_ONCE:
            self._write_rows(vehicle)
        if self._unwritten_frames:
            self._write_frames()
        self._pictures.write()
        if self._unwritten_photos:
            self._write_photos()
        if self._unwritten_readings:
            self._write_readings()
        return records

    def take_records(self, pilot: Pilot) -> list[Record]:
        """Write the records of a pilot, now empty."""
        records = pilot.instance.records
        vehicle = pilot.vehicle.name
        if records:
            pilot.instance.records = []
            lines = []
            for kind, fields in records:
                time = pilot.channel.world.time
                entry = entry_fields(self._sequence, time, vehicle, kind, fields)
                lines.append(encode(entry))
                self._sequence += 1
            self._events.append(lines)
            self._states[vehicle] = pilot.instance.paths()
        return records

    def _write_rows(self, vehicle: str) -> None:
        rows, self._rows[vehicle] = self._rows[vehicle], []
        self._telemetry[vehicle].append([row_of(*row) for row in rows])

    def _write_frames(self) -> None:
        read, self._unwritten_frames = self._unwritten_frames, []
        if self._frames is not None:
            for frame in read:
                self._frames.write(*frame)

    def _write_photos(self) -> None:
        taken, self._unwritten_photos = self._unwritten_photos, []
        for photo in taken:
            self._photos.write(*photo)

    def _write_readings(self) -> None:
        measured, self._unwritten_readings = self._unwritten_readings, []
        for reading in measured:
            self._readings.write(*reading)

    def close(self) -> None:
        """Everything is on disk after this; closing again does nothing."""
        with ExitStack() as stack:
            files = (
                self._frames,
                self._pictures,
                self._readings,
                *self._telemetry.values(),
                self._events,
            )
            for file in files:
                if file is not None:
                    stack.callback(file.close)
            for vehicle, rows in self._rows.items():
                if rows:
                    self._write_rows(vehicle)
            self._write_frames()
            self._pictures.write()
            self._write_photos()
            self._write_readings()

    def write_summary(self, summary: Summary) -> None:
        """Write how the run ended, for people to read too."""
        fields = summary_fields(summary, self.folder)
        text = json.dumps(fields, indent=2, ensure_ascii=False, default=as_json)
        with writing(self.folder / SUMMARY):
            write_whole(self.folder / SUMMARY, f"{text}\n".encode())
