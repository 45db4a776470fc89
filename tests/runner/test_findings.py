"""What a run has found, as GeoJSON and CSV."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from fsm import parse_parameters
from runner import Plan, Recorder, fly, missions, prepare, read_run
from runner.findings import findings_of, write_findings
from tests.cli.run_cli import run_cli
from vencejo.errors import UserError
from vencejo.geometry import enu_of, lat_lon_of

CODE = """\
from dataclasses import dataclass
from behaviors import Behavior, Point

@dataclass
class Found:
    id: str
    kind: str
    position: Point
    status: str
    picture: str

class Tell(Behavior):
    controls = ()
    events = {"thing.found": Found}

    def start(self, flight, progress=None):
        self.left = [
            ("", "person", Point(3, 1, 0), "far", ""),
            ("person_1", "person", Point(3, 1, 0), "new", "person_1"),
            ("ball_1", "ball", Point(5, -2, 0), "new", ""),
            ("person_1", "person", Point(3.25, 1.5, 0), "known", "person_1"),
            ("person_1", "person", Point(9, 9, 1), "new", "person_1"),
        ]

    def step(self, flight):
        if not self.left:
            return "done"
        flight.raise_event("thing.found", Found(*self.left.pop(0)))
"""
MISSION = """\
mission: tell
uses: [tell.py]
states: {tell: {do: tell, on: {done: end, failed: end}}, end: {type: final}}
"""
WORLD = "world: w\norigin: {lat: 40.4168, lon: -3.7038, alt: 667 m}\nstart: {at: [10, 20]}\n"


@pytest.fixture
def flown(tmp_path: Path) -> Callable[..., Path]:
    def fly_it(world: str = WORLD, code: str = CODE) -> Path:
        (tmp_path / "tell.py").write_text(code)
        (tmp_path / "tell.yaml").write_text(MISSION)
        (tmp_path / "w.yaml").write_text(world)
        prepared = prepare(missions.find(str(tmp_path / "tell.yaml")), str(tmp_path / "w.yaml"))
        plan = Plan.alone(prepared, parse_parameters(prepared.graph, {}))
        folder = tmp_path / "run"
        folder.mkdir()
        fly(plan, lambda: Recorder(folder))
        return folder

    return fly_it


def test_each_thing_is_there_once_with_its_last_place(flown: Callable[..., Path]) -> None:
    folder = flown()
    files = write_findings(folder)
    assert [file.name for file in files] == ["findings.geojson", "findings.csv"]
    collection = json.loads(files[0].read_text())
    assert collection["type"] == "FeatureCollection"
    told = [feature["properties"] for feature in collection["features"]]
    assert [(each["id"], each["status"]) for each in told] == [
        ("person_1", "known"),
        ("ball_1", "new"),
        ("person_1", "new"),
    ]
    # The mission counts from where the vehicle stood.
    assert [(each["x"], each["y"], each["z"]) for each in told] == [
        (13.25, 21.5, 0.0),
        (15.0, 18.0, 0.0),
        (19.0, 29.0, 1.0),
    ]
    assert [each["picture"] for each in told] == [
        "photos/drone/person_1.jpg",
        "",
        "photos/drone/person_1-2.jpg",
    ]
    assert told[0]["t"] < told[1]["t"] < told[2]["t"]
    for feature, each in zip(collection["features"], told, strict=True):
        assert feature["type"] == "Feature" and feature["geometry"]["type"] == "Point"
        lon, lat, alt = feature["geometry"]["coordinates"]
        place = enu_of(lat, lon, 40.4168, -3.7038)
        assert place == pytest.approx((each["x"], each["y"]), abs=0.002)
        assert alt == 667 + each["z"]
    rows = list(csv.DictReader(files[1].read_text().splitlines()))
    assert [row["id"] for row in rows] == ["person_1", "ball_1", "person_1"]
    lon, lat, _ = collection["features"][0]["geometry"]["coordinates"]
    assert (float(rows[0]["lon"]), float(rows[0]["lat"])) == (lon, lat)
    assert rows[0].keys() == {
        *("id", "kind", "status", "vehicle", "t", "lat", "lon", "alt", "x", "y", "z", "picture")
    }


def test_a_world_that_lies_nowhere_gives_no_geometry(flown: Callable[..., Path]) -> None:
    folder = flown(WORLD.replace("origin: {lat: 40.4168, lon: -3.7038, alt: 667 m}\n", ""))
    geojson, table = write_findings(folder)
    features = json.loads(geojson.read_text())["features"]
    assert [feature["geometry"] for feature in features] == [None] * 3
    assert features[0]["properties"]["x"] == 13.25
    assert next(csv.DictReader(table.read_text().splitlines()))["lat"] == ""


def test_a_run_that_was_killed_has_them_too(flown: Callable[..., Path]) -> None:
    folder = flown()
    events = folder / "events.jsonl"
    lines = events.read_bytes().split(b"\n")
    last = next(k for k, line in enumerate(lines) if b'"ball_1"' in line)
    events.write_bytes(b"\n".join(lines[: last + 1])[:-20])
    (folder / "summary.json").unlink(missing_ok=True)
    (found,) = findings_of(read_run(folder))
    assert (found.id, found.status, found.position.x) == ("person_1", "new", 13.0)
    result = run_cli("findings", str(folder))
    assert result.code == 0 and result.out.split() == [
        str(folder / "findings.geojson"),
        str(folder / "findings.csv"),
    ]


@pytest.mark.parametrize(
    "code",
    [
        CODE.replace("self.left = [", "self.left = []\n        _ = ["),
        CODE.replace('"person_1", "person"', '"", "person"').replace('"ball_1"', '""'),
        CODE.replace("    picture: str\n", "").replace(
            "*self.left.pop(0)", "*self.left.pop(0)[:4]"
        ),
    ],
    ids=["nothing told", "nothing named", "other fields"],
)
def test_nothing_found_writes_nothing(flown: Callable[..., Path], code: str) -> None:
    folder = flown(code=code)
    assert write_findings(folder) == []
    assert not (folder / "findings.csv").exists()
    result = run_cli("findings", str(folder))
    assert result.code == 2 and "no-findings" in result.err


def test_findings_without_room_are_told_and_can_be_written_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_bytes = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if path.name.startswith("findings."):
            raise OSError(28, "No space left on device")
        return write_bytes(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    (tmp_path / "tell.py").write_text(CODE)
    (tmp_path / "tell.yaml").write_text(MISSION)
    command = ("run", str(tmp_path / "tell.yaml"), "--runs-dir", str(tmp_path / "runs"))
    done = run_cli(*command, "--no-picture")
    assert done.code == 4
    assert "no findings: " in done.err and "No space left on device [cannot-write]" in done.err
    assert "ended in 'done'" in done.out and "findings: " not in done.out
    (run,) = (tmp_path / "runs").iterdir()
    assert not list(run.glob("findings*"))
    assert run_cli("findings", str(run)).code == 4
    monkeypatch.undo()
    assert run_cli("findings", str(run)).code == 0


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError) as raised:
        write_findings(tmp_path)
    assert raised.value.faults[0].code == "no-run"


@pytest.mark.parametrize("place", [(0.0, 0.0), (120.0, -45.0), (-3.0, 900.0)])
def test_degrees_lead_back_to_metres(place: tuple[float, float]) -> None:
    lat, lon = lat_lon_of(*place, 40.4168, -3.7038)
    assert enu_of(lat, lon, 40.4168, -3.7038) == pytest.approx(place, abs=1e-6)
