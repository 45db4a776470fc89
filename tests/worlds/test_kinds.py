"""The parts of each kind of thing, and their places."""

from __future__ import annotations

import subprocess
import sys
from math import pi
from pathlib import Path

import cv2
import pytest

from vencejo.geometry import Point, product, turned, yaw_of
from worlds import World
from worlds.figures import standing
from worlds.loader import read_world
from worlds.markers import DICTIONARIES, plate_side
from worlds.motion import pose_at
from worlds.solids import bounds_of, part_pose, solid_parts, top_of
from worlds.terrain import height_at
from worlds.things import Charuco, Fiducial, Plate, Roundel, Thing

ROOT = Path(__file__).parents[2]


def world(text: str) -> World:
    return read_world(f"world: w\nstart: {{at: [90, 90]}}\n{text}", "w.yaml")


def only(text: str) -> Thing:
    (thing,) = world(text).things
    return thing


def size_of(thing: Thing) -> tuple[float, float, float]:
    """Length, width and height of the upright box about what is solid."""
    bounds = [
        bounds_of(part.shape, *part_pose(part, thing.at, thing.attitude))
        for part in solid_parts(thing)
    ]
    low = [min(bound[0][k] for bound in bounds) for k in range(3)]
    high = [max(bound[1][k] for bound in bounds) for k in range(3)]
    assert low[2] == pytest.approx(thing.at.z, abs=0.01), "it stands on its place"
    length, width, height = (b - a for a, b in zip(low, high, strict=True))
    return length, width, height


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("boxes: {b: {at: [1, 2], size: [3, 1, 2], heading: 90 deg}}", (1, 3, 2)),
        ("cylinders: {c: {at: [1, 2, 3], radius: 0.5, height: 4}}", (1, 1, 4)),
        ("spheres: {s: {at: [1, 2], radius: 0.5}}", (1, 1, 1)),
        ("walls: {w: {through: [[0, 0], [4, 0], [4, 3]], height: 1}}", (4.2, 3.2, 1)),
        ("houses: {h: {at: [1, 2], size: [8, 10, 4]}}", (8.6, 10.6, 4)),
        ("cars: {c: {at: [1, 2]}}", (4.2, 1.86, 1.45)),
        ("people: {p: {at: [1, 2]}}", (0.4, 0.4, 1.75)),
        ("people: {p: {at: [1, 2], lying: true}}", (1.75, 0.4, 0.4)),
        ("trees: {t: {at: [1, 2], height: 8}}", (4, 4, 8)),
        ("gates: {g: {at: [1, 2], size: [2, 3]}}", (0.1, 2.2, 3.1)),
        ("signs: {s: {at: [1, 2], top: 3, size: [1, 0.5]}}", (0.115, 1, 3)),
    ],
)
def test_sizes(text: str, size: tuple[float, float, float]) -> None:
    thing = only(text)
    assert size_of(thing) == pytest.approx(size, abs=0.01)
    assert top_of(thing) == pytest.approx(thing.at.z + size[2], abs=0.01)


def test_a_gate_is_open_inside() -> None:
    left, right, lintel = only("gates: {g: {at: [5, 0], size: [2, 3]}}").parts
    assert (left.at.y, right.at.y, lintel.at.z) == pytest.approx((-1.05, 1.05, 3.05))


def test_a_marker_lies_like_a_map() -> None:
    marker = only("markers: {m: {at: [1, 2], id: 7, size: 30 cm, heading: 90 deg}}")
    (part,) = marker.parts
    # Six modules of black and two of white.
    assert part.shape == Plate(pytest.approx(0.4), pytest.approx(0.4))
    assert part.texture == Fiducial("4X4_50", 7)
    at, attitude = part_pose(part, marker.at, marker.attitude)
    assert at == Point(1, 2, 0)
    assert turned((0, 1, 0), attitude) == pytest.approx((-1, 0, 0)), "its upper edge is west"
    assert turned((0, 0, 1), attitude) == pytest.approx((0, 0, 1))
    assert solid_parts(marker) == ()


@pytest.mark.parametrize(
    ("posture", "normal", "up"),
    [
        ("faces: 0", (1, 0, 0), (0, 0, 1)),
        ("faces: 180 deg", (-1, 0, 0), (0, 0, 1)),
        ("faces: 90 deg, lean: 90 deg", (0, 0, 1), (0, -1, 0)),
        ("faces: 90 deg, lean: -90 deg", (0, 0, -1), (0, 1, 0)),
        ("faces: 90 deg, turn: 90 deg", (0, 1, 0), (1, 0, 0)),
    ],
)
def test_a_marker_can_face_anywhere(
    posture: str, normal: tuple[float, ...], up: tuple[float, ...]
) -> None:
    marker = only(f"markers: {{m: {{at: [1, 2, 3], id: 1, size: 1, {posture}}}}}")
    _, attitude = part_pose(marker.parts[0], marker.at, marker.attitude)
    assert turned((0, 0, 1), attitude) == pytest.approx(normal, abs=1e-12)
    assert turned((0, 1, 0), attitude) == pytest.approx(up, abs=1e-12)


def test_a_roundel_lies_with_its_disc_around_its_place_and_points_where_it_heads() -> None:
    roundel = only("roundels: {r: {at: [1, 2], size: 30 cm, heading: 90 deg}}")
    (part,) = roundel.parts
    assert part.shape == Plate(pytest.approx(0.54), pytest.approx(0.54))
    assert part.texture == Roundel()
    at, attitude = part_pose(part, roundel.at, roundel.attitude)
    assert at == Point(1, 2, 0)
    assert turned((0, 1, 0), attitude) == pytest.approx((0, 1, 0)), "its upper edge is ahead"
    assert turned((0, 0, 1), attitude) == pytest.approx((0, 0, 1))
    assert solid_parts(roundel) == ()


def test_a_board_has_the_size_of_its_squares() -> None:
    board = only("boards: {b: {at: [1, 2], columns: 5, rows: 7, square: 47.5 mm, marker: 28.5 mm}}")
    (part,) = board.parts
    assert part.shape == Plate(pytest.approx(0.2375), pytest.approx(0.3325))
    assert part.texture == Charuco("4X4_50", 5, 7, pytest.approx(0.6))


def test_dictionaries_are_opencvs() -> None:
    for name, (count, modules) in DICTIONARIES.items():
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))
        assert (known.bytesList.shape[0], known.markerSize + 2) == (count, modules)
    assert plate_side("APRILTAG_36h11", 0.8) == pytest.approx(1.0)


def test_a_marker_on_a_box_moves_with_it() -> None:
    pad = only(
        "boxes: {pad: {size: [1, 1, 0.2], marker: {id: 3, size: 0.5},"
        " moves: {through: [[0, 0], [0, 9]], speed: 1 m/s}}}"
    )
    assert pad.parts[1].texture == Fiducial("4X4_50", 3)
    at, attitude = pose_at(pad, 4.5)
    assert (at, yaw_of(attitude)) == (Point(0, 4.5, 0), pytest.approx(pi / 2))
    assert part_pose(pad.parts[1], at, attitude)[0] == pytest.approx((0, 4.5, 0.21))


def test_a_marker_can_have_another_one_inside() -> None:
    nested = "id: 5, size: 0.5, dictionary: 6X6_250, inside: {id: 9, size: 0.12}"
    lying = only(f"markers: {{m: {{at: [0, 0], {nested}}}}}").parts[0]
    on_top = only(f"boxes: {{b: {{at: [0, 0], size: [1, 1, 1], marker: {{{nested}}}}}}}").parts[1]
    assert lying.texture == on_top.texture
    assert isinstance(lying.texture, Fiducial) and lying.shape == Plate(0.625, 0.625)
    assert lying.texture.inside == Fiducial("4X4_50", 9)
    assert lying.texture.share == pytest.approx(0.16 / 0.625)


def test_a_smooth_path_goes_through_its_points() -> None:
    car = only(
        "cars: {c: {moves:"
        " {through: [[0, 0], [9, 0], [9, 9]], speed: 3, loop: true, smooth: true}}}"
    )
    assert car.motion is not None and len(car.motion.points) > 30
    assert {Point(0, 0, 0), Point(9, 0, 0), Point(9, 9, 0)} <= set(car.motion.points)
    assert car.motion.points[0] != car.motion.points[-1]


def test_things_stand_on_the_hill() -> None:
    hill = "ground: {terrain: {size: 20, heights: [[0, 0, 0], [0, 4, 0], [0, 0, 0]]}}\n"
    hut, tower = world(
        f"{hill}boxes: {{hut: {{at: [5, 0], size: [1, 1, 1]}},"
        " tower: {at: [0, 0, 9], size: [1, 1, 1]}}"
    ).things
    assert (hut.at.z, tower.at.z) == (2.0, 9.0)


@pytest.mark.parametrize("shape", ["", ", loop: true", ", loop: true, smooth: true"])
def test_a_path_without_heights_lies_on_the_ground_all_along(shape: str) -> None:
    hills = (
        "ground: {terrain: {size: 40, heights: [[0, 0, 0, 0, 0], [0, 3, 1, 5, 0], [0, 0, 4, 2, 0],"
        " [0, 1, 6, 0, 0], [0, 0, 0, 0, 0]]}}\n"
    )
    path = "through: [[-18, -3], [17, 4], [2, 15], [-9, 9]], speed: 2 m/s"
    hilly = world(f"{hills}cars: {{c: {{moves: {{{path}{shape}}}}}}}")
    (car,) = hilly.things
    for time in range(0, 400):
        x, y, z = pose_at(car, 0.25 * time)[0]
        assert z == pytest.approx(height_at(hilly.ground.terrain, x, y), abs=0.03)
    # One with a height keeps to it.
    (kite,) = world(f"{hills}cars: {{c: {{moves: {{{path.replace('-3', '-3, 9')}}}}}}}").things
    assert [pose_at(kite, time)[0].z > 3 for time in (0, 4)] == [True, True]
    assert kite.motion is not None and len(kite.motion.points) == 4


def test_the_north_is_the_first_row_of_a_terrain() -> None:
    rows = "[[0, 0, 0, 0], [0, 3, 4, 0], [0, 1, 2, 0], [0, 0, 0, 0]]"
    terrain = world(f"ground: {{terrain: {{size: 30, heights: {rows}}}}}").ground.terrain
    assert terrain is not None and terrain.heights[1] == (0, 1, 2, 0)


def test_plates_stand_off_what_they_are_on() -> None:
    house = only("houses: {h: {at: [0, 0], size: [8, 10, 4]}}")
    plates = [part for part in house.parts if isinstance(part.shape, Plate)]
    assert len(plates) == 5
    for part in plates:
        assert abs(part.at.x) == pytest.approx(4.01)
        outwards = turned((0, 0, 1), part.attitude)
        assert outwards == pytest.approx((1 if part.at.x > 0 else -1, 0, 0), abs=1e-9)


def test_standing_is_upright() -> None:
    assert turned((0, 0, 1), product(standing(0.0), (0, 0, 0, 1))) == pytest.approx((1, 0, 0))


def test_numpy_waits_for_a_mesh() -> None:
    program = (
        "import sys; from worlds import find_world, world_names\n"
        "for name in world_names(): find_world(name)\n"
        "assert 'numpy' not in sys.modules and 'cv2' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=True)
