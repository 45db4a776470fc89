"""find_color: the largest thing of a colour, as the published cat saw it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from behaviors import drone_vocabulary
from behaviors.find_color import ColorSpot
from fsm import compile_mission, read_mission_text
from hal.scene.arrays import Pixels
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import sighted

RED = (30, 30, 220)
GRASS = (60, 130, 85)


def picture(*boxes: tuple[int, int, int, int], color: tuple[int, int, int] = RED) -> Pixels:
    """Grass with boxes: left, top, right, bottom, pixels."""
    image = np.full((240, 320, 3), GRASS, np.uint8)
    for left, top, right, bottom in boxes:
        image[top:bottom, left:right] = color
    return image


def seen(image: Pixels, **values: Any) -> ColorSpot:
    """What is published of one picture."""
    solo = Solo("find_color", {"color": "red", **values}, vehicle=sighted(lambda pose, time: image))
    solo.step()
    spot = solo.activity.published
    assert solo.outcome is None and isinstance(spot, ColorSpot)
    return spot


def test_places_are_from_the_middle_in_half_widths_right_and_up() -> None:
    spot = seen(picture((230, 50, 260, 70)))
    assert spot.visible
    assert spot.x == pytest.approx((244.5 - 159.5) / 160, abs=0.01)
    assert spot.y == pytest.approx((119.5 - 59.5) / 160, abs=0.01)
    # The blur and its threshold widen it, but for its corners; the polygon lies within its edge.
    assert spot.area == pytest.approx(33 * 23, rel=0.05)
    left_below = seen(picture((20, 200, 50, 220)))
    assert left_below.x < -0.7 and left_below.y < -0.5


def test_it_is_the_largest_within_the_limits() -> None:
    both = picture((20, 20, 40, 40), (200, 100, 260, 160))
    assert seen(both).x > 0
    assert seen(both, max_area_limit=2000.0).x < 0
    assert seen(both, min_area_limit=10_000.0) == ColorSpot()


def test_colours_by_range_and_what_is_none() -> None:
    blue = picture((100, 100, 140, 140), color=(220, 60, 30))
    assert not seen(blue).visible
    assert seen(blue, color={"hsv": [[105, 100, 100], [125, 255, 255]]}).visible
    assert seen(blue, color={"rgb": [[0, 30, 180], [60, 90, 255]]}).visible
    solo = Solo("find_color", {"color": "rod"}, vehicle=sighted(lambda pose, time: blue))
    solo.step()
    assert solo.word == "failed"
    assert solo.outcome is not None and "no colour 'rod'" in str(solo.outcome.fields["reason"])


def test_pictures_of_a_tilted_vehicle_are_ignored() -> None:
    image = picture((100, 100, 140, 140))
    solo = Solo(
        "find_color",
        {"color": "red", "roll_pitch_thr": 0.2},
        vehicle=sighted(lambda pose, time: image),
    )
    level = solo.vehicle.observe()
    tilted = level._replace(attitude=(0.15, 0.0, 0.0, 0.99))
    solo.vehicle.observe = lambda: tilted  # type: ignore[method-assign]
    solo.step()
    assert solo.activity.published == ColorSpot()


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((240, 320, 3), np.uint8),
        np.full((240, 320, 3), 255, np.uint8),
        np.full((240, 320, 3), RED, np.uint8),
        np.full((16, 16, 3), RED, np.uint8),
        np.ascontiguousarray(np.rot90(picture((100, 100, 140, 140)))),
    ],
)
def test_no_picture_is_too_much(image: Pixels) -> None:
    spot = seen(image)
    assert abs(spot.x) <= 1 and abs(spot.y) <= 1.5 and spot.area <= image.size


def test_the_published_cat_reads_what_it_publishes() -> None:
    text = """\
mission: cat
states:
  hunt:
    do: find_color
    as: blob
    with:
      camera: front
      color: red
      min_area_limit: 50
      max_area_limit: 20000
      roll_pitch_thr: 0.2 rad
    states:
      wait: {do: hover, when: {blob.visible and blob.area > 20 and blob.x < blob.y: over}}
      over: {type: final}
    on: {done: end}
  end: {type: final}
"""
    graph = compile_mission(read_mission_text(text), drone_vocabulary())
    assert {fault.code for fault in graph.warnings} <= {"not-flying"}
