"""Worlds from files; every fault with its place."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from math import pi
from pathlib import Path

import pytest

from vencejo.errors import UserError, Where
from vencejo.geometry import Point
from worlds import Beacon, Box, Origin, Start, World, find_world, load_world, world_names

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
    assert world.boxes == (
        Box("shed", Point(6, 2, 0), Point(2, 3, 2.5), 30 * pi / 180, (160, 75, 55)),
        Box("shelf", Point(0, 9, 1), Point(1, 1, 0.1), 0.0, (128, 128, 128)),
    )
    assert world.beacons == (Beacon("b1", Point(5, 0, 3), (30, 60, 220)),)
    assert world.places == {"b1": Point(5, 0, 3), "gate": Point(10, 0, 2)}
    assert world.source == file and len(world.sha256) == 64


def test_a_name_is_enough(tmp_path: Path) -> None:
    world = load_world(write(tmp_path, "world: bare\n"))
    assert (world.boxes, world.beacons, dict(world.places)) == ((), (), {})
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


W = "world: w\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("description: x\n", ["1:1 missing-key"]),
        (W + "colour: red\n", ["2:1 unknown-key"]),
        ("world: [w]\n", ["1:8 wrong-type"]),
        ("world:\n", ["1:7 wrong-type"]),
        # Maps.
        (W + "boxes: [a, b]\n", ["2:8 wrong-type"]),
        (W + "boxes: {a: big}\n", ["2:12 wrong-type"]),
        (W + "boxes: {a: {at: [1, 2]}}\n", ["2:12 missing-key"]),
        (W + "boxes: {a: {size: [1, 2, 1]}}\n", ["2:12 missing-key"]),
        (W + "boxes:\n  a: {at: [9, 9], size: [1, 1, 1], colr: red}\n", ["3:36 unknown-key"]),
        (W + "boxes: {Big Shed: {at: [9, 9], size: [1, 1, 1]}}\n", ["2:9 bad-name"]),
        (W + "beacons: {b: {}}\n", ["2:14 missing-key"]),
        (W + "ground: green\n", ["2:9 wrong-type"]),
        (W + "ground: {size: 0 m}\n", ["2:16 bad-size"]),
        (W + "ground: {color: gras}\n", ["2:17 unknown-color"]),
        (W + "ground: {color: [1, 2]}\n", ["2:17 wrong-type"]),
        (W + "ground: {color: [1, 2, 256]}\n", ["2:17 wrong-type"]),
        (W + "ground: {color: [1, 2, 3, x]}\n", ["2:17 wrong-type"]),
        # Quantities.
        (W + "battery: full\n", ["2:10 wrong-type"]),
        (W + "battery: 20 m\n", ["2:10 wrong-dimension"]),
        (W + "battery: 120 %\n", ["2:10 out-of-range"]),
        (W + "battery: -0.1\n", ["2:10 out-of-range"]),
        (W + "battery: [1]\n", ["2:10 wrong-type"]),
        (W + "start: {at: [0, 0], heading: 3 m}\n", ["2:30 wrong-dimension"]),
        (W + "start: {at: [0, 0], heading: 90 dge}\n", ["2:30 unknown-unit"]),
        (W + "origin: {lat: 1, lon: 2, alt: 3 kg}\n", ["2:31 wrong-dimension"]),
        (W + "origin: {lat: 91, lon: 2}\n", ["2:15 out-of-range"]),
        (W + "origin: {lat: 1, lon: -181 deg}\n", ["2:23 out-of-range"]),
        (W + "origin: {lat: 1}\n", ["2:9 missing-key"]),
        (W + "origin: {lat: north, lon: 1}\n", ["2:15 wrong-type"]),
        # Sizes and places.
        (W + "boxes: {a: {at: [9, 9], size: [1, -1, 1]}}\n", ["2:35 bad-size"]),
        (W + "boxes: {a: {at: [9, 9], size: [1, 0, 1]}}\n", ["2:35 bad-size"]),
        (W + "boxes: {a: {at: [9, 9], size: [1, 1]}}\n", ["2:31 wrong-type"]),
        (W + "boxes: {a: {at: [9, 9], size: [1, 1, 1e999]}}\n", ["2:38 out-of-range"]),
        (W + "boxes: {a: {at: [9, .nan], size: [1, 1, 1]}}\n", ["2:21 wrong-type"]),
        (W + "places: {p: [1, 2]}\n", ["2:13 wrong-type"]),
        (W + "places: {p: 3}\n", ["2:13 wrong-type"]),
        (W + "places: {p: [1, 2, 3 s]}\n", ["2:20 wrong-dimension"]),
        (W + "start: []\n", ["2:8 wrong-type"]),
        (W + "start: {at: [0]}\n", ["2:13 wrong-type"]),
        (W + "start: {heading: 0}\n", ["2:8 missing-key"]),
        # Names.
        (W + "beacons: {b: {at: [1, 2, 3]}}\nplaces: {b: [1, 2, 3]}\n", ["3:10 duplicate-name"]),
        (W + "places: {b: [1, 2, 3], b: [4, 5, 6]}\n", ["2:24 duplicate-key"]),
        # Starts.
        (
            W + "boxes: {a: {at: [1, 0], size: [1, 1, 1]}}\nstart: {at: [1.4, 0]}\n",
            ["3:8 start-in-box"],
        ),
        (
            W + "boxes: {a: {at: [1, 0], size: [1, 1, 1]}}\n"
            "start: [{at: [5, 5]}, {at: [1.8, 0]}]\n",
            ["3:23 start-in-box"],
        ),
        (W + "boxes: {a: {at: [0, 0], size: [1, 1, 1]}}\n", ["1:1 start-in-box"]),
        # Several at once, in the order of the file.
        (
            "world: w\nbatery: 1\nboxes:\n  a: {at: [9], size: [1, 1, -1]}\n"
            "places: {p: [1, 2, 3 s]}\n",
            ["2:1 unknown-key", "4:11 wrong-type", "4:29 bad-size", "5:20 wrong-dimension"],
        ),
        ("", ["1:1 empty-file"]),
        ("a: [\n", ["2:1 bad-yaml"]),
    ],
)
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


def test_a_box_contains_what_its_heading_turns_into_it() -> None:
    box = Box("b", Point(1, 1, 1), Point(4, 1, 2), pi / 2, (0, 0, 0))
    assert box.contains(Point(1, 2.9, 2)) and not box.contains(Point(2.9, 1, 2))
    leaning = Box("l", Point(0, 0, 0), Point(4, 0.2, 2), pi / 6, (0, 0, 0))
    assert leaning.contains(Point(1.5, 0.866, 1)) and not leaning.contains(Point(1.5, -0.866, 1))
    assert not box.contains(Point(1, 1, 3)) and not box.contains(Point(1, 1, 1))
    assert box.contains(Point(1.8, 1, 2), 0.4) and box.contains(Point(1, 1, 0.7), 0.4)


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
    assert world.boxes and world.beacons and world.places
