"""Findings: what detectors have seen, located in the world and told apart.

A thing is seen in many frames, from straight above and from aside. Its place is the mean of all
views, weighted by how certain each is: seen off the vertical by an angle θ, a height that is wrong
by h moves it by h·tan θ.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import dist
from typing import Any, NamedTuple

import numpy as np

from behaviors.detector import Sighting
from behaviors.perception.projection import ground_point, is_inside, pixels_of
from hal.vehicle import Frame
from vencejo.geometry import Point, horizontal_distance

_CONFIRMED = 3
"""Views after which a thing is taken for one."""
_SHARE = 0.7
"""Least share of the frames that should show a thing in which it was seen."""
_MARGIN = 1.0
"""Distance from the edge of a frame beyond which a thing should be seen whole, metres."""
_SIGMA, _HEIGHT_SIGMA = 0.05, 0.3
"""Standard deviations of a place and of a height, metres."""
_GONE = 1.0
"""Seconds after which a thing that is not seen any more is passed."""


Ground = Callable[[float, float], float]
"""The height of the ground at a place (x, y), mission frame, metres."""


@dataclass
class Thing:
    """Something that was seen, once or more."""

    kind: str
    own_id: str
    """What tells it from others of its kind; empty for nothing."""
    name: str = ""
    """Given when it is found: ``person_1``."""
    views: int = 0
    looks: int = 0
    """Frames in which it should have been seen whole."""
    hits: int = 0
    """Those of them in which it was."""
    weight: float = 0.0
    sum_x: float = 0.0
    sum_y: float = 0.0
    z: float = 0.0
    """Of the ground below it, metres."""
    seen_at: float = 0.0
    """Time of the last frame that shows it, seconds."""
    pixel: tuple[float, float] = (0.0, 0.0)
    """Where it is in that frame."""
    told_far: bool = False
    passing: bool = False
    """Whether it has been seen since it was passed."""
    is_known: bool = False
    """Whether it was found, and passed since."""
    picture: str = ""
    frame: Frame | None = field(default=None, repr=False)
    """The best frame of one that is not found yet."""
    nearest: float = 0.0
    """The distance over the ground from which that was taken, metres."""

    @property
    def position(self) -> Point:
        """Mission frame, metres."""
        return Point(self.sum_x / self.weight, self.sum_y / self.weight, self.z)

    @property
    def is_found(self) -> bool:
        return self.name != ""

    @property
    def is_certain(self) -> bool:
        """Whether it was seen often, and seldom not seen where it should have been."""
        return self.views >= _CONFIRMED and self.hits >= _SHARE * self.looks

    def view(self, place: Point, pixel: tuple[float, float], frame: Frame) -> None:
        """Take a view of it: a place on the ground, and the pixel where it is seen."""
        aside = horizontal_distance(frame.position, place)
        slope = aside / max(0.1, frame.position.z - place.z)
        weight = 1 / (_SIGMA**2 + (_HEIGHT_SIGMA * slope) ** 2)
        self.views += 1
        self.weight += weight
        self.sum_x += weight * place.x
        self.sum_y += weight * place.y
        self.z = place.z
        self.seen_at, self.pixel, self.passing = frame.time, pixel, True
        if not self.is_found and (self.frame is None or aside < self.nearest):
            self.frame, self.nearest = frame, aside


class News(NamedTuple):
    """What is to be told of a thing."""

    thing: Thing
    status: str
    """``new``, ``known`` or ``far``."""


class Findings:
    """All that was seen so far: each new frame ``take``, and ``finish`` at the end."""

    def __init__(self, near: float, radius: float, wanted: Callable[[Point], bool]) -> None:
        """Things of a kind that are nearer to each other than ``near`` are one; they are found when
        the vehicle is within ``radius`` of them over the ground, metres; only those at ``wanted``
        places count.
        """
        self._near, self.radius, self._wanted = near, radius, wanted
        self.things: list[Thing] = []
        self.in_view: list[Thing] = []
        """Those seen in the last frame."""

    @property
    def found(self) -> list[Thing]:
        return [thing for thing in self.things if thing.is_found]

    def take(self, frame: Frame, sightings: Iterable[Sighting], ground: Ground) -> list[News]:
        """Take what was seen in a frame."""
        placed = [
            (place, sighting)
            for sighting in sightings
            if (place := _placed(frame, sighting, ground)) and self._wanted(place)
        ]
        seen = self.in_view = self._assigned(placed, frame)
        self._look(frame, ground(*frame.position[:2]), seen)
        return [
            *(news for thing in seen if (news := self._status(thing, frame))),
            *self._passed(frame.time),
        ]

    def _assigned(self, placed: list[tuple[Point, Sighting]], frame: Frame) -> list[Thing]:
        """The things that were seen, each once."""
        pairs = sorted(
            (dist(place[:2], thing.position[:2]), k, number)
            for k, (place, sighting) in enumerate(placed)
            for number, thing in enumerate(self.things)
            if (thing.kind, thing.own_id) == (sighting.kind, sighting.id)
        )
        taken: dict[int, int] = {}
        spare = set(range(len(placed)))
        for distance, k, number in pairs:
            if distance > self._near:
                break
            if k in spare:
                spare.discard(k)
                taken.setdefault(number, k)
        for k in sorted(spare):
            taken[len(self.things)] = k
            self.things.append(Thing(placed[k][1].kind, placed[k][1].id))
        for number, k in taken.items():
            place, sighting = placed[k]
            self.things[number].view(place, sighting.pixel, frame)
        return [self.things[number] for number in taken]

    def _look(self, frame: Frame, ground: float, seen: list[Thing]) -> None:
        """Count the frame for those that it should show whole."""
        if not self.things:
            return
        margin = _MARGIN * frame.intrinsics.fx / max(0.1, frame.position.z - ground)
        pixels = pixels_of(frame, np.array([thing.position for thing in self.things]))
        for thing, inside in zip(self.things, is_inside(frame, pixels, margin), strict=True):
            if inside:
                thing.looks += 1
                thing.hits += any(thing is each for each in seen)

    def _status(self, thing: Thing, frame: Frame) -> News | None:
        """What is to be told of a thing that is in a frame."""
        if thing.is_found or not thing.is_certain or self._is_mistaken(thing):
            return None
        if horizontal_distance(frame.position, thing.position) <= self.radius:
            return self._find(thing)
        if thing.told_far:
            return None
        thing.told_far = True
        return News(thing, "far")

    def _is_mistaken(self, thing: Thing) -> bool:
        """Whether a thing is one that was found, by views that placed it too far away: now that it
        is nearer to it than two are. It is forgotten then.
        """
        mistaken = any(
            (each.kind, each.own_id) == (thing.kind, thing.own_id)
            and dist(each.position[:2], thing.position[:2]) <= self._near
            for each in self.found
        )
        if mistaken:
            self.things = [each for each in self.things if each is not thing]
        return mistaken

    def _find(self, thing: Thing) -> News:
        number = sum(each.kind == thing.kind for each in self.found) + 1
        name = f"{thing.kind}_{thing.own_id or number}"
        taken = sum(name in (each.name, each.name.rpartition("-")[0]) for each in self.found)
        thing.name = f"{name}-{taken + 1}" if taken else name
        return News(thing, "new")

    def _passed(self, now: float) -> Iterable[News]:
        """Those found things that are out of sight again, with a better position."""
        for thing in self.things:
            if thing.is_found and thing.passing and now - thing.seen_at >= _GONE:
                yield _over(thing)

    def finish(self) -> list[News]:
        """The end: what was only seen from afar counts too, and all that was not told is."""
        news = []
        for thing in list(self.things):
            if not thing.is_found and thing.is_certain:
                if self._is_mistaken(thing):
                    continue
                news.append(self._find(thing))
                thing.passing = False
            elif thing.is_found and thing.passing:
                news.append(_over(thing))
        return news

    def progress(self) -> list[dict[str, Any]]:
        """Its state, as JSON, without frames."""
        return [
            {name: value for name, value in vars(thing).items() if name != "frame"}
            for thing in self.things
        ]

    def resume(self, progress: Iterable[Mapping[str, Any]]) -> None:
        """Go on from the progress of others."""
        self.things = [Thing(**thing) for thing in progress]


def _over(thing: Thing) -> News:
    """A found thing is passed."""
    thing.passing, thing.is_known = False, True
    return News(thing, "known")


def _placed(frame: Frame, sighting: Sighting, ground: Ground) -> Point | None:
    """The place on the ground where a thing stands; None for one that is not below."""
    level = ground(*frame.position[:2])
    place = None
    for _ in range(2):  # first on the level of what is straight below, then on its own
        place = ground_point(frame, sighting.pixel, level + sighting.height)
        if place is None:
            return None
        level = ground(place.x, place.y)
    return place and place._replace(z=level)
