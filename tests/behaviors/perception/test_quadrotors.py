"""Quadrotors in images: where they are, and how far."""

from __future__ import annotations

from math import atan2, hypot, inf, radians, sqrt
from random import Random

import numpy as np
import pytest

from behaviors.perception import read_color
from behaviors.perception.quadrotors import Sighting, sightings
from hal.scene.arrays import Pixels
from hal.sim.sensors.lens import Lens
from hal.vehicle import Frame
from tests.behaviors.perception.frames import LENSES, PLAIN, frame_of, front, seen_from
from tests.behaviors.seen_quadrotor import SIZE, quadrotor_at, turned
from tests.hal.scenes import thing_of, world_of
from vencejo.geometry import Point, distance
from worlds.things import Sphere

EYE = Point(0.0, 0.0, 3.0)
RED = read_color("red")


def frame_with(
    place: Point, yaw: float, pitch: float = 0.0, roll: float = 0.0, lens: str = "plain"
) -> Frame:
    """What a camera that looks east sees of a quadrotor whose middle is at a place."""
    spec = LENSES[lens]
    made = Lens(spec, 0, ("test",))
    look = quadrotor_at(lambda _: (place, turned(yaw, pitch, roll)), lens=made.pinhole)
    image = made.develop([look((EYE, front()), 0.0)], 1)
    return frame_of(image, (EYE, front()), spec.intrinsics)


def only(frame: Frame) -> Sighting:
    found = sightings(frame, RED, SIZE)
    assert found
    return found[0]


@pytest.mark.parametrize("lens", ["plain", "distorted", "noisy"])
def test_the_range_is_known_however_it_is_turned(lens: str) -> None:
    draw = Random(lens)
    errors = []
    for degrees in range(0, 360, 15):
        far = draw.uniform(2.7, 3.3)
        place = EYE.plus((far, draw.uniform(-0.5, 0.5), draw.uniform(-0.1, 0.1)))
        seen = only(frame_with(place, radians(degrees), draw.gauss(0, 0.03), lens=lens))
        errors.append(seen.range / distance(EYE, place) - 1)
        assert distance(seen.position(), place) < 0.35
        assert abs(seen.range - distance(EYE, place)) < 4 * seen.deviation
    assert sqrt(sum(e * e for e in errors) / len(errors)) < 0.045
    assert max(map(abs, errors)) < 0.1, "by its width alone it would be 15 %"


@pytest.mark.parametrize(("place", "within"), [((5, 1, 3.5), 0.012), ((8, -2, 2), 0.012)])
def test_its_direction_is_that_of_its_middle(
    place: tuple[float, float, float], within: float
) -> None:
    seen = only(frame_with(Point(*place), 0.4))
    x, y, z = seen.direction
    dx, dy, dz = Point(*place).minus(EYE)
    assert atan2(y, x) == pytest.approx(atan2(dy, dx), abs=within)
    assert atan2(z, hypot(x, y)) == pytest.approx(atan2(dz, hypot(dx, dy)), abs=within)
    assert hypot(hypot(x, y), z) == pytest.approx(1.0)


def test_what_leans_is_measured_too() -> None:
    for pitch, roll in ((0.2, 0.0), (-0.2, 0.0), (0.0, 0.25), (0.1, -0.2)):
        seen = only(frame_with(EYE.plus((3.0, 0.0, 0.0)), 0.0, pitch, roll))
        assert seen.range == pytest.approx(3.0, rel=0.09)


def test_a_ball_is_as_wide_as_it_is_high() -> None:
    ball = thing_of("ball", Sphere(0.25), (4.0, 0.5, 3.2), color=(220, 30, 30))
    frame = seen_from(world_of(ball), EYE, front(), PLAIN)
    (seen,) = sightings(frame, RED, 0.5)
    assert seen.position() == pytest.approx((4.0, 0.5, 3.2), abs=0.12)


def test_of_what_the_edge_cuts_only_the_direction_is_known() -> None:
    seen = only(frame_with(EYE.plus((3.0, 1.75, 0.0)), 0.0))
    assert seen.range == inf
    assert seen.position(3.4) == pytest.approx((3.0, 1.6, 3.0), abs=0.25)


def images() -> dict[str, Pixels]:
    noise = np.random.default_rng(1).integers(0, 256, (240, 320, 3), np.uint8)
    flat = {name: np.full((240, 320, 3), value, np.uint8) for name, value in (("b", 0), ("w", 255))}
    red = np.zeros((240, 320, 3), np.uint8)
    red[:] = (30, 30, 220)
    thin = np.zeros((240, 320, 3), np.uint8)
    thin[100, 20:300] = thin[20:220, 50] = (30, 30, 220)
    small = red[:16, :16].copy()
    small[4:9, 2:13] = 0
    turned = np.ascontiguousarray(np.rot90(thin))
    return {**flat, "red": red, "thin": thin, "small": small, "turned": turned, "noise": noise}


@pytest.mark.parametrize("name", images())
def test_no_picture_is_too_much(name: str) -> None:
    for seen in sightings(frame_of(images()[name], (EYE, front())), RED, SIZE):
        assert seen.range > 0 and seen.deviation > 0 and not np.isnan(seen.range)
        assert np.isfinite(seen.direction).all()
        covariance = seen.covariance(277.0, 3.0 if seen.range == inf else None)
        assert (np.linalg.eigvalsh(covariance) > 0).all()


def test_nothing_of_the_colour_is_nothing() -> None:
    look = quadrotor_at(lambda _: (EYE.plus((3.0, 0.0, 0.0)), turned(0.0)), "blue")
    assert sightings(frame_of(look((EYE, front()), 0.0), (EYE, front())), RED, SIZE) == []
