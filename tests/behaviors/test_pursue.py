"""pursue: a cat that finds a coloured drone and stays near it."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, hypot, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest

from behaviors.pursue import Pursued
from hal.scene.arrays import Pixels
from hal.vehicle import PERIOD, Position
from tests.behaviors.flying import Solo
from tests.behaviors.seen_quadrotor import SIZE, at, quadrotor_at
from tests.behaviors.sighted import Look, sighted
from vencejo.geometry import Point, Pose, bearing, distance, wrap

TARGET = {"target": {"color": "red", "size": SIZE}}
Where = Callable[[float], Pose | None]


def cat(look: Look, **values: Any) -> Solo:
    return Solo("pursue", {**TARGET, **values}, vehicle=sighted(look, 3.0))


def published(solo: Solo) -> Pursued:
    found = solo.activity.published
    assert isinstance(found, Pursued)
    return found


def place(solo: Solo) -> Point:
    return solo.vehicle.observe().position


def events(solo: Solo) -> list[str]:
    return [name for name, _ in solo.events]


def test_it_finds_a_drone_behind_it_and_comes_to_the_distance() -> None:
    mouse = Point(-6.0, 1.0, 3.6)
    solo = cat(quadrotor_at(lambda _: at(mouse)))
    solo.run(14.0)
    assert events(solo) == ["target.found"]
    assert distance(place(solo), mouse) == pytest.approx(3.0, abs=0.3)
    assert place(solo).z == pytest.approx(mouse.z, abs=0.1)
    told = published(solo)
    assert told.visible and told.losses == 0
    assert told.distance == pytest.approx(3.0, abs=0.1)
    assert abs(told.bearing) < 0.05 and abs(told.elevation) < 0.05
    assert told.position == pytest.approx(mouse.plus((0, 0, 0.07)), abs=0.3)
    assert abs(wrap(bearing(place(solo), mouse) - solo.vehicle.observe().yaw)) < 0.05


def circling(time: float) -> Pose:
    """1 m/s on a circle of 4 m, the nose ahead."""
    angle = time / 4
    return at(Point(5 + 4 * cos(angle), 4 * sin(angle), 3 + 0.3 * sin(angle)), angle + pi / 2)


def test_it_stays_with_one_that_flies_round() -> None:
    solo = cat(quadrotor_at(circling), distance=4.0)
    solo.run(8.0)
    errors = []
    for _ in range(round(12 / PERIOD)):
        solo.step()
        mouse, _ = circling(solo.time)
        errors.append(distance(place(solo), mouse) - 4.0)
    assert sqrt(sum(e * e for e in errors) / len(errors)) < 0.4
    assert max(map(abs, errors)) < 0.9
    velocity = published(solo).velocity
    assert hypot(velocity["x"], velocity["y"]) == pytest.approx(1.0, abs=0.3)


def test_it_follows_one_that_is_hidden_and_sees_it_again() -> None:
    hidden = (9.0, 10.5)

    def where(time: float) -> Pose | None:
        return None if hidden[0] <= time < hidden[1] else circling(time)

    solo = cat(quadrotor_at(where))
    while solo.time < hidden[1] - 0.1:
        solo.step()
    told, (mouse, _) = published(solo), circling(solo.time)
    assert not told.visible and told.losses == 1
    assert distance(told.position, mouse) < 0.7, "it has gone on as it was seen"
    while solo.time < hidden[1] + 0.2:
        solo.step()
    assert published(solo).visible
    assert events(solo) == ["target.found", "target.lost", "target.found"]
    assert solo.events[-1][1]["after"] == pytest.approx(1.5, abs=0.1)


def test_it_backs_away_and_never_closes_in_by_itself() -> None:
    """The mouse flies at it at 1 m/s."""

    def where(time: float) -> Pose:
        return at(Point(max(-4.0, 9.0 - max(0.0, time - 6.0)), 0.0, 3.0), pi)

    solo = cat(quadrotor_at(where), nearest=2.0)
    near = []
    for _ in range(round(20 / PERIOD)):
        solo.step()
        near.append(distance(place(solo), where(solo.time)[0]))
    assert min(near[-200:]) > 2.0 and place(solo).x < -6.0


def test_it_looks_where_it_vanished_then_all_about_and_gives_up() -> None:
    def where(time: float) -> Pose | None:
        return at(Point(5.0, 0.0, 3.0)) if time < 8 else None

    solo = cat(quadrotor_at(where), patience=25.0, reach=3.0)
    yaws, places = [], []
    while solo.step() and solo.outcome is None:
        if solo.time > 10.5:
            yaws.append(solo.vehicle.observe().yaw)
            places.append(place(solo))
    assert solo.word == "lost" and events(solo) == ["target.found", "target.lost"]
    assert solo.time == pytest.approx(8 + 25, abs=0.3)
    assert all(abs(yaw) < 2.0 for yaw in yaws[:60]), "at first about where it was"
    assert max(yaws) > 2.8 and min(yaws) < -2.8
    assert max(each.z for each in places) > 4.2, "it looked from higher up"
    assert all(hypot(each.x - 2, each.y) < 3.6 for each in places)


def test_one_that_never_comes_is_given_up() -> None:
    solo = cat(quadrotor_at(lambda _: None), patience=5.0)
    solo.run(10.0)
    assert solo.word == "lost" and solo.time < 10.0 and solo.events == []


def test_a_height_above_and_the_least_height_are_kept() -> None:
    solo = cat(quadrotor_at(lambda _: at(Point(5.0, 0.0, 3.0))), above=1.0)
    solo.run(9.0)
    assert place(solo).z == pytest.approx(4.0, abs=0.15)
    assert distance(place(solo), (5.0, 0.0, 3.0)) == pytest.approx(3.0, abs=0.3)
    low = cat(quadrotor_at(lambda _: at(Point(8.0, 0.0, 1.0))), least_height=2.5)
    low.run(9.0)
    assert place(low).z == pytest.approx(2.5, abs=0.05)
    assert published(low).visible and published(low).losses == 0, "far enough to see it below"


RED = (30, 30, 220)


def nasty(kind: str) -> Look:
    draw = np.random.default_rng(1)
    flat = {"black": 0, "white": 255, "red": RED}

    def look(pose: Pose, time: float) -> Pixels:
        if kind in flat:
            return np.full((240, 320, 3), flat[kind], np.uint8)
        if kind == "small":
            image = np.zeros((16, 16, 3), np.uint8)
            image[6:9, 3:13] = RED
            return image
        if kind == "noise":
            return draw.integers(0, 256, (240, 320, 3), np.uint8)
        image = np.full((240, 320, 3), (60, 130, 85), np.uint8)
        left, top, size = (int(each) for each in draw.integers(0, 200, 3))
        image[top : top + size // 6, left : left + size] = RED
        return np.ascontiguousarray(np.rot90(image)) if kind == "rotated" else image

    return look


@pytest.mark.parametrize("kind", ["black", "white", "red", "small", "noise", "jumping", "rotated"])
def test_whatever_it_sees_it_never_jumps(kind: str) -> None:
    solo = cat(nasty(kind), patience=100.0)
    velocity, yaw = Point(0.0, 0.0, 0.0), solo.vehicle.observe().yaw
    for _ in range(round(6 / PERIOD)):
        told = solo.step()
        assert solo.outcome is None and isinstance(told, Position)
        assert told.velocity is not None and told.yaw is not None
        assert distance(told.velocity, velocity) <= 4.0 * PERIOD
        assert abs(wrap(told.yaw - yaw)) <= 1.76 * PERIOD
        velocity, yaw = told.velocity, told.yaw


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("red", "a target has a colour and a size"),
        ({"color": "red"}, "a target has a colour and a size"),
        ({"color": "rod", "size": 0.5}, "no colour 'rod'"),
        ({"color": "red", "size": "wide"}, "a target of the size 'wide'"),
        ({"color": "red", "size": 0.0}, "a target of the size 0.0"),
    ],
)
def test_what_is_no_target_is_refused(target: Any, message: str) -> None:
    solo = Solo("pursue", {"target": target}, vehicle=sighted(nasty("black")))
    solo.step()
    assert solo.outcome is not None and solo.word == "failed"
    assert message in str(solo.outcome.fields["reason"])
