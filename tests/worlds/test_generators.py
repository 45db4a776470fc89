"""Generated worlds: equal numbers give equal worlds, and each can be solved."""

from __future__ import annotations

from collections import deque
from hashlib import sha256
from math import dist
from pathlib import Path

import pytest

from tests.cli.run_cli import run_cli
from vencejo.errors import UserError
from vencejo.geometry import Point
from worlds import World, curves, find_world
from worlds.generators import FAMILIES, FOREST, TREES_APART, generate

NUMBERS = (*range(25), 12345)


@pytest.mark.parametrize("family", FAMILIES)
def test_equal_numbers_give_equal_worlds(family: str) -> None:
    texts = [generate(family, number) for number in NUMBERS]
    assert texts == [generate(family, number) for number in NUMBERS]
    assert len(set(texts)) == len(texts)


DIGESTS = {
    "roads:0": "25263166a0ecdaef92666d5cf618776514255dc2a26d3329b55143ba210be268",
    "roads:3": "509b3ffa4ff5bd159722f9a7cd32e77f1553b3fe352278cd48ad3281b5a00d5d",
    "roads:17": "e77db733d9603220d968f871a48922abdc9ce9be440a87baee8286591a828611",
    "narrow_roads:0": "04ad6942f1d7fe4fd1a580d863bcb7db1d7a31e37cb3cd64a1686769fe2252bf",
    "narrow_roads:3": "0b7f01532a00a4cbfb2051808f91683a33de70f9d31e58cbd6d3bcee467720a3",
    "narrow_roads:17": "acc7122d651163edb4533eeb97038b6abc0b91ae89e6527df0e4fb9c99a2ffcc",
    "corner_roads:0": "807d86a94acd7cd9a2016613af57eccce49e533667678c54b05e0cc65367d9bd",
    "corner_roads:3": "8ea020c906872a4dd587ee125b0bd551f104dd6e4274ea7e070880a13c8ff8bf",
    "corner_roads:17": "b262a2302acab6ca5f876f0ed317b41acc04f8bda4937b1815ca616461880f22",
    "search:0": "da4404c6a291a87f53fbaf97df311dc57691524cebf3342e2c146b8781e13df0",
    "search:3": "dacb9bb7dad55b09b255505d2b6e3046aa0a5ec138d018cb2971e04efc5c4505",
    "search:17": "0802f52e13051a0255e1d96b04097ff2496413ce6da6e240bd8d3a0e6395bb73",
    "forest:0": "dd20b70caf9180ac42751e5fa65c743eac8572d3095c60c96157759e9210c536",
    "forest:3": "470c7377ea00354a43665c9021e3a10698451e7f0d76fca9433e152747eb2411",
    "forest:17": "9bf033f7bb33667ccc03fdc5018d5c1bfab8ed6864af03c6f950b331af02977b",
}
"""SHA-256 of the text of some worlds: people refer to a generated world by its number alone."""


@pytest.mark.parametrize("word", DIGESTS)
def test_a_number_means_the_same_world_for_ever(word: str) -> None:
    family, _, number = word.partition(":")
    assert sha256(generate(family, int(number)).encode()).hexdigest() == DIGESTS[word]
    assert find_world(word).sha256 == DIGESTS[word]
    assert {each.partition(":")[0] for each in DIGESTS} == set(FAMILIES)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_generated_world_is_found_by_its_number(family: str) -> None:
    world = find_world(f"{family}:17")
    assert (world.name, str(world.source)) == (f"{family}_17", f"{family}:17")
    assert world.sha256 == find_world(f"{family}:017").sha256
    assert world.sha256 != find_world(f"{family}:18").sha256


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("roads", "give its number: roads:17"),
        ("roads:x", "give its number: roads:17"),
        ("roads:-1", "give its number: roads:17"),
        ("rods:17", "did you mean 'roads:17'?"),
        ("forrest", "did you mean 'forest'?"),
    ],
)
def test_what_is_no_generated_world(word: str, hint: str) -> None:
    with pytest.raises(UserError) as caught:
        find_world(word)
    assert (caught.value.code, caught.value.faults[0].hint) == ("unknown-world", hint)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_road_begins_below_the_start_and_leads_ahead(number: int) -> None:
    world = find_world(f"roads:{number}")
    main, *branches = world.roads
    assert main.points[0] == (0, 0) and world.starts[0].heading == 0.0
    assert curves.every(main.points, 5.0)[1] == pytest.approx((5, 0), abs=0.7)
    assert main.points[-1] == world.places["end"][:2]
    assert 60 < curves.length(main.points) < 300
    assert world.ground.stripes
    for branch in branches:
        assert min(dist(branch.points[0], place) for place in curves.every(main.points, 0.1)) < 0.2


@pytest.mark.parametrize("family", ["narrow_roads", "corner_roads"])
def test_a_narrow_road_begins_below_the_start_and_keeps_away_from_itself(family: str) -> None:
    for number in NUMBERS:
        world = find_world(f"{family}:{number}")
        main = world.roads[0]
        assert main.points[0] == (0, 0) and 0.5 <= main.width <= 1.2
        assert main.points[-1] == pytest.approx(world.places["end"][:2], abs=0.01)
        places = curves.every(main.points, 0.5)
        for k, place in enumerate(places):
            assert all(dist(place, other) > 2.9 for other in places[k + 24 :])


def test_narrow_roads_bend_no_more_than_they_should() -> None:
    for number in NUMBERS:
        places = find_world(f"narrow_roads:{number}").roads[0].points
        for a, b, c in zip(places, places[1:], places[2:], strict=False):
            twice_area = abs((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
            assert 2 * twice_area / (dist(a, b) * dist(b, c) * dist(a, c)) < 1 / 2.8


def test_roads_differ() -> None:
    worlds = [find_world(f"roads:{number}") for number in NUMBERS]
    assert {len(world.roads) for world in worlds} == {1, 2}
    assert {len({stripe.color for stripe in world.ground.stripes}) for world in worlds} == {1, 2}
    assert {world.roads[0].width for world in worlds} == {2.0, 3.0, 4.0}


@pytest.mark.parametrize("number", NUMBERS)
def test_a_search_field_has_people_in_it(number: int) -> None:
    world = find_world(f"search:{number}")
    persons = [thing for thing in world.things if thing.kind == "person"]
    assert 3 <= len(persons) <= 7 and len(world.things) > len(persons)
    for thing in world.things:
        assert 5 <= thing.at.x <= 65 and -30 <= thing.at.y <= 30
        assert all(dist(thing.at, o.at) >= 5 for o in world.things if o is not thing)


def way_through(world: World, goal: Point) -> bool:
    """Whether steps of half a metre lead to the goal, with room for a vehicle at each."""
    trunks = [thing.at[:2] for thing in world.things]
    todo, seen = deque([(0, 0)]), {(0, 0)}
    while todo:
        i, j = todo.popleft()
        if dist((i / 2, j / 2), goal[:2]) < 0.5:
            return True
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            place = (cell[0] / 2, cell[1] / 2)
            inside = -2 <= place[0] <= 62 and FOREST[2] <= place[1] <= FOREST[3]
            # A trunk's radius is 0.27 m at most.
            if cell not in seen and inside and min(dist(place, at) for at in trunks) > 0.7:
                seen.add(cell)
                todo.append(cell)
    return False


@pytest.mark.parametrize("number", NUMBERS)
def test_a_forest_has_a_way_through(number: int) -> None:
    world = find_world(f"forest:{number}")
    assert len(world.things) >= 60
    for thing in world.things:
        assert all(dist(thing.at, o.at) >= TREES_APART for o in world.things if o is not thing)
    assert way_through(world, world.places["goal"])


def test_a_run_keeps_the_generated_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cli.run._draw", lambda folder: None)
    assert run_cli("run", "first_flight", "--world", "forest:3", "--json").code == 0
    (kept,) = tmp_path.glob("runs/*/forest_3.yaml")
    assert kept.read_text() == generate("forest", 3)
