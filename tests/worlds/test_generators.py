"""Generated worlds: equal numbers give equal worlds, and each can be solved."""

from __future__ import annotations

from collections import deque
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
