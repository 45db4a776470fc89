"""The run folder: the files that a flight leaves behind, and a reader of them.

This is the one place that knows the formats; docs/runs.md describes them for people. The recorder
writes what is encoded here, and :func:`read_run` gives it back, also of a run that was killed: its
files are only appended to in flight, so no more than their last lines can be cut off. The version
that the first line of ``events.jsonl`` names is that of all files but ``frames.jsonl``,
``pictures.jsonl`` and ``readings.jsonl``, which name their own.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

from hal.lights import Rgb
from hal.vehicle import Frame, Intrinsics, Reading
from runner.by_vehicle import are_alone, joined, vehicles_of
from runner.course import Entered
from runner.referee import Verdict, verdict_fields, verdict_of
from runner.separation import Nearest
from runner.settings import RunSettings, rgb, settings_fields, settings_of
from runner.telemetry import COLUMNS, KNOWN_COLUMNS, Sample, sample_of
from vencejo.errors import UserError, Where
from vencejo.geometry import Point, Quaternion

EVENTS, TELEMETRY, FRAMES, SUMMARY = "events.jsonl", "telemetry.csv", "frames.jsonl", "summary.json"
EVENTS_FORMAT, EVENTS_VERSION = "vencejo.events", 1
FRAMES_FORMAT, FRAMES_VERSION = "vencejo.frames", 1
PICTURES = "pictures.jsonl"
PICTURES_FORMAT, PICTURES_VERSION = "vencejo.pictures", 1
READINGS = "readings.jsonl"
READINGS_FORMAT, READINGS_VERSION = "vencejo.readings", 1
PICTURE = "flight.png"
FINDINGS_GEOJSON, FINDINGS_CSV = "findings.geojson", "findings.csv"
OWN_NAMES = (
    *(EVENTS, TELEMETRY, "telemetry", FRAMES, "frames", PICTURES, "pictures", "photos"),
    *(SUMMARY, READINGS, PICTURE, FINDINGS_GEOJSON, FINDINGS_CSV),
)
"""Names in a run folder that copies of files cannot have."""
SUCCESS, OTHER_OUTCOME, VEHICLE_FAILED, NOT_RECORDED, INTERRUPTED = 0, 1, 3, 4, 130
"""Exit codes of runs that have flown."""
LAST_ENTERED = 20
"""The number of states that a summary tells of, the last ones; ``events.jsonl`` has all."""
RawLine = TypeVar("RawLine")
Read = TypeVar("Read")


@dataclass(frozen=True)
class MissionFacts:
    """The mission that one vehicle flies."""

    name: str
    """Empty for a vehicle without a mission."""
    sha256: str
    """SHA-256 of the mission's own file, hexadecimal."""
    parameters: Mapping[str, Any]
    files: Mapping[str, str] = field(default_factory=dict)
    """SHA-256 of the files that the mission includes and uses, by path from its folder."""
    model: str = ""
    """The name of the vehicle's model; empty where it is not known."""
    color: Rgb | None = None
    """The colour of the vehicle's hull; None where it is not known, or the vehicle is alone."""


@dataclass(frozen=True)
class Header:
    """Everything that determines the course of a run."""

    missions: Mapping[str, MissionFacts]
    """By the name of the vehicle that flies it."""
    world: str
    world_sha256: str
    seed: int
    backend: str
    engine: str
    """Name and version of the physics engine or autopilot link."""
    vencejo: str
    """Version of vencejo that flew it."""
    settings: RunSettings | None = None
    """None in folders of releases that did not keep them."""
    fleet: str = ""
    """The name of the fleet; empty where none joins the vehicles."""


@dataclass(frozen=True)
class LogEntry:
    """One line of ``events.jsonl``; docs/runs.md lists the kinds and their fields."""

    sequence: int
    time: float
    """Seconds of the vehicle's clock."""
    vehicle: str
    kind: str
    fields: Mapping[str, Any]


@dataclass(frozen=True)
class RecordedFrame:
    """A camera frame that a behaviour read, with the time, intrinsics and pose of its image."""

    path: Path
    """The JPEG."""
    vehicle: str
    camera: str
    sequence: int
    time: float
    """Capture time, seconds of the vehicle's clock."""
    position: Point
    """Position of the camera, world frame, metres."""
    attitude: Quaternion
    """Camera optical frame (x right, y down, z out) to world, (x, y, z, w)."""
    intrinsics: Intrinsics


@dataclass(frozen=True)
class RecordedPicture:
    """An annotated picture that a behaviour showed."""

    path: Path
    """The JPEG."""
    vehicle: str
    name: str
    number: int
    """From 1, of each vehicle and name."""
    time: float
    """When it was drawn, seconds of the vehicle's clock."""


@dataclass(frozen=True)
class RecordedReading:
    """A reading of a sensor that a behaviour has read."""

    vehicle: str
    sensor: str
    reading: Reading


@dataclass(frozen=True)
class Flown:
    """The result of the flight of one vehicle."""

    outcome: str
    reason: str
    """The reason why the mission was ended from outside; empty when it ended by itself."""
    output: Mapping[str, Any]
    """The fields that the mission's final state gave."""
    mission_time: float
    """Seconds of the vehicle's clock from the start of the run to its end."""
    distance: float
    """Length of the path, metres."""
    max_altitude: float
    """Above home, metres."""
    battery: float
    """Charge left, 0 to 1."""
    entered: Sequence[Entered] = ()
    """The states that its mission entered, at most the last LAST_ENTERED, and why."""
    collisions: Mapping[str, int] = field(default_factory=dict)
    """Name of a thing → how often the vehicle ran into it."""
    failure: str = ""
    """The reason why the vehicle could not be landed; empty when it was."""
    left_ground: bool = True
    """Whether it was off the ground at any time."""


@dataclass(frozen=True)
class Summary:
    """The results of a run, with everything that they depend on."""

    header: Header
    vehicles: Mapping[str, Flown]
    """By name, in the order of the header."""
    wall_time: float
    """Seconds from the first step to the last byte of events and telemetry."""
    interrupted: bool
    """True when the run was asked to stop."""
    versions: Mapping[str, str]
    """Versions of the packages that the result may depend on, and of Python."""
    unrecorded: str = ""
    """The fault because of which the run folder is not whole; empty when it is."""
    ended_by_until: bool = False
    """Whether a fleet's flight ended because its condition came true."""
    separation: tuple[Nearest, ...] = ()
    """The least distance of each two vehicles."""
    verdict: Verdict | None = None
    """What the referee of a fleet says; None where there was none."""

    @property
    def alone(self) -> Flown:
        """The flight of the only vehicle. Raises ValueError when there are several."""
        (flown,) = self.vehicles.values()
        return flown

    @property
    def mission_time(self) -> float:
        """Seconds until the last vehicle was down."""
        return max(flown.mission_time for flown in self.vehicles.values())

    @property
    def exit_code(self) -> int:
        """0 when every mission ended in ``done``, or the condition of a fleet came true; 3 when a
        vehicle or its link failed, 130 when interrupted, 4 when the run could not be recorded, else
        1; the first of these that holds, from the gravest: 3, 130, 4.
        """
        if any(flown.failure for flown in self.vehicles.values()):
            return VEHICLE_FAILED
        if self.interrupted:
            return INTERRUPTED
        if self.unrecorded:
            return NOT_RECORDED
        done = all(flown.outcome == "done" for flown in self.vehicles.values())
        return SUCCESS if done or self.ended_by_until else OTHER_OUTCOME


@dataclass(frozen=True)
class Run:
    """A run folder, read."""

    folder: Path
    header: Header
    events: tuple[LogEntry, ...]
    telemetry: Mapping[str, tuple[Sample, ...]]
    """By vehicle, in the order of time: one sample each mission period (25 ms)."""
    frames: tuple[RecordedFrame, ...]
    """Frames of cameras, in the order in which they were read."""
    pictures: tuple[RecordedPicture, ...]
    """Annotated pictures, in the order in which they were drawn."""
    readings: tuple[RecordedReading, ...]
    """Readings of sensors, in the order in which they were read."""
    summary: Summary | None
    """None for a run that has not ended."""
    missing: tuple[str, ...]
    """Descriptions of missing or truncated parts, if the run was killed or still flies."""


def telemetry_files(vehicles: Collection[str]) -> dict[str, str]:
    """The paths of the telemetry of all vehicles of a run, from its folder."""
    if are_alone(vehicles):
        return dict.fromkeys(vehicles, TELEMETRY)
    return {vehicle: f"telemetry/{vehicle}.csv" for vehicle in vehicles}


def header_fields(header: Header) -> dict[str, Any]:
    """The first line of ``events.jsonl``, as an object for JSON."""
    vehicles = {
        vehicle: {
            "mission": mission.name or None,
            "mission_sha256": mission.sha256 or None,
            **({"files_sha256": dict(mission.files)} if mission.files else {}),
            "parameters": dict(mission.parameters),
            **_model_fields(mission),
            **({"color": list(mission.color)} if mission.color else {}),
        }
        for vehicle, mission in header.missions.items()
    }
    run = {
        "format": EVENTS_FORMAT,
        "version": EVENTS_VERSION,
        **({"fleet": header.fleet} if header.fleet else {}),
        "world": header.world,
        "world_sha256": header.world_sha256,
        "seed": header.seed,
        "backend": header.backend,
        "engine": header.engine,
        "vencejo": header.vencejo,
        **_settings_fields(header),
    }
    return joined(vehicles, run, _HEADER_ORDER)


def _model_fields(mission: MissionFacts) -> dict[str, str]:
    return {"model": mission.model} if mission.model else {}


def _settings_fields(header: Header) -> dict[str, Any]:
    return {"settings": settings_fields(header.settings)} if header.settings else {}


_HEADER_ORDER = (
    *("format", "version", "fleet", "mission", "mission_sha256", "files_sha256"),
    *("vehicles", "world"),
    *("world_sha256", "seed", "parameters", "model", "backend", "engine", "vencejo", "settings"),
)


def entry_fields(
    sequence: int, time: float, vehicle: str, kind: str, fields: Mapping[str, Any]
) -> dict[str, Any]:
    """Any other line of ``events.jsonl``, as an object for JSON."""
    return {"seq": sequence, "t": time, "vehicle": vehicle, "kind": kind, **fields}


def frames_header() -> dict[str, Any]:
    """The first line of ``frames.jsonl``, as an object for JSON."""
    return {"format": FRAMES_FORMAT, "version": FRAMES_VERSION}


def frame_file(vehicle: str, camera: str, frame: Frame) -> str:
    """The path of a picture, from the run folder."""
    return f"frames/{vehicle}/{camera}/{frame.sequence:06d}.jpg"


def photo_file(vehicle: str, name: str, number: int) -> str:
    """The path of the n-th photo of a name, from the run folder."""
    return f"photos/{vehicle}/{name}{f'-{number}' if number > 1 else ''}.jpg"


def frame_fields(
    vehicle: str, camera: str, frame: Frame, *, with_intrinsics: bool
) -> dict[str, Any]:
    """Any other line of ``frames.jsonl``, as an object for JSON; ``frame`` is of the world frame.

    Intrinsics stand in the first line of each camera and where they have changed.
    """
    return {
        "t": frame.time,
        "vehicle": vehicle,
        "camera": camera,
        "sequence": frame.sequence,
        "file": frame_file(vehicle, camera, frame),
        "position": frame.position,
        "attitude": frame.attitude,
        **({"intrinsics": asdict(frame.intrinsics)} if with_intrinsics else {}),
    }


def pictures_header() -> dict[str, Any]:
    """The first line of ``pictures.jsonl``, as an object for JSON."""
    return {"format": PICTURES_FORMAT, "version": PICTURES_VERSION}


def picture_folder(vehicle: str, name: str) -> str:
    """The path of the annotated pictures of a name, from the run folder."""
    return f"pictures/{vehicle}/{name}"


def picture_file(vehicle: str, name: str, number: int) -> str:
    """The path of the n-th annotated picture of a name, from the run folder."""
    return f"{picture_folder(vehicle, name)}/{number:06d}.jpg"


def picture_fields(vehicle: str, name: str, number: int, time: float) -> dict[str, Any]:
    """Any other line of ``pictures.jsonl``, as an object for JSON."""
    file = picture_file(vehicle, name, number)
    return {"t": time, "vehicle": vehicle, "name": name, "number": number, "file": file}


def readings_header() -> dict[str, Any]:
    """The first line of ``readings.jsonl``, as an object for JSON."""
    return {"format": READINGS_FORMAT, "version": READINGS_VERSION}


def reading_fields(vehicle: str, sensor: str, reading: Reading) -> dict[str, Any]:
    """Any other line of ``readings.jsonl``, as an object for JSON.

    A value that is not finite (nothing within range is infinitely far) is a text, ``"inf"``.
    """
    values = {
        name: value if isfinite(value) else str(value) for name, value in reading.values.items()
    }
    return {"t": reading.time, "vehicle": vehicle, "sensor": sensor, "values": values}


def summary_fields(summary: Summary, folder: Path | None) -> dict[str, Any]:
    """The object that ``summary.json`` holds and ``drone-cli run --json`` prints, rounded."""
    header, wall = summary.header, summary.wall_time
    vehicles = {
        vehicle: {
            "mission": header.missions[vehicle].name or None,
            **_flown_fields(flown),
            "parameters": dict(header.missions[vehicle].parameters),
            **_model_fields(header.missions[vehicle]),
        }
        for vehicle, flown in summary.vehicles.items()
    }
    run = {
        **({"fleet": header.fleet} if header.fleet else {}),
        **_together_fields(summary),
        "success": summary.exit_code == SUCCESS,
        "exit_code": summary.exit_code,
        "mission_time_s": round(summary.mission_time, 6),
        "wall_time_s": round(wall, 4),
        "realtime_factor": round(summary.mission_time / wall, 1) if wall > 0 else None,
        "world": header.world,
        "seed": header.seed,
        "backend": header.backend,
        "engine": header.engine,
        **_settings_fields(header),
        "versions": dict(summary.versions),
        **({"unrecorded": summary.unrecorded} if summary.unrecorded else {}),
        "run_folder": str(folder) if folder else None,
    }
    return joined(vehicles, run, _SUMMARY_ORDER)


def _together_fields(summary: Summary) -> dict[str, Any]:
    """What is told of several vehicles together; nothing of one that flies alone."""
    separation = [
        {"vehicles": list(pair), "distance_m": round(distance, 3), "t": round(time, 6)}
        for pair, distance, time in summary.separation
    ]
    until = {"ended_by_until": True} if summary.ended_by_until else {}
    verdict = {"referee": verdict_fields(summary.verdict)} if summary.verdict else {}
    return {**until, **({"separation": separation} if separation else {}), **verdict}


_SUMMARY_ORDER = (
    *("fleet", "mission", "outcome", "success", "reason", "failure", "output", "ended_by_until"),
    "exit_code",
    *("mission_time_s", "wall_time_s", "realtime_factor", "distance_m", "max_altitude_m"),
    *("left_ground", "battery_left", "entered", "collisions", "separation", "referee", "vehicles"),
    *("world", "parameters", "seed", "model", "backend", "engine", "settings"),
    *("versions", "unrecorded", "run_folder"),
)
"""Order of the keys for a person to read: the results come first."""


def _flown_fields(flown: Flown) -> dict[str, Any]:
    return {
        "outcome": flown.outcome,
        "reason": flown.reason or None,
        "output": dict(flown.output),
        "mission_time_s": round(flown.mission_time, 6),
        "distance_m": round(flown.distance, 2),
        "max_altitude_m": round(flown.max_altitude, 2),
        "left_ground": flown.left_ground,
        "battery_left": round(flown.battery, 4),
        "entered": [
            {"t": round(time, 6), "state": state, "why": why or None}
            for time, state, why in flown.entered
        ],
        "collisions": dict(flown.collisions),
        **({"failure": flown.failure} if flown.failure else {}),
    }


def read_run(folder: Path | str) -> Run:
    """Read a run folder, also of a run that was killed.

    Raises UserError: ``no-run`` for what is no run folder, ``unknown-run-format`` for files of
    another program or version, ``damaged-run`` for a line that no recorder has written.
    """
    folder = Path(folder)
    missing: list[str] = []
    header, lines = _begun(folder, missing)
    return Run(
        folder=folder,
        header=header,
        events=tuple(_each(folder / EVENTS, lines, _entry)),
        telemetry=_telemetry(folder, header.missions, missing),
        frames=tuple(_frames(folder, missing)),
        pictures=tuple(_pictures(folder, missing)),
        readings=tuple(_readings(folder / READINGS, missing)),
        summary=_summary(folder / SUMMARY, header, missing),
        missing=tuple(missing),
    )


def read_header(folder: Path) -> Header:
    """Read what made a run what it is. Raises UserError like :func:`read_run`."""
    return _begun(folder, [])[0]


def _begun(folder: Path, missing: list[str]) -> tuple[Header, list[bytes]]:
    """The header of a run, and the other lines of its events; what is not there is ``missing``."""
    lines = _lines(folder / EVENTS, missing)
    if not lines:
        message = f"'{folder}' is no run folder: {missing[0]}"
        raise UserError("no-run", message, Where(str(folder)), "name one of `runs/`")
    return _header(folder / EVENTS, lines[0]), lines[1:]


def _lines(path: Path, missing: list[str]) -> list[bytes]:
    """The whole lines of a file; what it lacks goes to ``missing``. Raises UserError."""
    try:
        *whole, rest = path.read_bytes().split(b"\n")
    except (FileNotFoundError, NotADirectoryError):
        missing.append(f"{path.name} is not there")
        return []
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError("no-run", f"this file cannot be read: {reason}", Where(str(path))) from None
    if rest:
        missing.append(_cut(path))
    elif not whole:
        missing.append(f"{path.name} is empty")
    return whole


def _cut(path: Path) -> str:
    return f"the last line of {path.name} is cut off"


def _each(
    path: Path, lines: Iterable[RawLine], read: Callable[[RawLine], Read], first: int = 2
) -> list[Read]:
    """All lines read; ``first`` is the number of the first. Raises UserError with the place."""
    found: list[Read] = []
    for number, line in enumerate(lines, first):
        try:
            found.append(read(line))
        except KeyError as error:
            raise _damaged(path, number, 1, f"{error} is missing in this line") from None
        except (AttributeError, TypeError, ValueError, csv.Error) as error:
            column = error.colno if isinstance(error, json.JSONDecodeError) else 1
            raise _damaged(path, number, column, f"this line cannot be read: {error}") from None
    return found


def _damaged(path: Path, line: int, column: int, message: str) -> UserError:
    hint = "the file was changed after the flight; take it from a copy, or fly again"
    return UserError("damaged-run", message, Where(str(path), line, column), hint)


def _known_format(path: Path, line: bytes, format_: str, version: int) -> dict[str, Any]:
    """The first line of a file of lines of JSON. Raises UserError when it is of another format."""
    try:
        fields = json.loads(line)
        found = fields["format"], fields["version"]
    except (KeyError, TypeError, ValueError):
        fields, found = {}, (None, None)
    if found == (format_, version):
        return dict(fields)
    if found[0] == format_:
        message = f"this is version {found[1]} of the format '{format_}'; known is {version}"
        hint = "read it with the release of vencejo that flew it"
    else:
        message, hint = f"the first line does not say that this is '{format_}'", None
    raise UserError("unknown-run-format", message, Where(str(path), 1, 1), hint)


def _header(path: Path, line: bytes) -> Header:
    fields = _known_format(path, line, EVENTS_FORMAT, EVENTS_VERSION)
    (header,) = _each(path, [fields], _header_of, first=1)
    return header


def _header_of(fields: Mapping[str, Any]) -> Header:
    return Header(
        missions={
            vehicle: MissionFacts(
                name=mission["mission"] or "",
                sha256=mission["mission_sha256"] or "",
                parameters=mission["parameters"],
                files=mission.get("files_sha256", {}),
                model=mission.get("model", ""),
                color=rgb(mission.get("color")),
            )
            for vehicle, mission in vehicles_of(fields).items()
        },
        world=fields["world"],
        world_sha256=fields["world_sha256"],
        seed=fields["seed"],
        backend=fields["backend"],
        engine=fields["engine"],
        vencejo=fields["vencejo"],
        settings=settings_of(fields["settings"]) if "settings" in fields else None,
        fleet=fields.get("fleet", ""),
    )


def _object(line: bytes) -> dict[str, Any]:
    found = json.loads(line)
    if not isinstance(found, dict):
        raise ValueError("it is no object")
    return found


def _entry(line: bytes) -> LogEntry:
    fields = _object(line)
    sequence, time = fields.pop("seq"), fields.pop("t")
    return LogEntry(sequence, time, fields.pop("vehicle"), fields.pop("kind"), fields)


def _telemetry(
    folder: Path, vehicles: Collection[str], missing: list[str]
) -> dict[str, tuple[Sample, ...]]:
    found: dict[str, list[Sample]] = {}
    # Earlier releases kept all vehicles in one file.
    in_one = (folder / TELEMETRY).exists()
    for file in [TELEMETRY] if in_one else telemetry_files(vehicles).values():
        for vehicle, sample in _rows(folder / file, missing):
            found.setdefault(vehicle, []).append(sample)
    return {vehicle: tuple(samples) for vehicle, samples in found.items()}


def _rows(path: Path, missing: list[str]) -> list[tuple[str, Sample]]:
    """The vehicle and sample of each line of a file of telemetry."""
    lines = _lines(path, missing)
    if not lines:
        return []
    columns = lines[0].decode("utf-8", "replace")
    if columns not in KNOWN_COLUMNS:
        message = f"its columns are not {COLUMNS}"
        raise UserError("unknown-run-format", message, Where(str(path), 1, 1))
    return _each(path, lines[1:], partial(sample_of, columns=columns))


def _below_header(path: Path, format_: str, version: int, missing: list[str]) -> list[bytes]:
    """The lines of a file but the first; none where there is no file, since the flight had nothing
    to write into it. Raises UserError for a first line of another format.
    """
    lines = _lines(path, missing) if path.exists() else []
    if lines:
        _known_format(path, lines[0], format_, version)
    return lines[1:]


def _frames(folder: Path, missing: list[str]) -> list[RecordedFrame]:
    path = folder / FRAMES
    last: dict[tuple[str, str], Intrinsics] = {}

    def read(line: bytes) -> RecordedFrame:
        fields = _object(line)
        vehicle, camera = fields["vehicle"], fields["camera"]
        if "intrinsics" in fields:
            given = Intrinsics(**fields["intrinsics"])
            last[vehicle, camera] = replace(given, distortion=tuple(given.distortion))
        if (vehicle, camera) not in last:
            raise KeyError("intrinsics")
        x, y, z, w = fields["attitude"]
        return RecordedFrame(
            path=folder / fields["file"],
            vehicle=vehicle,
            camera=camera,
            sequence=fields["sequence"],
            time=fields["t"],
            position=Point(*fields["position"]),
            attitude=(x, y, z, w),
            intrinsics=last[vehicle, camera],
        )

    frames = _each(path, _below_header(path, FRAMES_FORMAT, FRAMES_VERSION, missing), read)
    _note_lost([frame.path for frame in frames], missing)
    return frames


def _note_lost(paths: Sequence[Path], missing: list[str]) -> None:
    lost = sum(not path.exists() for path in paths)
    if lost:
        missing.append(f"{lost} of {len(paths)} pictures are not there")


def _pictures(folder: Path, missing: list[str]) -> list[RecordedPicture]:
    path = folder / PICTURES

    def read(line: bytes) -> RecordedPicture:
        fields = _object(line)
        whose = fields["vehicle"], fields["name"], fields["number"]
        return RecordedPicture(folder / fields["file"], *whose, fields["t"])

    pictures = _each(path, _below_header(path, PICTURES_FORMAT, PICTURES_VERSION, missing), read)
    _note_lost([picture.path for picture in pictures], missing)
    return pictures


def _readings(path: Path, missing: list[str]) -> list[RecordedReading]:
    def read(line: bytes) -> RecordedReading:
        fields = _object(line)
        values = {name: float(value) for name, value in fields["values"].items()}
        return RecordedReading(fields["vehicle"], fields["sensor"], Reading(fields["t"], values))

    return _each(path, _below_header(path, READINGS_FORMAT, READINGS_VERSION, missing), read)


def _summary(path: Path, header: Header, missing: list[str]) -> Summary | None:
    lacks: list[str] = []
    try:
        fields = json.loads(b"\n".join(_lines(path, lacks)))
    except ValueError:
        missing += lacks or [_cut(path)]  # the program ended before it was written, or while
        return None
    (summary,) = _each(path, [fields], lambda fields: _summary_of(fields, header), first=1)
    return summary


def _summary_of(fields: Mapping[str, Any], header: Header) -> Summary:
    return Summary(
        header=header,
        vehicles={vehicle: _flown_of(flown) for vehicle, flown in vehicles_of(fields).items()},
        wall_time=fields["wall_time_s"],
        interrupted=fields["exit_code"] == INTERRUPTED,
        versions=fields["versions"],
        unrecorded=fields.get("unrecorded", ""),
        ended_by_until=fields.get("ended_by_until", False),
        separation=tuple(map(_nearest_of, fields.get("separation", ()))),
        verdict=verdict_of(fields["referee"]) if "referee" in fields else None,
    )


def _nearest_of(fields: Mapping[str, Any]) -> Nearest:
    first, second = fields["vehicles"]
    return Nearest((first, second), fields["distance_m"], fields["t"])


def _flown_of(fields: Mapping[str, Any]) -> Flown:
    return Flown(
        outcome=fields["outcome"],
        reason=fields["reason"] or "",
        output=fields["output"],
        mission_time=fields["mission_time_s"],
        distance=fields["distance_m"],
        max_altitude=fields["max_altitude_m"],
        battery=fields["battery_left"],
        entered=tuple(
            Entered(each["t"], each["state"], each["why"] or "")
            for each in fields.get("entered", ())
        ),
        collisions=fields.get("collisions", {}),
        failure=fields.get("failure", ""),
        left_ground=fields.get("left_ground", True),
    )
