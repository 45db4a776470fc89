"""What makes pictures look right: crowns of trees, lines on the ground, the ground's edge."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray

from hal.raster import Raster
from tests.hal.scenes import lens
from vencejo.geometry import OPTICAL, Point, Pose, about_y, product, yaw_quaternion
from worlds.loader import read_world

LENS = lens(640, 480)


def picture(text: str, pose: Pose) -> NDArray[np.float64]:
    image = Raster(read_world(text, "scenery"), {}).render(pose, LENS, 0.0, {})
    return image.astype(float)


def looking(x: float, y: float, z: float, heading: float, tilt: float) -> Pose:
    return Point(x, y, z), product(product(yaw_quaternion(heading), about_y(tilt)), OPTICAL)


TREE = "world: w\nground: {color: sand}\ntrees: {t: {at: [8, 0], height: 8 m}}\n"


@pytest.mark.parametrize(
    "pose",
    [looking(0, 0, 1.6, 0.0, -0.4), looking(0, 0, 8, 0.0, 0.1), looking(8, 0, 30, 0.0, pi / 2)],
)
def test_a_crown_has_light_and_dark_leaves(pose: Pose) -> None:
    image = picture(TREE, pose)
    blue, green, red = np.moveaxis(image, 2, 0)
    crown = (green > red + 10) & (green > blue + 5)
    assert crown.sum() > 1000
    tones = green[crown]
    assert len(np.unique(tones)) > 12
    assert tones.std() > 6


def test_the_leaves_are_lighter_towards_the_sun_and_stay_in_their_places() -> None:
    light = "light: {heading: 90 deg, height: 30 deg}\n"
    image = picture(TREE + light, looking(8, 0, 40, pi / 2, pi / 2))
    blue, green, red = np.moveaxis(image, 2, 0)
    rows = np.nonzero((green > red + 10) & (green > blue + 5))
    middle = rows[0].mean()
    north, south = green[rows][rows[0] < middle - 5], green[rows][rows[0] > middle + 5]
    assert north.mean() > south.mean() + 15


def test_other_balls_are_of_one_tone() -> None:
    image = picture(
        "world: w\nspheres: {b: {at: [8, 0, 2], radius: 2 m, color: red}}\n",
        looking(0, 0, 4, 0.0, 0.0),
    )
    red = image[(image[..., 2] > image[..., 1] + 60)]
    assert len(red) > 5000 and len(np.unique(red, axis=0)) == 1


@pytest.mark.parametrize("slope", [0.03, 0.07, 0.12])
@pytest.mark.parametrize("height", [1.6, 3.0])
def test_the_edge_of_a_line_has_no_steps(slope: float, height: float) -> None:
    road = f"through: [[-4, 0], [80, {84 * slope}]], width: 3 m, color: black, edges: white"
    image = picture(
        f"world: w\nground: {{color: green}}\nroads: {{r: {{{road}}}}}\n",
        looking(0, 0, height, 0.0, 0.1),
    )
    right = image.min(2)[:, 320:] / 255
    edges = {}
    for row in range(330, 480):
        (seen,) = np.nonzero(right[row] > 0.5)
        if len(seen) and 1 <= seen[0] < 300:
            before, after = right[row, seen[0] - 1], right[row, seen[0]]
            edges[row] = seen[0] - (after - 0.5) / (after - before)
    rows, found = np.array(list(edges)), np.array(list(edges.values()))
    assert len(rows) > 60
    straight = np.polyval(np.polyfit(rows, found, 1), rows)
    assert np.abs(found - straight).mean() < LARGEST_STEP


LARGEST_STEP = 0.17
"""Pixels, on average, between the edge of a straight line as it is seen and a straight line."""


def test_the_ground_ends_without_a_seam() -> None:
    image = picture("world: w\nground: {color: grass, size: 60 m}\n", looking(30, 0, 40, 0, pi / 2))
    gray = image.mean(2)
    # Averages along the edge, which lies across the middle: noise has none of its own there.
    across = gray.mean(1)
    assert np.abs(np.diff(across)).max() < 2.5
    assert abs(across[-20:].mean() - across[:20].mean()) > 6, "its colour is another beyond"
