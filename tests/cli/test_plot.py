"""The picture of a run: its lanes, scales and what can be seen in it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cli.plot import draw
from cli.plot.axes import Scale, axes_from_above
from cli.plot.canvas import Box, Canvas, text_width
from cli.plot.flight import flights_of, world_of
from cli.plot.lanes import Bar, lanes_of
from cli.vehicle_colors import vehicle_colors
from runner import read_run
from runner.telemetry import Sample
from tests.cli.run_cli import run_cli
from vencejo.errors import UserError
from vencejo.geometry import Point

RED = (40, 39, 214)
"""Blue, green, red."""
CRASH = """\
mission: crash
world: yard
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: go}}
  go: {do: move, with: {forward: 2 m/s}, after: {8 s: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""


def sample(time: float, *states: str) -> Sample:
    here = Point(time, 0.0, 1.0)
    return Sample(time, here, Point(1.0, 0.0, 0.0), 0.0, 0.0, 0.0, 1.0, "flying", states)


def test_a_region_keeps_its_lane() -> None:
    samples = [
        sample(0.0, "up"),
        sample(1.0, "work.fly.a", "work.watch.idle"),
        sample(2.0, "work.fly.a", "work.watch.busy"),
        sample(3.0, "work.fly.b", "work.watch.busy"),
        sample(4.0, "down"),
        sample(5.0, "down"),
    ]
    assert lanes_of(samples) == [
        [
            Bar("up", 0.0, 1.0),
            Bar("work.fly.a", 1.0, 3.0),
            Bar("work.fly.b", 3.0, 4.0),
            Bar("down", 4.0, 5.025),
        ],
        [Bar("work.watch.idle", 1.0, 2.0), Bar("work.watch.busy", 2.0, 4.0)],
    ]


STATES = st.sets(st.sampled_from(["a", "b.c", "b.d", "e.f.g", "e.f.h", "e.i"]), min_size=1)


@given(st.lists(STATES, min_size=1, max_size=20))
def test_lanes_hold_every_state_of_every_moment(configurations: Sequence[set[str]]) -> None:
    samples = [sample(float(n), *sorted(states)) for n, states in enumerate(configurations)]
    lanes = lanes_of(samples)
    assert len(lanes) == max(len(states) for states in configurations)
    for lane in lanes:
        assert all(a.end <= b.begin for a, b in pairwise(lane))
    for moment in samples:
        at = {b.state for lane in lanes for b in lane if b.begin <= moment.time < b.end}
        assert at == set(moment.states)


@given(
    low=st.floats(-1e5, 1e5),
    span=st.floats(1e-3, 1e5),
    spacing=st.floats(20, 100),
    pixels=st.floats(200, 600),
)
def test_ticks_are_round_and_within(low: float, span: float, spacing: float, pixels: float) -> None:
    scale = Scale(low, low + span, 10.0, 10.0 + pixels)
    ticks = scale.ticks(spacing)
    places = [scale.pixel(tick) for tick in ticks]
    assert all(9.99 <= place <= 10.01 + pixels for place in places)
    apart = np.diff(places)
    assert (apart >= spacing * 0.999).all() and (apart <= spacing * 2.501).all()


@given(st.lists(st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)), min_size=1))
def test_a_map_shows_all_places_and_is_not_stretched(places: list[tuple[float, float]]) -> None:
    axes = axes_from_above(Box(50, 20, 450, 220), places, 0.1, 8.0)
    for place in places:
        assert axes.box.holds(axes.place(*place))
    east, north = axes.place(1.0, 0.0), axes.place(0.0, 1.0)
    origin = axes.place(0.0, 0.0)
    assert east[0] - origin[0] == pytest.approx(origin[1] - north[1])
    assert axes.x.high - axes.x.low >= 8.0


def image_of(canvas: Canvas) -> Any:
    return cv2.imdecode(np.frombuffer(canvas.png(), np.uint8), cv2.IMREAD_COLOR)


def test_dashes_leave_gaps_and_a_box_can_be_cleared() -> None:
    canvas = Canvas(100, 40)
    canvas.dashes([(0, 10), (50, 10), (99, 10)], (0, 0, 0), 2)
    row = image_of(canvas)[10, :, 0] < 128
    assert row[:5].all() and not row[5:8].any() and row[9:13].all()
    assert 45 <= row.sum() <= 65
    canvas.rectangle(Box(0, 0, 100, 40), (0, 0, 255))
    canvas.erase_outside(Box(20, 10, 60, 30))
    image = image_of(canvas)
    white = (image > 250).all(axis=2)
    assert tuple(image[20, 40]) == (255, 0, 0), "blue, green, red"
    assert white[5].all() and white[35].all() and white[20, :19].all() and white[20, 62:].all()


@pytest.fixture
def crashed(tmp_path: Path) -> Path:
    (tmp_path / "crash.yaml").write_text(CRASH)
    assert run_cli("run", "crash.yaml", "--runs-dir", "runs", "--no-picture").code == 0
    (folder,) = (tmp_path / "runs").iterdir()
    return folder


def test_a_collision_is_seen_on_the_map_and_over_time(crashed: Path) -> None:
    assert not (crashed / "flight.png").exists()
    run = read_run(crashed)
    (flight,) = flights_of(run)
    ((hit, thing),) = flight.collisions
    assert thing == "wall" and hit.position.y == pytest.approx(11.6, abs=0.1)
    image = cv2.imread(str(draw(crashed)))
    # A thin line's pixels are between red and white: blue and green are alike in them.
    blue, green, red_part = np.moveaxis(image.astype(int), 2, 0)
    red = (red_part - green > 60) & (abs(green - blue) < 20)
    assert red[62:592, 58:588].sum() > 15, "a cross on the map"
    assert red[62:262, 652:].sum(axis=0).max() >= 190, "a line over the altitude"


def test_the_world_is_that_of_the_run(crashed: Path) -> None:
    run = read_run(crashed)
    world = world_of(run)
    assert world is not None and "wall" in {thing.name for thing in world.things}
    (crashed / "yard.yaml").write_text("world: yard\n")
    assert world_of(run) is None
    draw(crashed)


def test_a_legend_of_many_states_is_never_cut(tmp_path: Path) -> None:
    states = "".join(
        f"  a_state_with_a_long_name_{n}: {{after: {{50 ms: a_state_with_a_long_name_{n + 1}}}}}\n"
        for n in range(60)
    )
    text = f"mission: many\nstates:\n{states}  a_state_with_a_long_name_60: {{type: final}}\n"
    (tmp_path / "many.yaml").write_text(text)
    run_cli("run", "many.yaml", "--runs-dir", "runs", "--no-picture")
    (folder,) = (tmp_path / "runs").iterdir()
    tall = cv2.imread(str(draw(folder)))
    rows = -(-60 * (text_width("a_state_with_a_long_name_10") + 42) // 1206)
    assert tall.shape[0] >= 592 + 44 + 20 * rows
    dark = (tall < 128).all(axis=2)
    assert not dark[:, -4:].any() and not dark[-3:].any()
    assert dark[592 + 44 :].any(axis=1).sum() > 6 * rows


FLEET = """\
fleet: three
world: coloured.yaml
vehicles:
  cat: {mission: hop.yaml, color: magenta}
  mouse: {mission: hop.yaml}
  dog: {mission: hop.yaml, color: magenta}
"""
HOP = """\
mission: hop
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
COLOURED = "world: coloured\nstart: [{at: [0, 0]}, {at: [3, 0], color: green}, {at: [6, 0]}]\n"


def test_vehicles_are_drawn_in_the_colours_of_their_hulls(tmp_path: Path) -> None:
    for name, text in (("three", FLEET), ("hop", HOP), ("coloured", COLOURED)):
        (tmp_path / f"{name}.yaml").write_text(text)
    assert run_cli("run", "three.yaml", "--runs-dir", "runs").code == 0
    (folder,) = (tmp_path / "runs").iterdir()
    facts = read_run(folder).header.missions
    asked = {name: facts[name].color for name in facts}
    assert asked == {"cat": (210, 40, 200), "mouse": (30, 170, 50), "dog": (210, 40, 200)}
    legend = cv2.imread(str(folder / "flight.png"))[592:]
    for color in ((210, 40, 200), (30, 170, 50), (31, 119, 180)):
        pixels = (abs(legend.astype(int) - color[::-1]) < 8).all(axis=2)
        assert pixels.sum() > 100, "the second magenta one has a colour of its own"


def test_colours_can_be_seen_and_told_apart() -> None:
    spare = [(1, 100, 200), (200, 100, 1), (100, 200, 1)]
    hulls = {"a": (255, 255, 255), "b": (0, 0, 0), "c": (255, 250, 255), "d": None}
    found = vehicle_colors(hulls, spare)
    assert found["a"] == (180, 180, 180) and found["b"] == (45, 45, 45)
    assert found["c"] == spare[0] and found["d"] == spare[1]


FAR = """\
mission: far
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: go}}
  go: {do: goto, with: {to: [900000, 0, 1]}, on: {done: down, blocked: down}, after: {2 s: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""


@pytest.mark.parametrize("distance", ["3", "900000"])
def test_set_points_are_drawn_beside_what_was_flown(distance: str, tmp_path: Path) -> None:
    (tmp_path / "far.yaml").write_text(FAR.replace("900000", distance))
    assert run_cli("run", "far.yaml", "--runs-dir", "runs").code == 0
    (folder,) = (tmp_path / "runs").iterdir()
    image = cv2.imread(str(folder / "flight.png"))
    gray = (abs(image.astype(int) - 90) < 15).all(axis=2)
    above, speed, battery = gray[64:590, 60:586], gray[294:410, 654:1260], gray[444:500, 654:1260]
    assert above.any() and speed.sum() > 5
    assert not battery.any(), "nobody commands a charge"


def test_what_is_no_run_cannot_be_drawn(crashed: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="is no run folder"):
        draw(tmp_path)
    columns, _, _ = (crashed / "telemetry.csv").read_text().partition("\n")
    (crashed / "telemetry.csv").write_text(columns + "\n")
    with pytest.raises(UserError, match="nothing was flown"):
        draw(crashed)
