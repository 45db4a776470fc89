"""Paths in CSV files: a row for each place, with its time and heading if the file has them."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import pairwise
from pathlib import Path

from behaviors.path import SAME, turns_back
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.geometry import Point, distance
from vencejo.nodes import read_plain

MAX_ROWS = 2000
_COLUMNS = ("t", "x", "y", "z", "yaw")
_NEEDED = ("x", "y", "z")
_LARGEST = 1e6
"""The largest number, metres, seconds or radians."""
_LEAST_TIME = 1e-3
"""Between two rows, seconds."""
_LEAST_SPEED = 0.05
"""Between two rows, m/s: what is slower comes no further for so long that it seems held up."""
_HEADERS = "the first line is t,x,y,z or x,y,z, with yaw behind it if you like"


@dataclass(frozen=True)
class PathFile:
    """The rows of a file: places of the mission frame, metres."""

    places: tuple[Point, ...]
    times: tuple[float, ...] | None
    """Seconds, 0 at the first row; None where the file has no times."""
    yaws: tuple[float, ...] | None
    """Radians counter-clockwise from east; None where the file has none."""


@dataclass(frozen=True)
class _Row:
    where: Where
    values: dict[str, float]

    @property
    def place(self) -> Point:
        return Point(*(self.values[axis] for axis in _NEEDED))


def read_path_file(path: Path, shown_as: str) -> PathFile:
    """Read a CSV file with the columns ``x,y,z``, and ``t`` and ``yaw`` if it has them, in metres,
    seconds and radians; ``shown_as`` is its name in errors.

    Raises UserError: those of :func:`vencejo.nodes.read_plain`, and ``wrong-path-file`` with the
    place of each fault in the file.
    """
    faults: list[Fault] = []
    lines = _lines(read_plain(path, shown_as, ".csv"), shown_as)
    names = _header(lines, shown_as)
    rows = [row for line in lines if (row := _row(*line, names, faults)) is not None]
    if not faults:
        faults += _faults_of(rows, shown_as)
    if faults:
        raise UserError.of(faults)
    times = yaws = None
    if "t" in names:
        begin = rows[0].values["t"]
        times = tuple(row.values["t"] - begin for row in rows)
    if "yaw" in names:
        yaws = tuple(row.values["yaw"] for row in rows)
    return PathFile(tuple(row.place for row in rows), times, yaws)


_Line = tuple[Where, list[str]]


def _lines(text: str, file: str) -> Iterator[_Line]:
    """The fields of each line that is not empty. Quotes stay, so that columns can be counted."""
    reader = csv.reader(StringIO(text), quoting=csv.QUOTE_NONE)
    try:
        for fields in reader:
            if any(field.strip() for field in fields):
                yield Where(file, reader.line_num, 1), fields
    except csv.Error as error:
        place = Where(file, reader.line_num, 1)
        raise UserError("wrong-path-file", f"this is no CSV: {error}", place, _HEADERS) from None


def _cells(where: Where, fields: Sequence[str]) -> Iterator[tuple[Where, str]]:
    """The text of each field, without spaces and quotes, and its place."""
    for field in fields:
        yield where.right(len(field) - len(field.lstrip())), field.strip().strip('"').strip()
        where = where.right(len(field) + 1)


def _header(lines: Iterator[_Line], file: str) -> list[str]:
    """The names of the columns. Raises UserError."""
    where, fields = next(lines, (Where(file, 1, 1), []))
    names: list[str] = []
    for place, name in _cells(where, fields):
        if name not in _COLUMNS:
            hint = nearest(name, _COLUMNS, _HEADERS) if name.isalpha() else _HEADERS
            raise _wrong(f"there is no column '{name[:40]}' of a path", place, hint)
        if name in names:
            raise _wrong(f"the column '{name}' stands here twice", place, _HEADERS)
        names.append(name)
    missing = [name for name in _NEEDED if name not in names]
    if missing:
        raise _wrong(f"the column '{missing[0]}' is missing", where, _HEADERS)
    return names


def _wrong(message: str, where: Where, hint: str | None) -> UserError:
    return UserError("wrong-path-file", message, where, hint)


def _row(
    where: Where, fields: Sequence[str], names: Sequence[str], faults: list[Fault]
) -> _Row | None:
    """The numbers of a line; None where they are wrong, which is told."""
    if len(fields) != len(names):
        count = "1 value" if len(fields) == 1 else f"{len(fields)} values"
        message = f"this row has {count}, and the file {len(names)} columns"
        faults.append(Fault("wrong-path-file", message, where, "a decimal point is a point"))
        return None
    values: dict[str, float] = {}
    for name, (place, text) in zip(names, _cells(where, fields), strict=True):
        number = _number(text)
        if number is None:
            message = f"'{text[:40]}' is no number for '{name}'"
            hint = f"metres, seconds and radians as plain numbers, {_LARGEST:,.0f} at most"
            faults.append(Fault("wrong-path-file", message, place, hint))
        else:
            values[name] = number
    return _Row(where, values) if len(values) == len(names) else None


def _number(text: str) -> float | None:
    """A number of moderate size; None for all else, such as nan and what only Python reads."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if abs(number) <= _LARGEST and "_" not in text and text.isascii() else None


def _faults_of(rows: Sequence[_Row], file: str) -> Iterator[Fault]:
    """What is wrong with rows about each other."""
    if len(rows) < 2:
        message = f"a path has 2 rows or more, not {len(rows)}"
        yield Fault("wrong-path-file", message, rows[0].where if rows else Where(file))
    if len(rows) > MAX_ROWS:
        message = f"a path has {MAX_ROWS:,} rows at the most, not {len(rows):,}"
        hint = "leave some out: the path is smooth between those that are left"
        yield Fault("wrong-path-file", message, rows[MAX_ROWS].where, hint)
        return
    for before, row in pairwise(rows):
        told = _step_fault(before, row)
        if told is not None:
            yield Fault("wrong-path-file", told[0], row.where, told[1])
    for a, b, c in zip(rows, rows[1:], rows[2:], strict=False):
        if turns_back(a.place, b.place, c.place):
            message = "a smooth path cannot turn back here"
            yield Fault("wrong-path-file", message, b.where, "fly two paths, one after the other")


def _step_fault(before: _Row, row: _Row) -> tuple[str, str] | None:
    """What is wrong with the step from one row to the next, and the cure."""
    way = distance(before.place, row.place)
    if way <= SAME:
        return "this row is where the one before is", "leave it out; to stay, hover between paths"
    if "t" not in row.values:
        return None
    time = row.values["t"] - before.values["t"]
    if time < _LEAST_TIME:
        then, now = before.values["t"], row.values["t"]
        message = f"the times do not grow: {now:g} s comes after {then:g} s"
        return message, "t is in seconds, each a millisecond or more after the one before"
    if way / time < _LEAST_SPEED:
        message = f"it comes here at {way / time:.2g} m/s, and a path is flown at 0.05 m/s or more"
        return message, "give it less time; to stay, hover between paths"
    return None
