"""Worlds from files; every fault with its place."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from math import pi
from pathlib import Path

import pytest

from tests.worlds.faults import OTHER_FAULTS, SHAPE_FAULTS, W
from vencejo.errors import UserError, Where
from vencejo.geometry import Point, yaw_quaternion
from worlds import Origin, Start, World, figures, find_world, load_world, world_names
from worlds.solids import thing_near
from worlds.things import UPRIGHT, Cuboid, Part, Sphere, Thing

FULL = """\
world: test_yard
description: All there is.
origin: {lat: 40.5, lon: -3.7 deg, alt: 667 m}
ground: {color: [1, 2, 3], size: 60 m}
start:
  - {at: [0, 0], heading: 90 deg}
  - {at: [6, 2, 2.5]}
battery: 80 %
boxes:
  shed: {at: [6, 2], size: [2, 3 m, 250 cm], heading: 30 deg, color: brick}
  shelf: {at: [0, 9, 1], size: [1, 1, 0.1]}
beacons: {b1: {at: [5, 0, 3], color: blue}}
places: {gate: [10, 0, 2 m]}
"""


def write(folder: Path, text: str) -> Path:
    file = folder / "w.yaml"
    file.write_text(text)
    return file


def faults(folder: Path, text: str) -> list[str]:
    """The faults of a world file, each as ``line:column code``."""
    file = write(folder, text)
    with pytest.raises(UserError) as caught:
        load_world(file)
    found = []
    for fault in caught.value.faults:
        assert fault.where is not None and fault.where.file == str(file)
        found.append(f"{fault.where.line}:{fault.where.column} {fault.code}")
    return found


def test_reads_all_there_is(tmp_path: Path) -> None:
    file = write(tmp_path, FULL)
    world = load_world(file)
    assert (world.name, world.description) == ("test_yard", "All there is.")
    assert world.origin == Origin(40.5, -3.7, 667.0)
    assert (world.ground.color, world.ground.size) == ((1, 2, 3), 60.0)
    assert world.starts == (
        Start(Point(0, 0, 0), pi / 2),
        Start(Point(6, 2, 2.5), 0.0),
    )
    assert world.battery == pytest.approx(0.8)
    shed, shelf, b1 = world.things
    assert (shed.name, shed.kind, shed.at, shed.solid) == ("shed", "box", Point(6, 2, 0), True)
    assert shed.attitude == pytest.approx(yaw_quaternion(pi / 6))
    assert shed.parts == (
        Part(Cuboid(Point(2, 3, 2.5)), Point(0, 0, 1.25), UPRIGHT, (160, 75, 55)),
    )
    assert (shelf.at, shelf.parts[0].color) == (Point(0, 9, 1), (128, 128, 128))
    assert (b1.kind, b1.at, b1.solid) == ("beacon", Point(5, 0, 3), False)
    assert b1.parts == (Part(Sphere(0.15), Point(0, 0, 0), UPRIGHT, (30, 60, 220)),)
    assert world.places == {"b1": Point(5, 0, 3), "gate": Point(10, 0, 2)}
    assert world.source == file and len(world.sha256) == 64


def test_a_start_may_say_the_colour_of_its_vehicle(tmp_path: Path) -> None:
    starts = "start: [{at: [0, 0], color: red}, {at: [2, 0]}, {at: [4, 0], color: [1, 2, 3]}]"
    world = load_world(write(tmp_path, f"world: bare\n{starts}\n"))
    assert [start.color for start in world.starts] == [(220, 30, 30), None, (1, 2, 3)]
    assert faults(tmp_path, "world: w\nstart: {at: [0, 0], color: rod}\n") == ["2:28 unknown-color"]


def test_a_name_is_enough(tmp_path: Path) -> None:
    world = load_world(write(tmp_path, "world: bare\n"))
    assert (world.things, world.roads, dict(world.places)) == ((), (), {})
    assert world.starts == (Start(Point(0, 0, 0), 0.0),)
    assert world.battery == 1.0 and world.origin is None


def test_a_world_never_changes(tmp_path: Path) -> None:
    world = load_world(write(tmp_path, FULL))
    with pytest.raises(FrozenInstanceError):
        world.name = "x"  # type: ignore[misc]
    with pytest.raises(TypeError):
        world.places["x"] = Point(0, 0, 0)  # type: ignore[index]


def test_the_hash_is_of_the_files_bytes(tmp_path: Path) -> None:
    one = load_world(write(tmp_path, "world: a\n")).sha256
    assert one == load_world(write(tmp_path, "world: a\n")).sha256
    assert one != load_world(write(tmp_path, "world: a \n")).sha256


@pytest.mark.parametrize(("text", "expected"), SHAPE_FAULTS + OTHER_FAULTS)
def test_each_fault_has_its_place(tmp_path: Path, text: str, expected: list[str]) -> None:
    assert faults(tmp_path, text) == expected


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("world: w\nbatery: 1\n", "did you mean 'battery'?"),
        ("world: w\nground: {color: gras}\n", "did you mean 'grass'?"),
        ("world: w\nstart: {at: [0, 0], heading: 9 dge}\n", "did you mean 'deg'?"),
        (W + "boxes: {a: {at: [0, 0], size: [1, 1, 2]}}\n", "with z = 2"),
    ],
)
def test_a_fault_names_the_way_out(tmp_path: Path, text: str, hint: str) -> None:
    with pytest.raises(UserError) as caught:
        load_world(write(tmp_path, text))
    assert hint in str(caught.value)


def test_starts_on_top_of_a_box_or_under_a_shelf_are_free(tmp_path: Path) -> None:
    boxes = "boxes: {hut: {at: [0, 0], size: [3, 3, 2]}, shelf: {at: [9, 0, 3], size: [3, 3, 1]}}\n"
    world = load_world(write(tmp_path, W + boxes + "start: [{at: [0, 0, 2]}, {at: [9, 0]}]\n"))
    assert [start.at.z for start in world.starts] == [2.0, 0.0]


def test_a_heading_turns_what_is_in_the_way() -> None:
    def near(thing: Thing, *place: float) -> bool:
        return thing_near([thing], Point(*place)) is not None

    def box(at: Point, size: Point, heading: float) -> Thing:
        return Thing("b", "box", at, yaw_quaternion(heading), figures.box(size, (0, 0, 0)))

    turned = box(Point(1, 1, 1), Point(4, 1, 2), pi / 2)
    assert near(turned, 1, 3.3, 2) and not near(turned, 3.3, 1, 2)
    leaning = box(Point(0, 0, 0), Point(4, 0.2, 2), pi / 6)
    assert near(leaning, 1.5, 0.866, 1) and not near(leaning, 1.5, -0.866, 1)
    assert not near(turned, 1, 1, 3) and near(turned, 1, 1, 2.9)
    assert near(turned, 1, 1, 0.7) and not near(turned, 1, 1, 0.5)


# By name or path.


def shipped() -> list[World]:
    return [find_world(name) for name in world_names()]


def test_the_shipped_worlds_are_in_order() -> None:
    assert {"beacons", "empty", "yard"} <= set(world_names())
    for name, world in zip(world_names(), shipped(), strict=True):
        assert world.name == name and world.description


def test_the_beacons_are_where_the_reference_has_them() -> None:
    places = find_world("beacons").places
    assert set(places.values()) == {Point(5, 0, 3), Point(5, 5, 4), Point(0, 5, 3)}


def test_a_world_is_found_by_its_path(tmp_path: Path) -> None:
    assert find_world(str(write(tmp_path, FULL))).name == "test_yard"
    with pytest.raises(UserError) as caught:
        find_world(str(tmp_path / "none.yaml"))
    assert caught.value.code == "no-such-file"


def test_an_unknown_world_names_the_nearest() -> None:
    with pytest.raises(UserError) as caught:
        find_world("yrad", Where("m.yaml", 3, 8))
    fault = caught.value.faults[0]
    assert (fault.code, fault.where, fault.hint) == (
        "unknown-world",
        Where("m.yaml", 3, 8),
        "did you mean 'yard'?",
    )


def test_the_example_of_the_guide_is_a_world(tmp_path: Path) -> None:
    guide = (Path(__file__).parents[2] / "docs" / "worlds.md").read_text()
    example = guide.split("```yaml\n")[1].split("```")[0]
    world = load_world(write(tmp_path, example))
    assert world.things and world.places
