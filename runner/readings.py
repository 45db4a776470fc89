"""Writes the sensor readings that a mission read: ``readings.jsonl``."""

from __future__ import annotations

from pathlib import Path

from hal.vehicle import Reading
from runner.appended_file import AppendedFile, encode
from runner.run_folder import READINGS, reading_fields, readings_header


class ReadingFile:
    """Appends readings to a run folder, each once; without readings there is no file."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lines: AppendedFile | None = None
        self._last: dict[tuple[str, str], float] = {}
        """Time of the last reading written, by vehicle and sensor."""

    def write(self, vehicle: str, sensor: str, reading: Reading) -> None:
        """Keep a reading. Raises UserError (``cannot-record``)."""
        if self._last.get((vehicle, sensor)) == reading.time:
            return
        if self._lines is None:
            self._lines = AppendedFile(self._folder / READINGS)
            self._lines.append([encode(readings_header())])
        self._lines.append([encode(reading_fields(vehicle, sensor, reading))])
        self._last[vehicle, sensor] = reading.time

    def close(self) -> None:
        if self._lines is not None:
            self._lines.close()
