"""Findings of a run as files that maps and ground stations open, made from its records.

GeoJSON (RFC 7946): a FeatureCollection of points with longitude, latitude and altitude. CSV: the
same, one row each, for tables and for worlds that lie nowhere on the Earth.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from runner.run_folder import (
    EVENTS,
    FINDINGS_CSV,
    FINDINGS_GEOJSON,
    LogEntry,
    Run,
    photo_file,
    read_run,
)
from vencejo.errors import UserError, Where, cannot_write
from vencejo.files import write_whole
from vencejo.geometry import Point, lat_lon_of
from worlds import find_world
from worlds.world import Origin

EVENT = "thing.found"
"""The event that tells of a finding; docs/vision/sweep_detect.md has its fields."""
_FIELDS = {"id", "kind", "position", "status", "picture"}
_DEGREES, _METRES = 8, 3
"""Decimals of latitudes and longitudes (1 mm), and of metres."""


@dataclass(frozen=True)
class Finding:
    """A thing that a run has found."""

    id: str
    kind: str
    status: str
    """``new``, or ``known`` once it was seen for longer or again."""
    vehicle: str
    time: float
    """When it was found, seconds of the session's clock."""
    position: Point
    """The last that was told of it, world frame, metres."""
    geographic: tuple[float, float, float] | None
    """Latitude, longitude (degrees, WGS 84) and altitude (m); None where the world does not say."""
    picture: str
    """The photo, a path from the run folder; empty for none."""


def write_findings(folder: Path) -> list[Path]:
    """Write the findings of a run into its folder, also of one that was killed; the files.

    None are written where nothing was found. Raises UserError as :func:`runner.read_run` does, and
    ``cannot-write``.
    """
    found = findings_of(read_run(folder)) if _may_have_found(folder / EVENTS) else []
    if not found:
        return []
    texts = {FINDINGS_GEOJSON: as_geojson(found), FINDINGS_CSV: as_csv(found)}
    for name, text in texts.items():
        try:
            write_whole(folder / name, text.encode())
        except OSError as error:
            message = "the findings cannot be written"
            raise cannot_write(error, "cannot-write", message, Where(str(folder / name))) from None
    return [folder / name for name in texts]


def _may_have_found(events: Path) -> bool:
    """Whether a log may tell of findings, without reading it line by line; also where it cannot be
    read, which :func:`runner.read_run` explains.
    """
    try:
        return EVENT.encode() in events.read_bytes()
    except OSError:
        return True


def findings_of(run: Run) -> list[Finding]:
    """What a run has found, in the order in which it did."""
    origin = _origin(run)
    found: list[Finding] = []
    # By vehicle and id: a second behaviour of one flight counts from the beginning again.
    latest: dict[tuple[str, str], int] = {}
    photos: dict[tuple[str, str], int] = {}
    for entry in _told(run):
        told, key = entry.fields["fields"], (entry.vehicle, entry.fields["fields"]["id"])
        if told["status"] == "new":
            latest[key] = len(found)
            found.append(_finding(run, entry, origin, photos))
        elif key in latest:
            place = _world_place(run, entry)
            found[latest[key]] = replace(
                found[latest[key]],
                status=told["status"],
                position=place,
                geographic=_geographic(place, origin),
            )
    return found


def _told(run: Run) -> Iterator[LogEntry]:
    for entry in run.events:
        if entry.kind == "event" and entry.fields["name"] == EVENT:
            told = entry.fields["fields"]
            # A person's own behaviour may raise an event of that name with other fields.
            if told.keys() >= _FIELDS and told["id"]:
                yield entry


def _finding(
    run: Run, entry: LogEntry, origin: Origin | None, photos: dict[tuple[str, str], int]
) -> Finding:
    told, place = entry.fields["fields"], _world_place(run, entry)
    picture = ""
    if told["picture"]:
        name = entry.vehicle, told["picture"]
        photos[name] = photos.get(name, 0) + 1
        picture = photo_file(*name, photos[name])
    return Finding(
        told["id"],
        told["kind"],
        told["status"],
        entry.vehicle,
        entry.time,
        place,
        _geographic(place, origin),
        picture,
    )


def _world_place(run: Run, entry: LogEntry) -> Point:
    """The place of a finding in the world frame; the mission frame begins where its vehicle did."""
    samples = run.telemetry.get(entry.vehicle, ())
    begin = samples[0].position if samples else Point(0.0, 0.0, 0.0)
    return begin.plus(tuple(entry.fields["fields"]["position"]))


def _origin(run: Run) -> Origin | None:
    """The place of the run's world on the Earth, by the copy of its file; None if it has none."""
    settings = run.header.settings
    try:
        world = find_world(str(run.folder / settings.world) if settings else run.header.world)
    except UserError:
        return None
    return world.origin


def _geographic(place: Point, origin: Origin | None) -> tuple[float, float, float] | None:
    if origin is None:
        return None
    lat, lon = lat_lon_of(place.x, place.y, origin.lat, origin.lon)
    return round(lat, _DEGREES), round(lon, _DEGREES), round(origin.alt + place.z, _METRES)


def as_geojson(findings: list[Finding]) -> str:
    """Findings as a FeatureCollection; those of a world without an origin have no geometry."""
    features = [
        {
            "type": "Feature",
            "geometry": _geometry(finding),
            "properties": {
                name: value for name, value in _row(finding).items() if name not in _OF_GEOMETRY
            },
        }
        for finding in findings
    ]
    whole = {"type": "FeatureCollection", "features": features}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


_OF_GEOMETRY = ("lat", "lon", "alt")


def _geometry(finding: Finding) -> dict[str, Any] | None:
    if finding.geographic is None:
        return None
    lat, lon, alt = finding.geographic
    return {"type": "Point", "coordinates": [lon, lat, alt]}


def as_csv(findings: list[Finding]) -> str:
    """Findings as a table, with a line of names."""
    out = io.StringIO()
    rows = [_row(finding) for finding in findings]
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def _row(finding: Finding) -> dict[str, Any]:
    x, y, z = (round(number, _METRES) + 0.0 for number in finding.position)  # no -0.0
    lat, lon, alt = finding.geographic or (None, None, None)
    return {
        "id": finding.id,
        "kind": finding.kind,
        "status": finding.status,
        "vehicle": finding.vehicle,
        "t": round(finding.time, 6),
        "lat": lat,
        "lon": lon,
        "alt": alt,
        "x": x,
        "y": y,
        "z": z,
        "picture": finding.picture,
    }
