"""follow_road on a vehicle without physics: what it finds, where it flies, what it does blind."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import hypot, pi

import numpy as np
import pytest

from behaviors.follow_road import Followed
from hal.scene.arrays import Pixels
from hal.vehicle import Position
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import Look, shown, sighted
from vencejo.geometry import Pose, distance
from worlds.loader import read_world
from worlds.world import World

HEIGHT = 4.0


def road(through: str, keys: str = "", more: str = "") -> World:
    """A world with a road of 80 cm."""
    text = (
        "world: road\nground: {color: grass}\nroads:\n"
        f"  main: {{through: {through}, width: 80 cm{keys}}}\n{more}"
    )
    return read_world(text, "road.yaml")


class Follower:
    """follow_road at work, with what it commanded and published."""

    def __init__(self, look: Look, **values: object) -> None:
        self.solo = Solo("follow_road", values, vehicle=sighted(look, HEIGHT))
        self.places: list[tuple[float, float, float]] = []
        self.told: list[Position] = []

    def run(self, seconds: float) -> str | None:
        for _ in range(round(seconds * 40)):
            commanded = self.solo.step()
            assert isinstance(commanded, Position)
            self.told.append(commanded)
            self.places.append(self.solo.vehicle.observe().position)
            if self.solo.outcome is not None:
                break
        return self.solo.word

    @property
    def seen(self) -> Followed:
        """What it published last."""
        published: Followed = self.solo.activity.published
        return published

    def jumps(self) -> float:
        """The largest step of the commanded place in a period, metres."""
        return max(distance(a.xyz, b.xyz) for a, b in pairwise(self.told))

    def hardest(self) -> float:
        """The largest acceleration of the commanded places, m/s²."""
        places = np.array([told.xyz for told in self.told])
        return float(np.abs(np.diff(places, n=2, axis=0)).max() * 1600)


def test_it_follows_a_road_to_its_end() -> None:
    follower = Follower(shown(road("[[0, 0], [6, 0], [6, 6]]")), speed=1.5)
    assert follower.run(30) == "done"
    x, y, z = follower.places[-1]
    assert hypot(x - 6, y - 6) < 0.3 and abs(z - HEIGHT) < 0.05
    assert min(hypot(a - 6, b) for a, b, _ in follower.places) < 0.2
    assert follower.seen.progress == pytest.approx(12, abs=0.6)
    assert follower.seen.width == pytest.approx(0.8, abs=0.1)
    assert follower.hardest() < 4.0


def test_it_turns_first_and_takes_the_way_nearest_to_its_nose_or_to_what_is_asked() -> None:
    look = shown(road("[[-8, 0], [8, 0]]"))
    follower = Follower(look)
    follower.run(6)
    assert follower.places[-1][0] > 2
    other = Follower(look, direction=pi)
    other.run(3)
    assert hypot(*other.places[-1][:2]) < 0.3  # it turns in place
    other.run(5)
    assert other.places[-1][0] < -1


def test_left_is_positive() -> None:
    follower = Follower(
        shown(road("[[0, 0.5], [4, 0.5], [7, 1.2], [9, 3.5], [9.5, 7]]", ", smooth: true"))
    )
    curvatures, offsets, angles = [], [], []
    for _ in range(280):
        follower.run(0.025)
        if follower.seen.visible:
            curvatures.append(follower.seen.curvature)
            offsets.append(follower.seen.offset)
            angles.append(follower.seen.angle)
    assert offsets[0] > 0.3 and max(curvatures) > 0.05 and max(angles) > 0.0


def test_it_comes_to_a_road_beside_it() -> None:
    follower = Follower(shown(road("[[-2, 1.2], [8, 1.2]]")))
    assert follower.run(30) == "done"
    assert abs(follower.places[-1][1] - 1.2) < 0.1


def test_a_gap_is_crossed_and_a_longer_one_is_the_end() -> None:
    world = road("[[0, 0], [10, 0]]", ", gaps: [[5, 7]]")
    follower = Follower(shown(world), gap=2.2)
    assert follower.run(30) == "done" and follower.places[-1][0] > 9.5
    follower = Follower(shown(world), gap=0.9)
    assert follower.run(30) == "done" and 4.5 < follower.places[-1][0] < 5.7


def test_without_a_road_it_looks_round_and_is_lost() -> None:
    follower = Follower(
        shown(read_world("world: w\nground: {color: grass}", "w.yaml")), patience=2.0
    )
    assert follower.run(30) == "lost"
    assert follower.solo.time > 7  # a full turn
    assert all(hypot(x, y) < 0.05 for x, y, _ in follower.places)


def blinded(look: Look, begin: float, end: float, image: Callable[[Pixels], Pixels | None]) -> Look:
    """A look whose images are others for a time."""

    def seen(pose: Pose, time: float) -> Pixels | None:
        clear = look(pose, time)
        return image(clear) if clear is not None and begin <= time < end else clear

    return seen


WRONG: dict[str, Callable[[Pixels], Pixels | None]] = {
    "black": np.zeros_like,
    "white": lambda image: np.full_like(image, 255),
    "all road": lambda image: np.full_like(image, 72),
    "small": lambda image: np.ascontiguousarray(image[:16, :16]),
    "upside down": lambda image: np.ascontiguousarray(image[::-1, ::-1]),
    "turned": lambda image: np.ascontiguousarray(np.rot90(image)[:240, :240]),
    "noise": lambda image: np.random.default_rng(0).integers(0, 255, image.shape, np.uint8),
    "none": lambda image: None,
}


@pytest.mark.parametrize("kind", WRONG)
def test_wrong_pictures_make_no_jump_and_no_fault(kind: str) -> None:
    look = shown(road("[[0, 0], [6, 0], [9, 3], [9, 8]]"))
    start = 6.0
    follower = Follower(blinded(look, start, start + 2.0, WRONG[kind]), speed=1.5, patience=3.0)
    ended = follower.run(60)
    assert ended in ("done", "lost")
    assert follower.jumps() < 0.08 and follower.hardest() < 6.0
    if kind in ("none", "small", "black", "white"):
        assert (
            ended == "done" and hypot(follower.places[-1][0] - 9, follower.places[-1][1] - 8) < 0.4
        )


@pytest.mark.parametrize("kind", ["black", "white", "all road", "noise", "none"])
def test_for_ever_blind_it_is_lost_without_a_jump(kind: str) -> None:
    look = shown(road("[[0, 0], [30, 0]]"))
    follower = Follower(blinded(look, 7.0, 1000.0, WRONG[kind]), patience=3.0)
    assert follower.run(60) in ("lost", "done")
    assert follower.jumps() < 0.08 and follower.hardest() < 6.0
    assert follower.places[-1][0] < 12


def test_it_goes_on_where_it_was() -> None:
    look = shown(road("[[0, 0], [12, 0]]"))
    follower = Follower(look)
    follower.run(8)
    progress = follower.solo.activity.progress()
    assert progress is not None and progress["flown"] > 2
    again = Solo(
        "follow_road", {}, progress=progress, vehicle=(follower.solo.session, follower.solo.vehicle)
    )
    assert again.run(30) is not None and again.word == "done"
    assert again.activity.published.progress == pytest.approx(12.0, abs=1.0)


@pytest.mark.parametrize(
    ("color", "word"), [("asphlat", "asphalt"), ({"hsv": 3}, "lowest and the highest")]
)
def test_a_wrong_colour_is_told(color: object, word: str) -> None:
    follower = Follower(shown(road("[[0, 0], [6, 0]]")), color=color)
    assert follower.solo.step() is None
    assert follower.solo.word == "failed"
    assert word in str(follower.solo.outcome.fields["reason"])  # type: ignore[union-attr]
