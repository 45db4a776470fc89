"""Where markers are, from rendered frames with known truth."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, hypot, pi, radians, sqrt
from random import Random

import numpy as np
import pytest

from behaviors.perception.fiducials import FiducialDetector
from behaviors.perception.marker_pose import MarkerPose, Posture, marker_pose
from hal.raster.renderer import Raster
from hal.sim.sensors.camera_spec import CameraSpec
from hal.vehicle import Frame
from tests.behaviors.perception.markers import (
    above,
    corners_of,
    marker_of,
    photograph,
    pixels_of,
    small_turn,
)
from tests.hal.scenes import ROAD, look, world_of
from vencejo.geometry import Point, distance, product, wrap, yaw_quaternion
from worlds.figures import standing

ORIGIN = Point(0.0, 0.0, 0.0)
WIDE = CameraSpec(field_of_view=radians(75), noise=3.0)
"""The camera of the published figures."""
FINDER = FiducialDetector("4X4_50", ids=range(30))


def rms(errors: list[float]) -> float:
    return sqrt(sum(error * error for error in errors) / len(errors))


def measured(
    height: float, camera: CameraSpec, spread: float = 0.25, known: float | None = None
) -> list[MarkerPose]:
    """The poses of a 0.5 m marker in the origin as seen from a height, by a camera whose attitude
    is known to 0.3° and tilts by 3°.
    """
    raster = Raster(world_of(marker_of("4X4_50", 7, ORIGIN, 0.5), ground=ROAD), {}, False)
    draw, poses = Random(1), []
    for number in range(20):
        pose = above(draw, height, spread)
        frame = photograph(raster, pose, camera, number)
        frame = replace(frame, attitude=product(small_turn(draw, 0.3), frame.attitude))
        for found in FINDER.detect(frame.image).found:
            marker = marker_pose(frame, found.corners, 0.5, height=known)
            assert marker is not None
            poses.append(marker)
    assert len(poses) > 0.9 * 20
    return poses


@pytest.mark.parametrize(
    ("height", "level", "up"), [(2.0, 0.016, 0.015), (3.0, 0.022, 0.04), (5.0, 0.044, 0.13)]
)
def test_a_level_marker_is_as_near_as_the_published_figures(
    height: float, level: float, up: float
) -> None:
    poses = measured(height, WIDE, spread=0.2)
    assert rms([hypot(*pose.position[:2]) for pose in poses]) < level
    assert rms([pose.position.z for pose in poses]) < up
    assert rms([degrees(pose.heading) for pose in poses]) < 2.0
    assert all(pose.error < 0.6 for pose in poses)


def test_the_covariance_tells_the_error() -> None:
    for height in (2.0, 5.0):
        poses = measured(height, WIDE, spread=0.2)
        level = rms([hypot(*pose.position[:2]) for pose in poses])
        told = rms([sqrt(pose.covariance[0, 0] + pose.covariance[1, 1]) for pose in poses])
        assert 0.6 * level < told < 1.8 * level
        up = rms([pose.position.z for pose in poses])
        assert 0.5 * up < rms([sqrt(pose.covariance[2, 2]) for pose in poses]) < 3 * up


def test_a_known_height_is_kept() -> None:
    poses = measured(5.0, WIDE, spread=0.2, known=0.0)
    assert all(pose.position.z == pytest.approx(0.0, abs=1e-12) for pose in poses)
    assert rms([hypot(*pose.position[:2]) for pose in poses]) < 0.044


def test_a_bent_lens_is_straightened() -> None:
    bent = CameraSpec(noise=3.0, distortion=(-0.28, 0.09, 0.001, -0.0008, 0.0))
    poses = measured(2.0, bent, spread=0.2)
    assert rms([hypot(*pose.position[:2]) for pose in poses]) < 0.02
    assert rms([pose.position.z for pose in poses]) < 0.02


@pytest.mark.parametrize("heading", [0.0, 2.0, -3.0])
def test_the_heading_is_that_of_the_world_file(heading: float) -> None:
    at, turn = Point(0.1, -0.2, 0.3), yaw_quaternion(heading)
    raster = Raster(world_of(marker_of("4X4_50", 7, at, 0.5, turn)), {}, False)
    frame = photograph(raster, above(Random(1), 2.5, 0.05), CameraSpec())
    (found,) = FINDER.detect(frame.image).found
    for posture in ("level", "any"):
        pose = marker_pose(frame, found.corners, 0.5, posture)
        assert pose is not None
        assert wrap(pose.heading - heading) == pytest.approx(0.0, abs=0.03)
        assert pose.position == pytest.approx(at, abs=0.02)


@pytest.mark.parametrize("faces", [0.0, 2.5])
@pytest.mark.parametrize(("posture", "near"), [("upright", 0.04), ("any", 0.04)])
def test_a_standing_marker(faces: float, posture: Posture, near: float) -> None:
    at = Point(1.0, 2.0, 1.5)
    raster = Raster(world_of(marker_of("4X4_50", 7, at, 0.3, standing(faces))), {}, False)
    draw = Random(4)
    for number in range(12):
        side = faces + draw.uniform(-0.7, 0.7)
        eye = at.plus((2 * np.cos(side), 2 * np.sin(side), draw.uniform(-0.3, 0.3)))
        pose = look(eye, at.plus((draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), 0.1)))
        frame = photograph(raster, pose, CameraSpec(noise=3.0), number)
        (found,) = FINDER.detect(frame.image).found
        marker = marker_pose(frame, found.corners, 0.3, posture)
        assert marker is not None
        assert distance(marker.position, at) < near
        assert abs(wrap(marker.heading - faces)) < 0.2


def test_what_no_marker_can_look_like_has_no_pose_or_finite_ones() -> None:
    """No corners make it throw: one point, a line, a mirrored square, a square above the horizon
    for a marker that lies.
    """
    down = above(Random(1), 2.0, 0.0, 0.0)
    ahead = look((0.0, 0.0, 2.0), (10.0, 0.0, 2.5))
    square = np.array([(150.0, 100), (170, 100), (170, 120), (150, 120)])
    for pose in (down, ahead):
        blank = np.zeros((240, 320, 3), np.uint8)
        frame = Frame(blank, 0, 0.0, CameraSpec().intrinsics, *pose)
        for corners in (
            square,
            square[::-1],
            np.full((4, 2), 10.0),
            np.array([(k, 7.0) for k in range(4)]),
            square - 150,
        ):
            for posture in ("level", "upright", "any"):
                for height in (None, 0.0, 5.0):
                    found = marker_pose(frame, corners, 0.5, posture, height)
                    assert found is None or np.isfinite([*found.position, found.heading]).all()


def test_exact_corners_give_the_exact_pose() -> None:
    draw = Random(9)
    for _ in range(20):
        at, heading = Point(0.3, 0.2, 0.4), draw.uniform(-pi, pi)
        pose = above(draw, 3.0)
        lens = CameraSpec().intrinsics
        corners = pixels_of(corners_of(0.12, at, yaw_quaternion(heading)), pose, lens)
        frame = Frame(np.zeros((240, 320, 3), np.uint8), 0, 0.0, lens, *pose)
        found = marker_pose(frame, corners, 0.12)
        assert found is not None
        assert found.position == pytest.approx(at, abs=1e-9)
        assert wrap(found.heading - heading) == pytest.approx(0.0, abs=1e-9)
        assert found.error < 1e-6
