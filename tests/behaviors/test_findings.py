"""Findings: sightings become things, each once, where they are."""

from __future__ import annotations

import json
from math import pi

import numpy as np
import pytest

from behaviors import Sighting
from behaviors.findings import Findings
from behaviors.perception import ground_points, pixels_of
from hal.vehicle import Frame, Intrinsics
from vencejo.geometry import OPTICAL, Point, about_x, about_y, product

LENS = Intrinsics.from_field_of_view(320, 240, pi / 3)
BLANK = np.zeros((240, 320, 3), np.uint8)
DOWN = product(about_y(pi / 2), OPTICAL)


def level(x: float, y: float) -> float:
    return 0.0


class Search:
    """A camera that flies over things, and what is told of them."""

    def __init__(self, near: float = 1.0, radius: float = 2.0) -> None:
        self.findings = Findings(near, radius, lambda place: place.x < 50)
        self.time = 0.0
        self.told: list[tuple[str, str, Point]] = []

    def look(
        self, at: Point, *things: tuple[str, Point], own_id: str = "", roll: float = 0.0
    ) -> None:
        """Take a picture that shows the middles of things."""
        attitude = product(about_x(roll), DOWN)
        frame = Frame(BLANK, 0, self.time, LENS, at, attitude)
        sightings = [
            Sighting(kind, tuple(pixels_of(frame, [place])[0]), place.z, own_id)
            for kind, place in things
        ]
        self.time += 0.05
        for thing, status in self.findings.take(frame, sightings, level):
            self.told.append((status, thing.name or thing.kind, thing.position))

    def over(self, *things: tuple[str, Point], y: float = 0.0, own_id: str = "") -> None:
        """Fly along y, with all things in view within 2.5 m."""
        for k in range(-80, 80):
            x = k * 0.1
            near = [thing for thing in things if abs(thing[1].x - x) < 2.5]
            self.look(Point(x, y, 6), *near, own_id=own_id)

    @property
    def words(self) -> list[tuple[str, str]]:
        return [(status, name) for status, name, _ in self.told]


def test_a_thing_is_far_then_new_then_known() -> None:
    search = Search()
    search.over(("person", Point(1, 0.5, 0.2)))
    assert search.words == [("far", "person"), ("new", "person_1"), ("known", "person_1")]
    assert search.told[-1][2] == pytest.approx((1, 0.5, 0), abs=1e-6)
    search.over(("person", Point(1, 0.5, 0.2)), y=-2.0)
    assert search.words[3:] == [("known", "person_1")]
    assert len(search.findings.things) == 1


def test_things_of_a_kind_are_apart_and_numbered_each_kind_for_itself() -> None:
    search = Search()
    things = [("person", Point(0, 0, 0)), ("person", Point(1.5, 0, 0)), ("ball", Point(0, 0.2, 0))]
    search.over(*things)
    assert sorted(thing.name for thing in search.findings.found) == [
        "ball_1", "person_1", "person_2"
    ]  # fmt: skip


def test_nearer_than_near_is_the_same_thing() -> None:
    search = Search(near=2.0)
    search.over(("person", Point(0, 0, 0)))
    search.over(("person", Point(1.5, 0, 0)))
    assert [thing.name for thing in search.findings.found] == ["person_1"]


@pytest.mark.parametrize("radius", [2.0, 0.5])
def test_a_thing_that_was_placed_too_far_away_at_first_is_no_other(radius: float) -> None:
    search = Search(near=1.0, radius=radius)
    person = ("person", Point(0, 0, 0))
    for _ in range(5):
        search.look(Point(0, 0, 6), person)
    search.look(Point(-0.6, 0, 6), person, ("person", Point(1.1, 0, 0)))
    for _ in range(5):
        search.look(Point(-0.6, 0, 6), person, ("person", Point(0.8, 0, 0)))
    search.findings.finish()
    assert [thing.name for thing in search.findings.found] == ["person_1"]
    assert search.findings.found[0].position.x == pytest.approx(0)


def test_an_id_of_its_own_tells_things_apart_and_names_them() -> None:
    search = Search()
    search.over(("marker", Point(0, 0, 0)), own_id="7")
    search.over(("marker", Point(0.3, 0, 0)), own_id="9")
    # The same number again somewhere else is another thing.
    search.over(("marker", Point(5, 0, 0)), own_id="7")
    assert [thing.name for thing in search.findings.found] == ["marker_7", "marker_9", "marker_7-2"]


def test_views_from_above_count_most() -> None:
    """The middle of what stands is taken to be 0.2 m high, and is 0.9 m high."""
    search, plain = Search(), []
    for k in range(100):
        frame = Frame(BLANK, 0, 0.05 * k, LENS, Point(0.025 * k, 0, 6), DOWN)
        (pixel,) = pixels_of(frame, [Point(0, 0, 0.9)])
        search.findings.take(frame, [Sighting("person", tuple(pixel), 0.2)], level)
        plain.append(ground_points(frame, [pixel], 0.2)[0][0])
    (thing,) = search.findings.things
    assert np.mean(plain) < -0.15
    assert -0.12 < thing.position.x < 0 and thing.position.y == pytest.approx(0)


def test_a_tilted_camera_places_things_as_well() -> None:
    search = Search()
    for k in range(5):
        search.look(Point(0, 0.5, 6), ("person", Point(0.5, 0, 0.2)), roll=0.1 * (k - 2))
    assert search.told[-1] == ("new", "person_1", pytest.approx((0.5, 0, 0), abs=1e-6))


def test_what_is_seldom_seen_is_nothing() -> None:
    search = Search()
    for k in range(60):
        things = [("person", Point(0, 0, 0))] if k % 3 == 0 else []
        search.look(Point(0.01 * k, 0, 6), *things)
    assert search.told == [] and search.findings.finish() == []


def test_two_views_are_too_few() -> None:
    search = Search()
    for _ in range(2):
        search.look(Point(0, 0, 6), ("person", Point(0, 0, 0)))
    assert search.told == []
    search.look(Point(0, 0, 6), ("person", Point(0, 0, 0)))
    assert search.words == [("new", "person_1")]


def test_what_lies_where_nobody_searches_is_left_out() -> None:
    search = Search()
    for _ in range(5):
        search.look(Point(50, 0, 6), ("person", Point(50.5, 0, 0)), ("ball", Point(49.5, 0, 0)))
    assert search.words == [("new", "ball_1")]


def test_at_the_end_what_was_far_counts_too() -> None:
    search = Search(radius=0.5)
    for _ in range(5):
        search.look(Point(0, 2, 6), ("person", Point(0, 0, 0)), ("ball", Point(0, 1.8, 0.3)))
    assert search.words == [("far", "person"), ("new", "ball_1")]
    assert [(thing.name, status) for thing, status in search.findings.finish()] == [
        ("person_1", "new"),
        ("ball_1", "known"),
    ]
    assert search.findings.finish() == []


def test_it_goes_on_from_its_progress() -> None:
    search, other = Search(), Search()
    search.over(("person", Point(0, 0, 0)))
    other.findings.resume(json.loads(json.dumps(search.findings.progress())))
    other.time = search.time
    other.over(("person", Point(0.1, 0, 0)), ("person", Point(3, 0, 0)))
    told = [("far", "person"), ("new", "person_2"), ("known", "person_1"), ("known", "person_2")]
    assert other.words == told


def test_on_a_slope_things_lie_on_the_ground_where_they_are() -> None:
    findings = Findings(1.0, 5.0, lambda place: True)
    frame = Frame(BLANK, 0, 0.0, LENS, Point(0, 0, 6), DOWN)
    (pixel,) = pixels_of(frame, [Point(2.0, 0.0, 0.6)])
    for _ in range(3):
        findings.take(frame, [Sighting("ball", tuple(pixel))], lambda x, y: 0.3 * x)
    (thing,) = findings.things
    assert thing.position == pytest.approx((2.0, 0.0, 0.6), abs=0.1)
