"""sweep_detect: searches an area, and tells, photographs and locates what is in it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from math import dist, pi, tan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from behaviors import PlanStart, Sighting, describe, detector
from behaviors.detector import describe_detector
from behaviors.plan import Unflyable
from behaviors.sweep_detect import SweepDetect
from fsm.host import BehaviorInfo
from hal.fake import FakeSession, FakeVehicle
from hal.scene.arrays import Pixels
from hal.vehicle import Frame
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import Look, shown, sighted
from vencejo.geometry import Point, Pose
from worlds import World, load_world

INFO = describe(SweepDetect)
FIELD = [Point(-2, -3, 0), Point(10, -3, 0), Point(10, 5, 0), Point(-2, 5, 0)]
WORLD = """\
world: patch
start: {at: [40, 40]}
people: {walker: {at: [3, 1.5], heading: 20 deg, color: orange, lying: true}}
spheres: {ball: {at: [7, -1.5], radius: 30 cm, color: orange}}
markers: {seven: {at: [0, 3], id: 7, size: 50 cm}}
boxes:
  crate: {at: [8, 3], size: [0.55, 0.55, 0.55], heading: 30 deg, color: orange}
"""
DETECT = [
    "people",
    {"color": {"color": "orange", "size": 0.6, "shape": "round", "kind": "ball"}},
    {"fiducials": {"ids": [3, 7]}},
]
TRUE = {"person_1": (3.0, 1.5), "ball_1": (7.0, -1.5), "marker_7": (0.0, 3.0)}
VALUES = {"area": FIELD, "detect": DETECT, "height": 5.0}


@cache
def patch() -> World:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "patch.yaml"
        path.write_text(WORLD)
        return load_world(path)


class Search(Solo):
    """The behaviour over a world, with the photos that it keeps."""

    def __init__(
        self,
        values: Mapping[str, Any],
        look: Look | None = None,
        *,
        info: BehaviorInfo = INFO,
        progress: Mapping[str, Any] | None = None,
        vehicle: tuple[FakeSession, FakeVehicle] | None = None,
    ) -> None:
        flown = vehicle or sighted(look or shown(patch()), 5.0)
        super().__init__(info, values, progress=progress, vehicle=flown)
        self.photos: list[str] = []
        self.drawn: list[Pixels] = []
        self.channel.on_photo = lambda name, camera, frame: self.photos.append(name)
        self.channel.on_picture = lambda name, draw: self.drawn.append(draw())

    def told(self, status: str) -> dict[str, Point]:
        return {
            fields["id"]: fields["position"]
            for name, fields in self.events
            if name == "thing.found" and fields["status"] == status
        }


@cache
def flown() -> Search:
    search = Search(VALUES)
    search.run(100)
    return search


def test_it_finds_all_and_nothing_else_and_says_where() -> None:
    search = flown()
    assert search.word == "done"
    assert set(search.told("new")) == set(search.told("known")) == set(TRUE)
    for name, place in TRUE.items():
        assert dist(search.told("known")[name][:2], place) < 0.05
    assert sorted(search.photos) == sorted(TRUE)
    for _, fields in search.events:
        assert fields["kind"] in ("person", "ball", "marker")
        assert fields["picture"] == ("" if fields["status"] == "far" else fields["id"])
    published = search.activity.published
    assert (published.count, published.far, published.progress) == (3, 0, 1.0)


def test_it_shows_what_it_sees() -> None:
    pictures = flown().drawn
    assert len(pictures) > 100 and all(each.shape == (240, 320, 3) for each in pictures)
    green, blue = np.array([60, 210, 60]), np.array([240, 120, 30])
    assert any((each == green).all(-1).sum() > 20 for each in pictures)
    assert any((each == blue).all(-1).sum() > 20 for each in pictures)


def test_the_lanes_are_as_far_apart_as_the_picture_is_wide_less_the_overlap() -> None:
    search = flown()
    # 60° see 5.77 m from a height of 5 m; 8 m are two lanes of what is left.
    footprint = search.activity.progress()["footprint"]  # type: ignore[index]
    assert footprint[0] == pytest.approx(2 * 5 * tan(pi / 6) * 0.75, rel=0.02)
    assert search.activity.published.lanes == 2


def test_it_goes_on_where_it_was_with_what_it_has_found() -> None:
    search = Search(VALUES)
    while len(search.told("new")) < 2:
        search.step()
    before = dict(search.told("new"))
    progress = search.activity.progress()
    search.activity.stop()
    other = Search(VALUES, progress=progress, vehicle=(search.session, search.vehicle))
    other.run(100)
    assert other.word == "done"
    assert {*before, *other.told("new")} == set(TRUE)
    assert not {*before} & {*other.told("new")}
    assert other.activity.published.count == 3


def blind(pose: Pose, time: float) -> None:
    """A camera that gives no picture."""


def test_without_a_picture_it_waits() -> None:
    search = Search(VALUES, blind)
    here = search.vehicle.position
    search.run(5)
    assert search.outcome is None and dist(search.vehicle.position, here) < 0.01
    progress = search.activity.progress()
    assert progress is not None and progress["things"] == []


def test_with_a_spacing_it_sets_out_at_once_and_has_a_plan() -> None:
    start = PlanStart(Point(0, 0, 5), 0.0, True, 0.0, 5.0)
    defaults = {name: parameter.default for name, parameter in INFO.parameters.items()}
    values = {**defaults, **VALUES, "spacing": 4.0}
    legs = SweepDetect.plan(SweepDetect.Params(**values), start)
    assert legs is not None and {leg.to.z for leg in legs} == {5.0}
    search = Search({**VALUES, "spacing": 4.0}, blind)
    track = []
    while search.run(0.025) is None and search.time < 100:
        track.append(search.vehicle.position)
    assert search.word == "done" and search.events == []
    assert all(min(dist(leg.to, at) for at in track) <= 0.5 for leg in legs)
    # What only the flight knows has none.
    for unknown in ({"spacing": None}, {"above": "ground"}):
        assert SweepDetect.plan(SweepDetect.Params(**{**values, **unknown}), start) is None
    with pytest.raises(Unflyable):
        SweepDetect.plan(SweepDetect.Params(**{**values, "detect": ["peple"]}), start)


def test_above_ground_it_follows_the_ground() -> None:
    places = []
    hill = Search({**VALUES, "spacing": 4.0, "above": "ground"}, blind)
    hill.channel.frame.ground_height = lambda x, y: 0.2 * x
    while hill.run(0.025) is None and hill.time < 100:
        places.append(hill.vehicle.position)
    assert hill.word == "done"
    on_lanes = [at for at in places[200:] if -1 < at.x < 9]
    assert all(abs(at.z - 0.2 * at.x - 5.0) < 0.4 for at in on_lanes)


def test_pictures_while_tilted_are_not_looked_at() -> None:
    tilted = Search({**VALUES, "roll_pitch_thr": 0.1})
    observe = tilted.vehicle.observe
    lean = (0.1, 0.0, 0.0, 0.995)
    tilted.vehicle.observe = lambda: observe()._replace(attitude=lean)  # type: ignore[method-assign]
    while tilted.activity.published.lane < 2:
        tilted.step()
    assert tilted.events == []


@pytest.mark.parametrize("size", [(240, 320), (16, 16)])
@pytest.mark.parametrize("value", [0, (20, 130, 245)])
def test_blank_pictures_change_nothing_of_the_flight(size: tuple[int, int], value: Any) -> None:
    image = np.empty((*size, 3), np.uint8)
    image[:] = value
    search = Search({**VALUES, "spacing": 6.0}, lambda pose, time: image)
    last, fastest = search.vehicle.position, 0.0
    while search.run(0.025) is None and search.time < 100:
        fastest = max(fastest, dist(search.vehicle.position, last) / 0.025)
        last = search.vehicle.position
    assert search.word == "done" and search.events == []
    assert fastest < 2.2


@detector
def find_bright(frame: Frame, ground: float, least: int = 200) -> list[Sighting]:
    """The middle of all that is brighter than ``least``."""
    y, x = np.nonzero(frame.image.min(-1) >= least)
    return [Sighting("light", (float(x.mean()), float(y.mean())))] if len(x) else []


@detector
def break_down(frame: Frame, ground: float) -> list[Sighting]:
    raise ValueError("no more")


def test_a_detector_of_ones_own_is_used() -> None:
    own = {each.__name__: describe_detector(each) for each in (find_bright, break_down)}
    known = type("SweepDetect", (SweepDetect,), {"detectors": own})
    info = describe(known, "sweep_detect")
    search = Search({**VALUES, "detect": [{"find_bright": {"least": 230}}]}, info=info)
    search.run(100)
    assert search.word == "done"
    assert dist(search.told("known")["light_1"][:2], (0.0, 3.0)) < 0.1
    broken = Search({**VALUES, "detect": ["break_down"]}, info=info)
    broken.run(5)
    assert broken.outcome is not None and broken.word == "failed"
    line = break_down.__code__.co_firstlineno + 2
    reason = broken.outcome.fields["reason"]
    assert reason == f"ValueError: no more (test_sweep_detect.py:{line})"


def test_a_camera_that_looks_ahead_searches_nothing() -> None:
    search = Search({**VALUES, "camera": "front"})
    outcome = search.run(1.0)
    assert outcome is not None and outcome.word == "failed"
    assert "the camera 'front' does not look down" in outcome.fields["reason"]
