"""hover_over, on rendered pictures without physics."""

from __future__ import annotations

from itertools import pairwise
from math import radians
from typing import Any

import numpy as np
import pytest

from behaviors.hover_over import Over
from hal.scene.arrays import Pixels
from hal.vehicle import Position
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import Look, shown, sighted
from vencejo.geometry import Point, Pose, distance
from worlds.loader import read_world

ROUNDEL = "roundels: {r: {at: [0.3, 0.2], size: 30 cm, heading: 60 deg}}\n"
START = "world: w\nstart: {at: [90, 90]}\nground: {color: concrete, size: 90 m}\n"


class Above:
    """hover_over at work; what it sees can be covered."""

    def __init__(self, text: str = ROUNDEL, height: float = 1.2, **values: Any) -> None:
        self.look = shown(read_world(START + text, "w.yaml"))
        self.covered = False
        session, self.vehicle = sighted(self._look, height)
        self.solo = Solo("hover_over", values, vehicle=(session, self.vehicle))
        self.commands: list[Position] = []

    def _look(self, pose: Pose, time: float) -> Pixels | None:
        image = self.look(pose, time)
        return np.zeros_like(image) if self.covered and image is not None else image

    def run(self, seconds: float) -> Over:
        for _ in range(round(seconds * 40)):
            command = self.solo.step()
            assert isinstance(command, Position)
            self.commands.append(command)
        published: Over = self.solo.activity.published
        return published

    def check_smooth(self, speed: float = 1.0) -> None:
        """No command jumps: speed, and what it changes by in a period, are bounded."""
        for a, b in pairwise(self.commands):
            assert distance(a.xyz, b.xyz) < speed / 40 + 1e-6
            assert a.velocity is not None and b.velocity is not None
            assert distance(a.velocity, b.velocity) < 4.0 / 40 + 1e-6
            assert a.yaw is not None and b.yaw is not None
            assert abs(a.yaw - b.yaw) < 1.0 / 40 + 1e-6


def test_it_comes_above_the_roundel_and_turns_where_that_points() -> None:
    over = Above()
    seen = over.run(5)
    assert seen.above and seen.visible and seen.id == 1
    place = over.vehicle.position
    assert distance(place, (0.3, 0.2, 1.2)) < 0.02
    assert over.vehicle.observe().yaw == pytest.approx(radians(60), abs=0.03)
    assert seen.offset < 0.02 and abs(seen.angle) < 0.03
    assert seen.position is not None and distance(seen.position, (0.3, 0.2, 0)) < 0.02
    assert seen.heading == pytest.approx(radians(60), abs=0.03)
    over.check_smooth()


def test_without_aligning_it_keeps_its_heading() -> None:
    over = Above(align=False, size=0.3)
    assert over.run(5).above
    assert over.vehicle.observe().yaw == 0


def test_a_marker_by_its_id() -> None:
    markers = (
        "markers:\n  a: {at: [0.3, 0.2], id: 5, size: 20 cm}\n"
        "  b: {at: [-0.2, -0.3], id: 6, size: 20 cm, heading: -90 deg}\n"
    )
    over = Above(markers, target="marker", id=6, size=0.2)
    assert over.run(5).id == 6
    assert distance(over.vehicle.position, (-0.2, -0.3, 1.2)) < 0.02
    # The top of a marker of heading 0 is north.
    assert over.vehicle.observe().yaw == pytest.approx(0, abs=0.03)


def test_it_keeps_to_the_first_one_of_several() -> None:
    pair = "roundels:\n  a: {at: [0.1, 0], size: 20 cm}\n  b: {at: [-0.2, 0.4], size: 20 cm}\n"
    over = Above(pair, height=1.5)
    over.run(2)
    over.vehicle.position = Point(-0.15, 0.35, 1.5)
    over.run(4)
    assert distance(over.vehicle.position, (0.1, 0, 1.5)) < 0.02


def test_a_lost_roundel_is_waited_for_where_it_was() -> None:
    over = Above()
    over.run(5)
    over.covered = True
    lost = over.run(4)
    assert (lost.visible, lost.above, lost.id) == (False, False, 1)
    assert distance(over.vehicle.position, (0.3, 0.2, 1.2)) < 0.05
    assert lost.position is not None
    over.covered = False
    assert over.run(2).above
    over.check_smooth()


def test_a_height_is_kept_with_a_tag_and_without() -> None:
    over = Above(height=1.2)
    over.run(3)
    over.solo.live = {"height": 2.0}
    over.run(4)
    assert distance(over.vehicle.position, (0.3, 0.2, 2.0)) < 0.02
    over.covered = True
    over.solo.live = {"height": 1.5}
    over.run(4)
    assert over.vehicle.position.z == pytest.approx(1.5, abs=0.02)
    over.check_smooth()


def test_interrupted_it_goes_on_at_its_height() -> None:
    over = Above()
    over.run(3)
    progress = over.solo.activity.progress()
    again = Solo("hover_over", progress=progress, vehicle=(over.solo.session, over.vehicle))
    over.vehicle.position = over.vehicle.position._replace(z=1.1)
    again.run(3)
    assert distance(over.vehicle.position, (0.3, 0.2, 1.2)) < 0.02
    assert len(progress["roundels"]) == len(again.activity.progress()["roundels"]) == 1


@pytest.mark.parametrize("grey", [0, 127, 255])
@pytest.mark.parametrize("shape", [(240, 320, 3), (16, 16, 3)])
def test_pictures_of_one_colour_move_nothing(shape: tuple[int, ...], grey: int) -> None:
    over = Above()
    over.look = lambda pose, time: np.full(shape, grey, np.uint8)
    assert over.run(2) == Over()
    assert distance(over.vehicle.position, (0, 0, 1.2)) < 0.01


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_turned_pictures_never_make_it_jump(quarters: int) -> None:
    """The vehicle is told a wrong way to go: whatever it does, it does smoothly."""
    over = Above()
    straight: Look = over.look

    def turned(pose: Pose, time: float) -> Pixels | None:
        image = straight(pose, time)
        return None if image is None else np.ascontiguousarray(np.rot90(image, quarters))

    over.look = turned
    over.run(6)
    over.check_smooth()
    assert over.solo.outcome is None


def test_a_picture_that_jumps_about_never_makes_it_jump() -> None:
    over = Above()
    straight: Look = over.look

    def jumping(pose: Pose, time: float) -> Pixels | None:
        image = straight(pose, time)
        return None if image is None else np.roll(image, round(time * 20) % 7 * 20 - 60, axis=1)

    over.look = jumping
    over.run(6)
    over.check_smooth()
