"""Writes the sensor readings that a mission read: ``readings.jsonl``."""

from __future__ import annotations

from pathlib import Path

from hal.vehicle import Reading
from runner.appended_file import JsonLines
from runner.run_folder import READINGS, reading_fields, readings_header


class ReadingFile:
    """Appends readings to a run folder, each once; without readings there is no file."""

    def __init__(self, folder: Path) -> None:
        self._lines = JsonLines(folder / READINGS, readings_header())
        self._last: dict[tuple[str, str], float] = {}
        """Time of the last reading written, by vehicle and sensor."""

    def write(self, vehicle: str, sensor: str, reading: Reading) -> None:
        """Keep a reading. Raises UserError (``cannot-record``)."""
        if self._last.get((vehicle, sensor)) == reading.time:
            return
        self._lines.append(reading_fields(vehicle, sensor, reading))
        self._last[vehicle, sensor] = reading.time

    def close(self) -> None:
        self._lines.close()
