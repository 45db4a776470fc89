"""Every behaviour that looks through a camera, shown what no camera should: it neither fails nor
commands a jump.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from behaviors import Registry
from hal.scene.arrays import Pixels
from hal.sim.sensors.camera_spec import CameraSpec
from hal.vehicle import PERIOD, Observation, Position, Setpoint, Velocity
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import CAMERAS, shown, sighted
from tests.hal.scenes import ROAD, marker, thing_of, world_of
from vencejo.geometry import Point, Pose, wrap
from worlds.things import Sphere

AREA = [Point(-10.0, -10.0, 0.0), Point(10.0, -10.0, 0.0), Point(10.0, 10.0, 0.0)]
VALUES: Mapping[str, Mapping[str, Any]] = {
    "detect_tags": {"camera": "ventral"},
    "find_color": {"camera": "front", "color": "red"},
    "find_road": {"camera": "ventral"},
    "follow_road": {},
    "hover_over": {"target": "roundel"},
    "land_on": {"marker": {"id": 1, "size": 0.5}},
    "photo": {"camera": "ventral"},
    "pursue": {"target": {"color": "red", "size": 0.5}},
    "sweep_detect": {
        "area": AREA,
        "detect": ["people", {"color": {"color": "red", "size": 0.5}}, "fiducials"],
    },
    "track_object": {"target": {"color": "red", "size": 0.5}},
    "watch_traffic": {},
}
"""Parameters of the behaviours that look through a camera."""
LOOKING = sorted(
    name
    for name, info in Registry().items()
    if name != "survey"  # which looks once, for the size of the picture
    if any(p.names == "camera" for p in info.parameters.values())
    or any(word.startswith("camera") for word in info.requires)
)
SMALL = {name: CameraSpec(s.at, tilt=s.tilt, width=16, height=16) for name, s in CAMERAS.items()}
MOST_STEP, MOST_CHANGE, MOST_TURN = 5.0, 12.0, 3.5
"""Largest speed, m/s, acceleration, m/s², and turn rate, rad/s, of what is commanded."""


def plain(blue: int, green: int, red: int) -> Callable[[Pose, float], Pixels]:
    return lambda pose, time: np.full((240, 320, 3), (blue, green, red), np.uint8)


def noise(pose: Pose, time: float) -> Pixels:
    return np.random.default_rng(round(1000 * time)).integers(0, 256, (240, 320, 3), np.uint8)


def small(pose: Pose, time: float) -> Pixels:
    return noise(pose, time)[:16, :16]


SCENE = shown(
    world_of(
        marker(1, (1.0, 0.5, 0.001), 0.5),
        thing_of("ball", Sphere(0.25), (4.0, 0.3, 3.0), color=(220, 30, 30)),
        ground=ROAD,
    )
)
KINDS: Mapping[str, Callable[[Pose, float], Pixels]] = {
    "black": plain(0, 0, 0),
    "white": plain(255, 255, 255),
    "red": plain(30, 30, 220),
    "asphalt": plain(75, 70, 70),
    "noise": noise,
    "on its side": lambda pose, time: np.ascontiguousarray(np.rot90(SCENE(pose, time))),
    "on its head": lambda pose, time: np.ascontiguousarray(SCENE(pose, time)[::-1, ::-1]),
    "now and then": lambda pose, time: (
        SCENE(pose, time) if int(2 * time) % 2 else noise(pose, time)
    ),
}


def in_turns(pose: Pose, time: float) -> Pixels:
    return list(KINDS.values())[int(3 * time) % len(KINDS)](pose, time)


def test_all_that_look_are_tried() -> None:
    assert set(LOOKING) <= set(VALUES)


@pytest.mark.parametrize(
    "kind", ["in turns", "16 x 16", *(pytest.param(k, marks=pytest.mark.slow) for k in KINDS)]
)
@pytest.mark.parametrize("name", LOOKING)
def test_whatever_it_sees_it_does_not_fail_or_jump(name: str, kind: str) -> None:
    cameras = SMALL if kind == "16 x 16" else CAMERAS
    look = {"16 x 16": small, "in turns": in_turns, **KINDS}[kind]
    solo = Solo(name, VALUES[name], vehicle=sighted(look, cameras=cameras))
    asked = [_asked(solo.vehicle.observe(), None)]
    for _ in range(160):
        commanded = solo.step()
        asked.append(_asked(solo.vehicle.observe(), commanded))
        if solo.outcome is not None:
            break
    assert solo.outcome is None or solo.outcome.word != "failed", solo.outcome
    for (place, velocity, yaw), (next_place, next_velocity, next_yaw) in pairwise(asked):
        assert next_place.minus(place).norm() <= MOST_STEP * PERIOD
        assert next_velocity.minus(velocity).norm() <= MOST_CHANGE * PERIOD
        assert abs(wrap(next_yaw - yaw)) <= MOST_TURN * PERIOD


def _asked(seen: Observation, commanded: Setpoint | None) -> tuple[Point, Point, float]:
    """Place, velocity and yaw that are commanded; those that it has where none is."""
    if isinstance(commanded, Position):
        yaw = seen.yaw if commanded.yaw is None else commanded.yaw
        return Point(*commanded.xyz), Point(*(commanded.velocity or (0.0, 0.0, 0.0))), yaw
    if isinstance(commanded, Velocity):
        return seen.position, Point(*commanded[:3]), seen.yaw
    return seen.position, seen.velocity, seen.yaw
