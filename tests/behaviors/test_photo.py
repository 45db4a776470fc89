"""photo."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from behaviors import describe
from behaviors.photo import Photo
from hal.vehicle import Frame, Intrinsics, Velocity
from tests.behaviors.flying import Solo, airborne
from vencejo.geometry import Point

INFO = describe(Photo)
LENS = Intrinsics.from_field_of_view(10, 8, 1.0)


class Camera:
    """A frame every 0.1 s, at the vehicle's place; none while it is covered."""

    def __init__(self, solo: Solo) -> None:
        self.solo, self.covered = solo, False

    def latest(self) -> Frame | None:
        count = int(self.solo.time * 10 + 1e-6)
        image = np.zeros((8, 10, 3), np.uint8)
        place = self.solo.vehicle.position
        frame = Frame(image, count, count / 10, LENS, place, (0.0, 0.0, 0.0, 1.0))
        return None if self.covered else frame


def at_work(values: dict[str, Any], moving: bool = False) -> tuple[Solo, Camera, list[Any]]:
    session, vehicle = airborne()
    solo = Solo("hover", vehicle=(session, vehicle))
    camera, kept = Camera(solo), []
    vehicle.camera = lambda name: camera  # type: ignore[method-assign, assignment]
    for _ in range(40 if moving else 0):
        vehicle.command(Velocity(x=2.0))
        session.wait()
    solo = Solo(INFO, {"camera": "front", **values}, vehicle=(session, vehicle))
    solo.channel.on_photo = lambda *photo: kept.append(photo)
    return solo, camera, kept


def test_it_stops_takes_one_picture_and_names_it() -> None:
    solo, _, kept = at_work({"name": "north_side"}, moving=True)
    solo.run(20)
    assert solo.outcome and solo.word == "done"
    ((name, camera, frame),) = kept
    assert (name, camera) == ("north_side", "front")
    # It was at rest when the frame was exposed, and stays there.
    assert frame.position == solo.vehicle.position
    assert solo.vehicle.observe().velocity.norm() < 1e-9
    assert solo.outcome.fields == {
        "name": "north_side", "camera": "front", "sequence": frame.sequence,
        "position": frame.position,
    }  # fmt: skip
    assert frame.time >= solo.time - 0.7


def test_it_turns_to_what_it_looks_at_first() -> None:
    solo, _, kept = at_work({"heading": {"face": Point(0.0, 9.0, 0.0)}})
    solo.run(20)
    assert solo.word == "done" and len(kept) == 1
    assert solo.vehicle.yaw == pytest.approx(1.5708, abs=0.05)


@pytest.mark.parametrize(
    ("values", "covered", "wind", "reason"),
    [
        ({"timeout": 3.0}, True, 0.0, "no picture came within 3 s"),
        ({"timeout": 3.0}, False, 6.0, "the vehicle is not steady within 3 s"),
        ({"name": "../x"}, False, 0.0, "'../x' is no name of a picture"),
        ({"name": ""}, False, 0.0, "is no name of a picture"),
    ],
)
def test_what_has_failed(values: dict[str, Any], covered: bool, wind: float, reason: str) -> None:
    solo, camera, kept = at_work(values)
    camera.covered, solo.vehicle.wind = covered, Point(wind, 0.0, 0.0)
    solo.run(20)
    assert solo.outcome and solo.word == "failed" and reason in solo.outcome.fields["reason"]
    assert kept == []


def test_a_camera_that_it_does_not_have() -> None:
    solo = Solo(INFO, {"camera": "rear"})
    solo.run(1)
    assert solo.outcome and "no camera 'rear'" in solo.outcome.fields["reason"]
