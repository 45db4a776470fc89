"""The map of the ground: what a camera sees lies where it is, however the camera is turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from behaviors.perception.ground_map import GroundMap
from hal.vehicle import Intrinsics
from tests.behaviors.perception.roads import DOWN, LENS, drawn, frame_at, mapped
from vencejo.geometry import Point, about_x, about_y, product, yaw_quaternion

ROAD = [[(-4.0, -1.0), (4.0, 2.0)]]


def edges(ground: GroundMap, x: float) -> tuple[float, float]:
    """The lowest and highest y of the road at an x."""
    ys = np.arange(-4, 4, 0.01)
    share, seen = ground.sample(np.stack([np.full_like(ys, x), ys], 1))
    road = ys[(share > 0.5) & seen]
    return float(road.min()), float(road.max())


def test_a_road_lies_where_it_is() -> None:
    low, high = edges(mapped(ROAD), 1.0)
    half = 0.4 / np.cos(np.arctan(3 / 8))
    middle = -1 + 5 * 3 / 8
    assert (low, high) == pytest.approx((middle - half, middle + half), abs=0.03)


@given(
    st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-3.1, 3.1),
    st.floats(-1, 1), st.floats(-1, 1), st.floats(4, 9),
)  # fmt: skip
def test_it_lies_there_however_the_camera_is_held(
    roll: float, pitch: float, yaw: float, x: float, y: float, z: float
) -> None:
    attitude = product(yaw_quaternion(yaw), product(about_y(pitch), product(about_x(roll), DOWN)))
    frame = frame_at(Point(x, y, z), attitude)
    ground = GroundMap(0.04)
    assert ground.add(drawn(frame, ROAD, 0.8), frame)
    low, high = edges(ground, x * 0.5)
    middle = -1 + (x * 0.5 + 4) * 3 / 8
    assert (low + high) / 2 == pytest.approx(middle, abs=0.05)


def test_a_lens_bends_nothing_on_the_map() -> None:
    lens = replace(LENS, distortion=(-0.2, 0.04, 0.001, -0.001, 0.0))
    frame = frame_at(lens=lens)
    # A line of short pieces is bent by the lens as a road is.
    pieces = [(-4 + 0.1 * k, -1 + 0.0375 * k) for k in range(81)]
    ground = GroundMap(0.04)
    assert ground.add(drawn(frame, [pieces], 0.8), frame)
    for x in (-3.0, 0.0, 3.0):
        low, high = edges(ground, x)
        assert (low + high) / 2 == pytest.approx(-1 + (x + 4) * 3 / 8, abs=0.05)


def test_what_has_left_the_picture_is_known_and_what_was_never_seen_is_not() -> None:
    ground = GroundMap(0.04)
    for x in np.arange(0, 3, 0.5):
        frame = frame_at(Point(float(x), 0.0, 3.0), lens=Intrinsics.from_field_of_view(320, 240, 1))
        ground.add(drawn(frame, ROAD, 0.8), frame)
    share, seen = ground.sample([(-1.0, 0.1), (0.5, -1.2), (-4.0, 0.0), (9.0, 9.0)])
    assert list(seen) == [True, True, False, False]
    assert list(share[:2] > 0.5) == [True, False]


def test_one_wrong_look_changes_nothing() -> None:
    frame = frame_at()
    ground = mapped(ROAD)
    for _ in range(5):
        ground.add(drawn(frame, ROAD, 0.8), frame)
    before = edges(ground, 0.0)
    ground.add(np.zeros((480, 640), np.uint8), frame)
    assert edges(ground, 0.0) == pytest.approx(before, abs=0.05)


@pytest.mark.parametrize(
    "frame",
    [
        frame_at(attitude=product(about_y(-1.2), DOWN)),  # to the horizon
        frame_at(attitude=product(about_y(np.pi), DOWN)),  # up
        frame_at(Point(0.0, 0.0, -1.0)),  # below the ground
        frame_at(lens=Intrinsics.from_field_of_view(8, 8, 1.0)),  # hardly a picture
    ],
)
def test_frames_that_show_no_ground_are_left_out(frame: object) -> None:
    ground = GroundMap(0.04)
    assert not ground.add(np.full(frame.image.shape[:2], 255, np.uint8), frame)  # type: ignore[attr-defined,arg-type]
    assert not ground.sample([(0.0, 0.0)])[1].any()
