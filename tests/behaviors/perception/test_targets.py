"""Targets of a known size in rendered images."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi, radians
from random import Random
from typing import Any

import numpy as np
import pytest

from behaviors.perception.targets import ColorTarget, MarkerTarget, read_target
from hal.raster.renderer import Raster
from hal.sim.sensors.camera_spec import CameraSpec
from tests.behaviors.perception.markers import above, marker_of, photograph
from tests.hal.scenes import ROAD, look, thing_of, world_of
from vencejo.geometry import Point, distance, wrap, yaw_quaternion
from worlds.things import Sphere

BALL = {"color": "red", "size": 0.4}
NESTED = {
    "id": 5,
    "size": 0.5,
    "dictionary": "6X6_250",
    "inside": {"id": 9, "size": 0.12},
}


@pytest.mark.parametrize(("far", "most"), [(1.5, 0.03), (3.0, 0.1), (6.0, 0.35)])
def test_a_ball_is_where_its_size_tells(far: float, most: float) -> None:
    at = Point(1.0, 2.0, 1.5)
    raster = Raster(world_of(thing_of("ball", Sphere(0.2), at, color=(210, 25, 25))), {}, False)
    target, draw = read_target(BALL, "any"), Random(1)
    for number in range(12):
        side = draw.uniform(-pi, pi)
        eye = at.plus((far * np.cos(side), far * np.sin(side), draw.uniform(-0.2, 0.2)))
        aside = draw.uniform(-0.3, 0.3) * far
        pose = look(eye, at.plus((-aside * np.sin(side), aside * np.cos(side), 0.1)))
        frame = photograph(raster, pose, CameraSpec(noise=3.0), number)
        (found,) = target.look(frame).sightings
        assert distance(found.position, at) < most
        assert found.heading is None
        error = np.array(found.position.minus(at))
        assert error @ np.linalg.solve(found.covariance, error) < 16.0


def test_what_the_image_cuts_off_has_an_uncertain_range() -> None:
    at = Point(3.0, 0.0, 1.5)
    raster = Raster(world_of(thing_of("ball", Sphere(0.2), at, color=(210, 25, 25))), {}, False)
    whole, cut = (
        read_target(BALL, "any").look(
            photograph(raster, look((0.0, 0.0, 1.5), (3.0, aside, 1.5)), CameraSpec())
        )
        for aside in (0.0, 1.73)
    )
    assert whole.sightings[0].covariance[0, 0] < 0.02
    assert cut.sightings[0].covariance.trace() > 0.5


def test_of_nested_markers_the_outer_one_counts_while_it_is_seen() -> None:
    things = (
        marker_of("6X6_250", 5, Point(0.0, 0.0, 0.0), 0.5, yaw_quaternion(0.4)),
        marker_of("4X4_50", 9, Point(0.0, 0.0, 0.001), 0.12, yaw_quaternion(0.4)),
    )
    raster = Raster(world_of(*things, ground=ROAD), {}, False)
    target, draw = read_target(NESTED, "level"), Random(3)
    assert isinstance(target, MarkerTarget) and (target.largest, target.smallest) == (0.5, 0.12)
    for number, height in enumerate((0.3, 0.45, 0.6, 1.5, 2.5, 4.0)):
        frame = photograph(raster, above(draw, height, 0.03), CameraSpec(noise=3.0), number)
        (found,) = target.look(frame).sightings
        assert hypot(*found.position[:2]) < 0.01 + 0.01 * height
        # Its top points north before it is turned.
        assert found.heading is not None
        assert wrap(found.heading - (pi / 2 + 0.4)) == pytest.approx(0.0, abs=radians(3))
        side = np.ptp(found.outline[:, 0])
        assert (side > 90 / height) == (height > 1.0)


def test_what_is_no_target_is_kept_for_pictures() -> None:
    world = world_of(marker_of("4X4_50", 7, Point(0.0, 0.0, 0.0), 0.5), ground=ROAD)
    frame = photograph(Raster(world, {}, False), above(Random(1), 2.0, 0.0), CameraSpec())
    seen = read_target({"id": 3, "size": 0.5}, "level").look(frame)
    assert seen.sightings == () and len(seen.rejected) >= 1


@pytest.mark.parametrize("picture", ["black", "white", "red", "noise", "tiny"])
@pytest.mark.parametrize("given", [BALL, NESTED])
def test_pictures_of_nothing_do_no_harm(picture: str, given: dict[str, Any]) -> None:
    size = 16 if picture == "tiny" else 240
    noise = np.random.default_rng(0).integers(0, 256, (size, size, 3), dtype=np.uint8)
    flat = {"black": (0, 0, 0), "white": (255, 255, 255), "red": (0, 0, 255)}
    image = noise if picture not in flat else np.full_like(noise, flat[picture])
    pose = above(Random(1), 2.0)
    frame = photograph(Raster(world_of(), {}, False), pose, CameraSpec())

    for posture in ("level", "any"):
        seen = read_target(given, posture).look(replace(frame, image=image))
        for each in seen.sightings:
            assert np.isfinite(each.position).all() and np.isfinite(each.covariance).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("red", r"a target is \{color: …, size: …\} or a marker"),
        ({"size": 1.0}, "a target is"),
        ({"color": "red"}, "its `size` is needed"),
        ({"color": "red", "size": 0.0}, "from 1 mm to 100 m"),
        ({"color": "red", "size": True}, "from 1 mm to 100 m"),
        ({"color": "redd", "size": 1.0}, "redd"),
        ({"color": "red", "size": 1.0, "id": 3}, r"'id' is not known here"),
        ({"id": 1.5, "size": 1.0}, "a whole number"),
        ({"id": 1, "size": 1.0, "dictionary": 4}, "a `dictionary` is a name"),
        ({"id": 1, "size": 1.0, "inside": 4}, "the marker `inside` is"),
        ({"id": 1, "size": 1.0, "inside": {"id": 1, "size": 0.1, "inside": {}}}, "'inside' is not"),
    ],
)
def test_a_target_that_cannot_be_is_told(given: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_target(given, "level")


def test_a_colour_can_be_a_range() -> None:
    given = {"color": {"hsv": [[170, 100, 80], [10, 255, 255]]}, "size": 0.4}
    assert isinstance(read_target(given, "any"), ColorTarget)
