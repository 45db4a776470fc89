"""Run folders: what the recorder writes is what `read_run` gives, also of runs that were killed."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import Pilot
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal.limits import Limits
from hal.vehicle import (
    Attitude,
    Frame,
    Hold,
    Intrinsics,
    Observation,
    Position,
    Setpoint,
    Velocity,
)
from runner import Plan, Recorder, Summary, fly, missions, prepare, read_run
from runner.by_vehicle import ALONE
from runner.run_folder import (
    Flown,
    Header,
    LogEntry,
    MissionFacts,
    Run,
    Sample,
    summary_fields,
)
from runner.settings import MissionSettings, RunSettings
from vencejo.errors import UserError
from vencejo.geometry import Point, about_y, product, roll_pitch_of, yaw_quaternion

MISSION = """\
mission: looker
uses: [look.py]
parameters: {height: 1 m}
states:
  up: {do: takeoff, with: {altitude: $height}, on: {done: look}}
  look: {do: look, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final, output: {high: $height}}
"""
BEHAVIOR = """\
from behaviors import Behavior

class Look(Behavior):
    '''Read three pictures of a camera.'''

    outcomes = {"done": None}
    requires = ("camera.front",)

    def start(self, flight, progress=None):
        self.seen = set()

    def step(self, flight):
        self.seen.add(flight.camera("front").latest().sequence)
        return "done" if len(self.seen) == 3 else None
"""


class Witness:
    """Remembers what a recorder is given."""

    def __init__(self) -> None:
        self.records: list[tuple[float, str, dict[str, Any]]] = []
        self.seen: list[tuple[Observation, Setpoint | None, str]] = []

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        self.seen.append((pilot.channel.world, pilot.channel.commanded, pilot.manoeuvre))
        self.records += [(pilot.channel.now, kind, fields) for kind, fields in records]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Witness, Summary]:
    """A whole run with pictures, what was seen of it and how it ended."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "look.py").write_text(BEHAVIOR)
    (folder / "looker.yaml").write_text(MISSION)
    prepared = prepare(missions.find(str(folder / "looker.yaml")))
    values = parse_parameters(prepared.graph, {"height": "2 m"})
    camera = {"front": {"width": 64, "height": 48, "rate": 20.0}}
    plan = Plan.alone(prepared, values, seed=3, settings={"cameras": camera})
    witness = Witness()
    run = folder / "run"
    run.mkdir()
    recorder = Recorder(run)
    summary = fly(plan, lambda: recorder, [witness])
    recorder.write_summary(summary)
    return run, witness, summary


@pytest.fixture
def folder(recorded: tuple[Path, Witness, Summary], tmp_path: Path) -> Path:
    """A copy of that run."""
    return Path(shutil.copytree(recorded[0], tmp_path / "run"))


def sample_of(
    seen: Observation, setpoint: Setpoint | None, manoeuvre: str, states: tuple[str, ...]
) -> Sample:
    """The sample as it is written: rounded."""

    def rounded(point: Point) -> Point:
        return Point(*(float(f"{value:.4f}") for value in point))

    roll, pitch = roll_pitch_of(seen.attitude)
    angles = [float(f"{value:.5f}") for value in (roll, pitch, seen.yaw, seen.battery)]
    place = rounded(seen.position), rounded(seen.velocity)
    told = as_written(setpoint), "" if setpoint else manoeuvre
    return Sample(float(f"{seen.time:.3f}"), *place, *angles, seen.mode, states, *told)


def as_written(setpoint: Setpoint | None) -> Setpoint | None:
    """A set-point, rounded."""

    def metres(value: float) -> float:
        return float(f"{value:.4f}")

    def angle(value: float | None) -> float | None:
        return None if value is None else float(f"{value:.5f}")

    match setpoint:
        case Position(xyz, velocity, yaw, rate):
            led = None if velocity is None else Point(*map(metres, velocity))
            return Position(Point(*map(metres, xyz)), led, angle(yaw), angle(rate))
        case Velocity(x, y, z, frame, rate):
            return Velocity(*map(metres, (x, y, z)), frame, float(f"{rate:.5f}"))
        case Attitude(roll, pitch, climb, thrust, rate, unit):
            tilt = float(f"{roll:.5f}"), float(f"{pitch:.5f}"), metres(climb)
            share = None if thrust is None else metres(thrust)
            return Attitude(*tilt, share, float(f"{rate:.5f}"), unit)
    return setpoint


def test_a_whole_run_is_read_as_it_was(recorded: tuple[Path, Witness, Summary]) -> None:
    folder, witness, summary = recorded
    run = read_run(folder)
    assert run.folder == folder
    assert run.header == summary.header
    assert run.header.missions[ALONE].parameters == {"height": 2.0}
    assert set(run.header.missions[ALONE].files) == {"look.py"}
    logged = [[entry.time, entry.kind, entry.fields] for entry in run.events]
    assert logged == json.loads(json.dumps(witness.records))
    assert [entry.sequence for entry in run.events] == list(range(len(witness.records)))
    assert {entry.vehicle for entry in run.events} == {ALONE}
    (samples,) = run.telemetry.values()
    assert [sample.states for sample in samples if sample.time in (0.025, 1.0)] == [("up",)] * 2
    assert list(samples) == [
        sample_of(*seen, sample.states) for seen, sample in zip(witness.seen, samples, strict=True)
    ]
    assert len(run.frames) == 3
    assert run.missing == ()
    assert run.summary is not None
    assert run.summary.alone.output == {"high": 2.0}
    assert summary_fields(run.summary, None) == summary_fields(
        replace(summary, wall_time=run.summary.wall_time), None
    )


def test_what_was_commanded_stands_beside_what_was_flown(folder: Path) -> None:
    (samples,) = read_run(folder).telemetry.values()
    kinds = [
        (type(sample.setpoint).__name__ if sample.setpoint else sample.manoeuvre)
        for sample in samples
    ]
    # An order is flown without set-points, and where nobody commands anything the pilot holds.
    assert [kind for kind, _ in groupby(kinds)] == ["takeoff", "", "Hold", "land", ""]


def test_telemetry_of_earlier_releases_is_read(folder: Path) -> None:
    now = read_run(folder)
    path = folder / "telemetry.csv"
    lines = path.read_text().splitlines()
    rows = [[*cells[:12], *cells[-2:]] for cells in (line.split(",") for line in lines)]
    path.write_text("".join(",".join(row) + "\n" for row in rows))
    (samples,), (known,) = read_run(folder).telemetry.values(), now.telemetry.values()
    assert list(samples) == [sample._replace(setpoint=None, manoeuvre="") for sample in known]


def test_frames_have_their_pictures_and_intrinsics(folder: Path) -> None:
    run = read_run(folder)
    numbers = [frame.sequence for frame in run.frames]
    assert numbers == [*range(numbers[0], numbers[0] + 3)]
    assert [frame.time for frame in run.frames] == pytest.approx([n / 20 for n in numbers])
    for frame in run.frames:
        assert frame.path.read_bytes().startswith(b"\xff\xd8")
        assert (frame.vehicle, frame.camera) == (ALONE, "front")
        # Those of the first line hold for all.
        assert (frame.intrinsics.width, frame.intrinsics.height) == (64, 48)
        assert frame.position.z == pytest.approx(2.0, abs=0.1)
        assert len(frame.attitude) == 4
    run.frames[1].path.unlink()
    assert read_run(folder).missing == ("1 of 3 pictures are not there",)


@pytest.mark.parametrize("share", [0.1, 0.35, 0.6, 0.85, 0.99])
@pytest.mark.parametrize("name", ["events.jsonl", "telemetry.csv", "frames.jsonl"])
def test_a_file_that_was_cut_off_gives_its_whole_lines(
    name: str, share: float, folder: Path
) -> None:
    whole = read_run(folder)
    text = (folder / name).read_bytes()
    kept = text[: max(int(len(text) * share), text.index(b"\n") + 1)]
    while kept.endswith(b"\n"):
        kept = text[: len(kept) + 1]
    (folder / name).write_bytes(kept)
    lines = kept.count(b"\n") - 1
    run = read_run(folder)
    assert run.missing == (f"the last line of {name} is cut off",)
    expected: dict[str, Run] = {
        "events.jsonl": replace(whole, events=whole.events[:lines]),
        "telemetry.csv": replace(
            whole, telemetry={ALONE: whole.telemetry[ALONE][:lines]} if lines else {}
        ),
        "frames.jsonl": replace(whole, frames=whole.frames[:lines]),
    }
    assert replace(run, missing=()) == expected[name]


def test_a_run_that_was_killed_says_what_is_missing(folder: Path) -> None:
    whole = read_run(folder)
    summary = folder / "summary.json"
    text = summary.read_text()
    summary.unlink()
    expected = replace(whole, summary=None, missing=("summary.json is not there",))
    assert read_run(folder) == expected
    for cut in (text[:40], text[: text.index("\n") + 1]):
        summary.write_text(cut)
        cut_off = ("the last line of summary.json is cut off",)
        assert read_run(folder) == replace(expected, missing=cut_off)
    summary.write_text(text)
    (folder / "telemetry.csv").write_text("")
    assert read_run(folder) == replace(whole, telemetry={}, missing=("telemetry.csv is empty",))
    (folder / "telemetry.csv").unlink()
    lost = replace(whole, telemetry={}, missing=("telemetry.csv is not there",))
    assert read_run(folder) == lost
    (folder / "frames.jsonl").unlink()
    assert read_run(folder) == replace(lost, frames=())


def test_what_is_no_run_folder_is_refused(folder: Path) -> None:
    for path, why in (
        (folder / "frames", "events.jsonl is not there"),
        (folder / "summary.json", "events.jsonl is not there"),
        (folder / "nowhere", "events.jsonl is not there"),
    ):
        with pytest.raises(UserError) as caught:
            read_run(path)
        assert str(caught.value) == (
            f"{path}: error: '{path}' is no run folder: {why} [no-run]\n  hint: name one of `runs/`"
        )
    (folder / "events.jsonl").write_text('{"format":"vencejo.ev')
    with pytest.raises(UserError, match="is no run folder: the last line of"):
        read_run(folder)
    (folder / "events.jsonl").unlink()
    (folder / "events.jsonl").mkdir()
    with pytest.raises(UserError, match="this file cannot be read: Is a directory"):
        read_run(folder)


def changed(folder: Path, name: str, before: str, after: str) -> str:
    """The error about a run folder after a change in the text of a file."""
    text = (folder / name).read_text()
    assert before in text
    (folder / name).write_text(text.replace(before, after, 1))
    with pytest.raises(UserError) as caught:
        read_run(folder)
    (folder / name).write_text(text)
    return str(caught.value).removeprefix(f"{folder}/")


def test_another_format_or_version_is_refused(folder: Path) -> None:
    assert changed(folder, "events.jsonl", '"version":1', '"version":2') == (
        "events.jsonl:1:1: error: this is version 2 of the format 'vencejo.events'; known is 1 "
        "[unknown-run-format]\n  hint: read it with the release of vencejo that flew it"
    )
    assert changed(folder, "frames.jsonl", '"version":1', '"version":9').startswith(
        "frames.jsonl:1:1: error: this is version 9 of the format 'vencejo.frames'; known is 1"
    )
    other = "events.jsonl:1:1: error: the first line does not say that this is 'vencejo.events'"
    for text in ('"format":"mcap"', '"size":1'):
        assert changed(folder, "events.jsonl", '"format":"vencejo.events"', text).startswith(other)
    assert changed(folder, "events.jsonl", "{", "[").startswith(other)
    assert changed(folder, "telemetry.csv", "t,vehicle,x", "time,vehicle,x").startswith(
        "telemetry.csv:1:1: error: its columns are not t,vehicle,x,y,z,"
    )


def test_a_damaged_line_is_told_with_its_place(folder: Path) -> None:
    assert changed(folder, "events.jsonl", '"world":', '"wordl":') == (
        "events.jsonl:1:1: error: 'world' is missing in this line [damaged-run]\n"
        "  hint: the file was changed after the flight; take it from a copy, or fly again"
    )
    assert changed(folder, "events.jsonl", '{"seq":2', '{"seq":2,,').startswith(
        "events.jsonl:4:10: error: this line cannot be read: "
    )
    assert changed(folder, "events.jsonl", '{"seq":1', '{"sqe":1').startswith(
        "events.jsonl:3:1: error: 'seq' is missing in this line"
    )
    assert changed(folder, "events.jsonl", "\n{", "\n3\n{").startswith(
        "events.jsonl:2:1: error: this line cannot be read: it is no object"
    )
    for after in ("0.050,x,drone,", "0.050,", '"0.050,drone,'):
        assert changed(folder, "telemetry.csv", "0.050,drone,", after).startswith(
            "telemetry.csv:3:1: error: this line cannot be read: "
        )
    assert "cannot be read: it has 26 columns, not 27 [damaged-run]" in (
        changed(folder, "telemetry.csv", "0.050,drone,", "0.050,")
    )
    assert changed(folder, "frames.jsonl", '"intrinsics":', '"lens":').startswith(
        "frames.jsonl:2:1: error: 'intrinsics' is missing in this line"
    )
    assert changed(folder, "summary.json", '"outcome":', '"out":').startswith(
        "summary.json:1:1: error: 'outcome' is missing"
    )


# -- property: what the recorder writes is what the reader gives ------------------------------

WORDS = st.text(st.characters(exclude_categories=("Cc", "Cs", "Zl", "Zp")), max_size=8)
NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,5}", fullmatch=True)
NUMBERS = st.floats(-1e4, 1e4)
SHARES = st.floats(0, 1)
POINTS = st.builds(Point, NUMBERS, NUMBERS, NUMBERS)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**9), 10**9) | NUMBERS | WORDS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
    max_leaves=4,
)
MAPS = st.dictionaries(NAMES, JSON, max_size=3)
# No field of a record is called as the fields that every line has.
RECORDS = st.lists(
    st.tuples(NAMES, MAPS.map(lambda fields: {f"f_{k}": v for k, v in fields.items()})), max_size=3
)
ATTITUDES = st.builds(
    lambda yaw, pitch: product(yaw_quaternion(yaw), about_y(pitch)),
    st.floats(-3.1, 3.1),
    st.floats(-1.5, 1.5),
)
OBSERVATIONS = st.builds(
    Observation,
    events=st.just(()),
    time=st.integers(0, 10**6).map(lambda period: period / 40),
    position=POINTS,
    velocity=POINTS,
    attitude=ATTITUDES,
    yaw=st.floats(-3.1, 3.1),
    rates=POINTS,
    battery=SHARES,
    armed=st.booleans(),
    flying=st.booleans(),
    mode=WORDS,
    home=POINTS,
)
TURNS = st.floats(-9, 9)
SETPOINTS = (
    st.builds(Position, POINTS, st.none() | POINTS, st.none() | TURNS, st.none() | TURNS)
    | st.builds(Velocity, NUMBERS, NUMBERS, NUMBERS, st.sampled_from(["world", "heading"]), TURNS)
    | st.builds(Attitude, *[TURNS] * 3, st.none() | SHARES, TURNS, st.sampled_from(["si", "share"]))
    | st.just(Hold())
)
STATES = st.lists(NAMES, max_size=2).map(tuple)
HASHES = st.from_regex(r"[0-9a-f]{64}", fullmatch=True)
MISSIONS = st.builds(MissionFacts, NAMES, HASHES, MAPS, st.dictionaries(WORDS, HASHES, max_size=2))
VEHICLES = st.just([ALONE]) | st.lists(NAMES | st.just(ALONE), min_size=1, max_size=3, unique=True)
LENSES = st.builds(
    Intrinsics, *[st.integers(1, 999)] * 2, *[NUMBERS] * 4, st.lists(NUMBERS, max_size=5).map(tuple)
)

OWN = st.dictionaries(st.sampled_from(["noise", "cameras", "wind"]), NUMBERS | MAPS, max_size=2)
LIMITS = st.builds(Limits, max_speed=st.none() | st.floats(0.1, 9))
VALUES = st.dictionaries(NAMES, NUMBERS | WORDS | POINTS | st.lists(POINTS, max_size=2), max_size=2)


@st.composite
def headers(draw: st.DrawFn) -> Header:
    missions = {vehicle: draw(MISSIONS) for vehicle in draw(VEHICLES)}
    words = [draw(WORDS) for _ in range(4)]
    known = draw(st.none() | st.builds(dict, seed=st.integers(), own=OWN, limits=LIMITS))
    flown = {name: MissionSettings(draw(WORDS), draw(VALUES)) for name in missions}
    files = draw(st.dictionaries(WORDS, HASHES, max_size=2))
    settings = RunSettings(flown, draw(WORDS), files, draw(WORDS), **known) if known else None
    return Header(missions, words[0], draw(HASHES), draw(st.integers()), *words[1:], settings)


def pilot_of(
    vehicle: str,
    seen: Observation,
    records: list[Record],
    states: list[str],
    told: tuple[Setpoint | None, str] = (None, ""),
) -> Pilot:
    """As much of a pilot as a recorder looks at."""
    return cast(
        Pilot,
        SimpleNamespace(
            vehicle=SimpleNamespace(name=vehicle),
            channel=SimpleNamespace(world=seen, commanded=told[0]),
            manoeuvre=told[1],
            instance=SimpleNamespace(records=records, paths=lambda: states),
        ),
    )


@given(headers(), st.data())
@settings(max_examples=30, deadline=None)
def test_what_is_written_is_what_is_read(header: Header, data: st.DataObject) -> None:
    names = list(header.missions)
    events: list[LogEntry] = []
    telemetry: dict[str, list[Sample]] = {}
    states: dict[str, tuple[str, ...]] = {}
    with TemporaryDirectory() as place, closing(Recorder(Path(place))) as recorder:
        folder = recorder.folder
        recorder.begin(header)
        for _ in range(data.draw(st.integers(0, 8))):
            name, seen = data.draw(st.sampled_from(names)), data.draw(OBSERVATIONS)
            records, now = data.draw(RECORDS), data.draw(STATES)
            told = data.draw(st.none() | SETPOINTS), data.draw(st.sampled_from(["", "takeoff"]))
            recorder.take(pilot_of(name, seen, list(records), list(now), told))
            for kind, fields in records:
                events.append(LogEntry(len(events), seen.time, name, kind, fields))
                states[name] = now
            row = sample_of(seen, *told, states.get(name, ()))
            telemetry.setdefault(name, []).append(row)
        recorder.close()
        run = read_run(folder)
        assert run == Run(
            folder=folder,
            header=header,
            events=tuple(events),
            telemetry={name: tuple(samples) for name, samples in telemetry.items()},
            frames=(),
            pictures=(),
            readings=(),
            summary=None,
            missing=("summary.json is not there",),
        )


FLOWN = st.builds(
    Flown,
    outcome=NAMES,
    reason=WORDS,
    output=MAPS,
    mission_time=st.integers(0, 10**6).map(lambda period: period / 40),
    distance=st.integers(0, 10**6).map(lambda centimetres: centimetres / 100),
    max_altitude=st.integers(0, 10**5).map(lambda centimetres: centimetres / 100),
    battery=st.integers(0, 10**4).map(lambda share: share / 10**4),
)


@given(headers(), st.data())
@settings(max_examples=60, deadline=None)
def test_a_summary_comes_back(header: Header, data: st.DataObject) -> None:
    summary = Summary(
        header=header,
        vehicles={vehicle: data.draw(FLOWN) for vehicle in header.missions},
        wall_time=data.draw(st.integers(0, 10**6)) / 10**4,
        interrupted=data.draw(st.booleans()),
        versions=data.draw(st.dictionaries(WORDS, WORDS, max_size=2)),
    )
    with TemporaryDirectory() as place:
        recorder = Recorder(Path(place))
        recorder.begin(header)
        recorder.close()
        recorder.write_summary(summary)
        run = read_run(place)
    assert (run.summary, run.missing) == (summary, ())


@given(st.data())
@settings(max_examples=30, deadline=None)
def test_frames_come_back(data: st.DataObject) -> None:
    image = np.zeros((2, 2, 3), np.uint8)
    lenses = data.draw(st.lists(LENSES, min_size=1, max_size=2))
    with TemporaryDirectory() as place, closing(Recorder(Path(place))) as recorder:
        folder = recorder.folder
        recorder.begin(Header({}, "", "", 0, "", "", ""))
        written = []
        for number in range(data.draw(st.integers(1, 6))):
            camera, lens = data.draw(NAMES), data.draw(st.sampled_from(lenses))
            pose = data.draw(POINTS), data.draw(ATTITUDES)
            frame = Frame(image, number, number / 20, lens, *pose)
            pilot = pilot_of(ALONE, cast(Observation, None), [], [])
            recorder.follow(pilot)
            pilot.channel.on_frame(camera, frame)
            written.append((ALONE, camera, number, number / 20, *pose, lens))
        recorder.close()
        read = [
            (f.vehicle, f.camera, f.sequence, f.time, f.position, f.attitude, f.intrinsics)
            for f in read_run(folder).frames
        ]
    assert read == written
