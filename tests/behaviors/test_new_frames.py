"""Frames are given once, and those taken while the vehicle was tilted are left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from behaviors.new_frames import NewFrames
from hal.vehicle import PERIOD, Frame, Observation
from tests.behaviors.flying import airborne
from tests.behaviors.perception.frames import frame_of, ventral
from vencejo.geometry import Point, about_y

FRAME = frame_of(np.zeros((240, 320, 3), np.uint8), (Point(0.0, 0.0, 3.0), ventral()))


class Eye:
    """A camera that takes a picture every other period, and gives it ``late`` periods later."""

    def __init__(self, late: int = 0) -> None:
        self.late = late
        self.period = 0

    def latest(self) -> Frame | None:
        number = (self.period - self.late) // 2
        return replace(FRAME, sequence=number, time=2 * number * PERIOD) if number >= 0 else None


def given(tilts: list[float], most_tilt: float | None = None, late: int = 0) -> list[int]:
    """The numbers of the frames that are given, the vehicle tilted so from period to period."""
    eye, found = Eye(late), []
    frames = NewFrames(eye, most_tilt)
    seen: Observation = airborne()[1].observe()
    for eye.period, tilt in enumerate(tilts):
        now = seen._replace(time=eye.period * PERIOD, attitude=about_y(tilt))
        frame = frames.next(now)
        if frame is not None:
            found.append(frame.sequence)
    return found


def test_each_is_given_once_also_at_any_tilt() -> None:
    assert given([0.0, 0.5, 1.0, 0.5, 0.0, 0.0]) == [0, 1, 2]
    assert given([]) == []


def test_before_the_first_there_is_none() -> None:
    assert given([0.0] * 6, late=3) == [0, 1]


def test_tilted_ones_are_left_out() -> None:
    assert given([0.0, 0.0, 0.3, 0.0, 0.0, 0.0], most_tilt=0.2) == [0, 2]


@pytest.mark.parametrize("late", [1, 2, 4])
def test_it_is_the_tilt_when_it_was_taken_that_counts(late: int) -> None:
    taken_tilted = [0.3 if k == 2 else 0.0 for k in range(12)]
    assert given(taken_tilted, most_tilt=0.2, late=late)[:2] == [0, 2]
    read_tilted = [0.3 if k == late else 0.0 for k in range(12)]
    assert given(read_tilted, most_tilt=0.2, late=late)[0] == 0
