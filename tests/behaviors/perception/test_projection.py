"""Pixels to the world and back."""

from __future__ import annotations

from math import atan2, degrees, hypot, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.perception.blobs import blobs
from behaviors.perception.color import mask, read_color
from behaviors.perception.projection import (
    bearing,
    directions,
    ground_point,
    ground_points,
    is_inside,
    pixels_of,
    tilt_of,
)
from hal.sim.sensors.camera_spec import CameraSpec
from hal.vehicle import Frame, Intrinsics
from tests.behaviors.perception.frames import LENSES, WIDE, frame_of, front, seen_from, ventral
from tests.hal.scenes import thing_of, world_of
from vencejo.geometry import Point, Quaternion, about_x, about_y, product, yaw_quaternion
from worlds.things import Sphere

BLANK = np.zeros((240, 320, 3), np.uint8)
BENT = LENSES["distorted"].intrinsics
tilts = st.floats(-0.5, 0.5)


def blank(at: tuple[float, float, float], attitude: Quaternion, lens: Intrinsics = WIDE) -> Frame:
    return frame_of(BLANK, (Point(*at), attitude), lens)


@settings(deadline=None)
@given(tilts, tilts, st.floats(-pi, pi), st.floats(0, 319), st.floats(0, 239), st.booleans())
def test_a_pixel_comes_back_from_its_ray(
    tilt: float, roll: float, yaw: float, x: float, y: float, bent: bool
) -> None:
    frame = blank((1, -2, 5), ventral(tilt, roll, yaw), BENT if bent else WIDE)
    [ray] = directions(frame, [(x, y)])
    assert np.linalg.norm(ray) == pytest.approx(1)
    [pixel] = pixels_of(frame, [np.array(frame.position) + 7 * ray])
    assert pixel == pytest.approx((x, y), abs=1e-4)


@settings(deadline=None)
@given(tilts, tilts, st.floats(-pi, pi), st.floats(-2, 2), st.floats(-2, 2))
def test_the_ground_below_a_tilted_vehicle(
    tilt: float, roll: float, yaw: float, x: float, y: float
) -> None:
    frame = blank((3, 4, 6), ventral(tilt, roll, yaw))
    [pixel] = pixels_of(frame, [(3 + x, 4 + y, 1.0)])
    found = ground_points(frame, [pixel], height=1.0)
    assert found[0] == pytest.approx((3 + x, 4 + y, 1.0), abs=1e-6)


def test_level_the_middle_is_right_below_and_up_in_the_picture_is_ahead() -> None:
    frame = blank((3, 4, 6), ventral(yaw=pi / 2))
    assert ground_point(frame, (159.5, 119.5)) == pytest.approx((3, 4, 0))
    ahead = ground_point(frame, (159.5, 19.5))
    assert ahead is not None
    assert ahead.x == pytest.approx(3)
    assert ahead.y > 5


def test_what_does_not_come_down_has_no_ground_and_what_is_behind_no_pixel() -> None:
    frame = blank((0, 0, 2), front())
    assert ground_point(frame, (160, 60)) is None
    assert ground_point(frame, (160, 119.5)) is None
    below = ground_points(frame, [(160, 60), (160, 200)])
    assert np.isnan(below[0]).all()
    assert np.isfinite(below[1]).all()
    assert np.isnan(pixels_of(frame, [(-1, 0, 2)])).all()
    assert len(ground_points(frame, np.empty((0, 2)))) == 0
    assert len(pixels_of(blank((0, 0, 2), front(), BENT), np.empty((0, 3)))) == 0


def test_bearings_are_counter_clockwise_from_east_and_up() -> None:
    frame = blank((0, 0, 2), front(yaw=0.5))
    azimuth, elevation = bearing(frame, (159.5, 119.5))
    assert (azimuth, elevation) == pytest.approx((0.5, 0))
    left, above = bearing(frame, (100, 60))
    assert left > 0.5
    assert above > 0


def test_inside_an_image_with_a_margin() -> None:
    frame = blank((0, 0, 2), ventral())
    pixels = np.array([(0.0, 0.0), (319.0, 239.0), (320.0, 0.0), (np.nan, 5.0), (12.0, 12.0)])
    assert is_inside(frame, pixels).tolist() == [True, True, False, False, True]
    assert is_inside(frame, pixels, 10).tolist() == [False, False, False, False, True]


@settings(deadline=None)
@given(tilts, tilts, st.floats(-pi, pi))
def test_the_tilt_of_a_body(tilt: float, roll: float, yaw: float) -> None:
    turned = product(product(yaw_quaternion(yaw), about_y(tilt)), about_x(roll))
    expected = np.arccos(np.clip(np.cos(tilt) * np.cos(roll), -1, 1))
    assert tilt_of(turned) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", LENSES)
@pytest.mark.parametrize("tilt", [0.0, 0.2, -0.3])
def test_a_rendered_ball_is_where_it_lies(name: str, tilt: float) -> None:
    ball = Point(1.0, 0.6, 0.1)
    world = world_of(thing_of("ball", Sphere(0.1), ball, color=(220, 30, 30)))
    frame = seen_from(world, Point(0.4, 0.2, 4.0), ventral(tilt, -tilt / 2, 0.7), LENSES[name])
    [found, *_] = blobs(mask(frame.image, read_color("red")), min_area=5)
    at = ground_point(frame, (found.x, found.y), height=0.1)
    assert at is not None
    assert hypot(at.x - ball.x, at.y - ball.y) < 0.03


@pytest.mark.parametrize("name", LENSES)
def test_a_rendered_ball_has_its_bearing(name: str) -> None:
    ball, eye = Point(3.0, 0.8, 2.4), Point(0.0, 0.0, 2.0)
    world = world_of(thing_of("ball", Sphere(0.15), ball, color=(220, 30, 30)))
    frame = seen_from(world, eye, front(0.1, 0.15, 0.2), LENSES[name])
    [found, *_] = blobs(mask(frame.image, read_color("red")), min_area=5)
    azimuth, elevation = bearing(frame, (found.x, found.y))
    assert azimuth == pytest.approx(atan2(0.8, 3.0), abs=radians(0.3))
    assert elevation == pytest.approx(atan2(0.4, hypot(0.8, 3.0)), abs=radians(0.3))


def test_the_frames_of_these_tests_look_where_cameras_of_vehicles_do() -> None:
    frame = blank((0, 0, 2), front())
    assert frame.attitude == CameraSpec().attitude
    assert degrees(bearing(frame, (159.5, 119.5))[1]) == pytest.approx(0)
