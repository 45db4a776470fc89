"""The shipped worlds hold what their names say, each within reach."""

from __future__ import annotations

from collections import Counter
from math import dist
from pathlib import Path

import pytest

import worlds
from hal.sim import open_session
from hal.vehicle import Options
from worlds import World, curves, find_world, world_names
from worlds.motion import pose_at
from worlds.solids import bounds_of, part_pose, solid_parts
from worlds.things import Fiducial, Thing


def kinds(world: World) -> Counter[str]:
    return Counter(thing.kind for thing in world.things)


def named(world: World, name: str) -> Thing:
    return next(thing for thing in world.things if thing.name == name)


def test_these_are_shipped() -> None:
    files = Path(worlds.__file__).parent / "files"
    assert set(world_names()) == {file.stem for file in files.glob("*.yaml")}
    assert {"empty", "beacons", "road_town", "search_field"} <= set(world_names())


@pytest.mark.parametrize("name", world_names())
def test_each_can_be_flown_in(name: str) -> None:
    with open_session(Options(world=name)) as session:
        for _ in range(20):
            session.wait()
        (vehicle,) = session.vehicles.values()
        seen = vehicle.observe()
        assert seen.position == pytest.approx(seen.home, abs=0.002) and seen.events == ()


def test_the_roads_of_the_town() -> None:
    town = find_world("road_town")
    lengths = {road.name: curves.length(road.points) for road in town.roads}
    assert 290 < lengths["main"] + lengths["west"] < 310
    main, west, branch = town.roads
    assert main.points[-1] == west.points[0], "the road goes on"
    assert min(dist(branch.points[0], place) for place in main.points) < 1e-6
    assert dist(curves.piece(main.points, 112, 115)[0], town.places["gap"][:2]) < 5
    assert kinds(town) == {"house": 9, "car": 5, "person": 3, "tree": 6, "sign": 2}
    for thing in town.things:
        if thing.name == "taxi":
            continue
        for part in solid_parts(thing):
            low, high = bounds_of(part.shape, *part_pose(part, thing.at, thing.attitude))
            for road in town.roads:
                for x, y in curves.every(road.points, 0.5):
                    aside = max(low.x - x, x - high.x, low.y - y, y - high.y)
                    assert aside > road.width / 2, f"{thing.name} stands on {road.name}"


def test_what_is_searched_for_lies_inside_the_field() -> None:
    field = find_world("search_field")
    corners = list(field.places.values())
    assert kinds(field)["person"] == 5 and len(field.things) == 17
    for thing in field.things:
        assert min(c.x for c in corners) < thing.at.x < max(c.x for c in corners)
        assert min(c.y for c in corners) < thing.at.y < max(c.y for c in corners)


def test_every_marker_has_an_id_of_its_own() -> None:
    yard = find_world("marker_yard")
    textures = [part.texture for thing in yard.things for part in thing.parts]
    ids = [texture.id for texture in textures if isinstance(texture, Fiducial)]
    assert len(ids) == len(set(ids)) == 13
    assert kinds(yard)["board"] == 3 and named(yard, "pad").motion is not None


def test_the_gates_are_open_at_their_middles() -> None:
    slalom = find_world("slalom")
    for k in range(1, 6):
        gate, middle = named(slalom, f"gate_{k}"), slalom.places[f"middle_{k}"]
        lintel = part_pose(gate.parts[2], gate.at, gate.attitude)[0]
        assert middle[:2] == gate.at[:2] and gate.at.z + 0.6 < middle.z < lintel.z - 0.6


def test_the_pursued_never_meet_anything() -> None:
    world = find_world("pursuit")
    still = [thing for thing in world.things if thing.motion is None]
    for name, room in (("ball", 1.5), ("runaway", 3.0)):
        moving = named(world, name)
        for second in range(120):
            at, _ = pose_at(moving, second)
            assert all(dist(at[:2], thing.at[:2]) > room for thing in still)
            assert all(dist(at[:2], start.at[:2]) > room for start in world.starts)
