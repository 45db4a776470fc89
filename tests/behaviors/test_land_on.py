"""land_on."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import hypot, pi
from typing import Any

import numpy as np
import pytest

from behaviors.land_on import BLIND, COMMIT, LandOn
from behaviors.plan import UNKNOWN, PlanStart, Unflyable
from hal.scene.arrays import Pixels
from hal.vehicle import PERIOD, Position, Setpoint
from tests.behaviors.flying import Solo
from tests.behaviors.perception.markers import marker_of
from tests.behaviors.sighted import Look, shown, sighted
from tests.hal.scenes import ROAD, world_of
from vencejo.geometry import Point, Pose, horizontal_distance, wrap, yaw_quaternion
from worlds.motion import pose_at
from worlds.things import Fiducial, Motion, Thing

INSIDE = {"id": 9, "size": 0.12}
MARKER = {"id": 5, "size": 0.5, "dictionary": "6X6_250", "inside": INSIDE}
NESTED = Fiducial("6X6_250", 5, Fiducial("4X4_50", 9), 0.16 / 0.625)
START = PlanStart(Point(0.0, 0.0, 3.0), 0.0, True, 0.0, 15.0)


def pad_at(x: float, y: float, speed: float = 0.0, heading: float = 0.0) -> Thing:
    """A marker with another one inside, which lies on the ground; it moves to the north."""
    pad = marker_of("6X6_250", 5, Point(x, y, 0.0), 0.5, yaw_quaternion(heading))
    part = replace(pad.parts[0], texture=NESTED)
    path = Point(x, y, 0.0), Point(x, y + 100.0, 0.0)
    motion = Motion(path, speed, loop=False, turns=False) if speed else None
    return replace(pad, parts=(part,), motion=motion)


def landing(look: Look, values: dict[str, Any] | None = None, height: float = 3.0) -> Solo:
    given = {"marker": MARKER, **(values or {})}
    return Solo("land_on", given, vehicle=sighted(look, height))


def seen_of(pad: Thing) -> Look:
    return shown(world_of(pad, ground=ROAD))


def hidden(look: Look, when: Callable[[Pose, float], bool]) -> Look:
    """A look that is black at times."""

    def hide(pose: Pose, time: float) -> Pixels | None:
        image = look(pose, time)
        return np.zeros_like(image) if image is not None and when(pose, time) else image

    return hide


@pytest.mark.parametrize("speed", [pytest.param(0.0, marks=pytest.mark.slow), 1.0])
def test_it_lands_in_the_middle_of_a_pad(speed: float) -> None:
    pad = pad_at(0.6, -0.8, speed)
    solo = landing(seen_of(pad))
    touched = None
    while solo.outcome is None and solo.time < 40:
        solo.step()
        if touched is None and not solo.vehicle.observe().flying:
            touched = horizontal_distance(solo.vehicle.position, pose_at(pad, solo.time)[0])
    assert solo.outcome is not None and solo.word == "done"
    assert touched is not None and touched < 0.03
    assert solo.outcome.fields["distance"] < 0.03 and solo.outcome.fields["tries"] == 0
    assert solo.vehicle.observe().mode == "landed"
    last = solo.activity.published
    assert last.phase == "landing"
    assert last.velocity.y == pytest.approx(speed, abs=0.05)


@pytest.mark.slow
def test_it_descends_only_where_it_is_over_the_pad() -> None:
    """Its way lies in a cone above the pad, and the last of it is straight."""
    pad = pad_at(1.2, 0.9)
    solo = landing(seen_of(pad))
    track = []
    while solo.outcome is None and solo.time < 40:
        solo.step()
        track.append(solo.vehicle.position)
    off = [(place.z, hypot(place.x - 1.2, place.y - 0.9)) for place in track]
    assert all(far < 0.15 + 0.3 * height for height, far in off if height < 2.3)
    assert all(far < 0.06 for height, far in off if height < COMMIT)


@pytest.mark.slow
def test_it_waits_through_a_short_loss() -> None:
    look = hidden(seen_of(pad_at(0.3, 0.2, 0.5)), lambda _, time: 5.0 < time < 5.0 + BLIND - 0.4)
    solo = landing(look)
    solo.run(40)
    assert solo.outcome is not None and solo.word == "done"
    assert solo.outcome.fields["tries"] == 0


def test_it_climbs_and_looks_again_when_it_has_lost_the_pad() -> None:
    look = hidden(seen_of(pad_at(0.3, 0.2)), lambda _, time: 5.0 < time < 9.0)
    solo = landing(look)
    heights = []
    while solo.outcome is None and solo.time < 60:
        solo.step()
        heights.append(solo.vehicle.position.z)
    assert solo.outcome is not None and solo.word == "done"
    assert solo.outcome.fields["tries"] == 1
    hidden_at, shown_at = (round((t - solo.time) / PERIOD) - 1 for t in (5.0, 9.0))
    assert heights[shown_at] > heights[hidden_at] + 0.5


def test_without_a_pad_it_ends_in_the_air_over_where_it_began() -> None:
    look = shown(world_of(ground=ROAD))
    solo = landing(look, {"patience": 2.0, "tries": 2, "highest": 6.0})
    began = solo.time
    solo.run(60)
    assert solo.word == "lost" and solo.time - began == pytest.approx(6.0, abs=0.1)
    x, y, z = solo.vehicle.position
    assert hypot(x, y) < 1.5 and 4.0 < z <= 6.05
    assert solo.vehicle.observe().mode == "flying" and "land" not in solo.vehicle.verbs


def test_a_pad_that_is_gone_for_good_is_never_landed_beside() -> None:
    look = hidden(seen_of(pad_at(0.3, 0.2)), lambda pose, _: pose[0].z < 1.0)
    solo = landing(look, {"patience": 2.0, "tries": 1})
    low = []
    while solo.outcome is None and solo.time < 90:
        solo.step()
        low.append(solo.vehicle.position.z)
    assert solo.word == "lost" and min(low) > COMMIT
    assert "land" not in solo.vehicle.verbs and solo.vehicle.position.z > 1.0


@pytest.mark.slow
def test_without_a_marker_inside_it_comes_down_from_where_it_sees_the_whole_one() -> None:
    """A marker of one metre is in view from 1.85 m on: higher than it was asked to begin from."""
    pad = marker_of("6X6_250", 5, Point(0.3, 0.2, 0.0), 1.0)
    marker = {"id": 5, "size": 1.0, "dictionary": "6X6_250"}
    solo = landing(seen_of(pad), {"marker": marker, "height": 1.5})
    heights = {}
    while solo.outcome is None and solo.time < 40:
        solo.step()
        heights.setdefault(solo.activity.published.phase, solo.vehicle.position.z)
    assert solo.outcome is not None and solo.word == "done"
    assert heights["landing"] == pytest.approx(1.85, abs=0.15)
    assert horizontal_distance(solo.vehicle.position, (0.3, 0.2, 0.0)) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("align", [0.0, 1.0])
def test_it_can_turn_its_nose_along_the_pad(align: float) -> None:
    solo = landing(seen_of(pad_at(0.2, 0.1, heading=-0.5)), {"align": align})
    solo.run(40)
    assert solo.word == "done"
    # The top of a marker that lies points north before it is turned.
    assert wrap(solo.vehicle.yaw - (pi / 2 - 0.5 + align)) == pytest.approx(0.0, abs=0.05)


@pytest.mark.slow
def test_it_goes_on_where_it_was() -> None:
    pad = pad_at(0.3, 0.2, 0.5)
    solo = landing(seen_of(pad))
    solo.run(4.0)
    progress = solo.activity.progress()
    assert json.loads(json.dumps(progress)) == progress
    solo.activity.stop()
    vehicle = solo.session, solo.vehicle
    again = Solo("land_on", {"marker": MARKER}, progress=progress, vehicle=vehicle)
    again.run(40)
    assert again.word == "done"


def test_on_the_ground_it_is_done_on_the_pad_and_has_failed_elsewhere() -> None:
    pad = pad_at(0.1, 0.0)
    solo = landing(seen_of(pad), height=1.0)
    solo.run(30)
    assert solo.word == "done"
    progress, vehicle = solo.activity.progress(), (solo.session, solo.vehicle)
    solo.activity.stop()
    again = Solo("land_on", {"marker": MARKER}, progress=progress, vehicle=vehicle)
    again.step()
    assert again.word == "done"
    solo.vehicle.position = Point(3.0, 0.0, 0.0)
    solo.session.wait()
    for told in (progress, None):
        elsewhere = Solo("land_on", {"marker": MARKER}, progress=told, vehicle=vehicle)
        assert elsewhere.step() is None
        assert elsewhere.outcome is not None and elsewhere.word == "failed"
        assert "stands on the ground, not on the pad" in elsewhere.outcome.fields["reason"]


def pictures() -> dict[str, Callable[[Pixels], Pixels]]:
    noise = np.random.default_rng(1).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    return {
        "black": np.zeros_like,
        "white": lambda image: np.full_like(image, 255),
        "red": lambda image: np.full_like(image, (0, 0, 255)),
        "tiny": lambda image: np.ascontiguousarray(image[:16, :16]),
        "noise": lambda image: noise,
        "rotated": lambda image: np.ascontiguousarray(np.rot90(image)),
        "upside down": lambda image: np.ascontiguousarray(image[::-1, ::-1]),
        "jumping": lambda image: np.roll(image, int(noise[0, 0, 0]) * int(image[0, 0, 0]), 1),
    }


def no_jumps(commanded: list[Setpoint | None]) -> None:
    """Whether speed and acceleration of what was commanded are bounded."""
    places = [each for each in commanded if isinstance(each, Position)]
    assert places
    for before, after in pairwise(places):
        assert before.velocity is not None and after.velocity is not None
        assert after.velocity.minus(before.velocity).norm() < 4.5 * PERIOD
        assert after.velocity.norm() < 4.5
        assert after.xyz.minus(before.xyz).norm() < 5.0 * PERIOD


QUICK = ("black", "tiny")


@pytest.mark.parametrize(
    "kind",
    [kind if kind in QUICK else pytest.param(kind, marks=pytest.mark.slow) for kind in pictures()],
)
def test_no_picture_makes_it_jump(kind: str) -> None:
    change, look = pictures()[kind], seen_of(pad_at(0.4, 0.3, 0.5))

    def changed(pose: Pose, time: float) -> Pixels | None:
        image = look(pose, time)
        return image if image is None or time % 1.0 < 0.5 else change(image)

    solo = landing(changed)
    commanded = []
    while solo.outcome is None and solo.time < 6:
        commanded.append(solo.step())
    assert solo.word in (None, "done")
    no_jumps(commanded)


@pytest.mark.parametrize(
    ("marker", "message"),
    [
        (5, "a marker is {id: …, size: …, dictionary: …, inside: {…}}"),
        ({"size": 0.5}, "a marker has an `id`, a whole number"),
        ({"id": 5}, "its `size` is needed"),
        ({"id": 5, "size": 0.5, "dictionary": "4X4"}, "no marker dictionary is called '4X4'"),
        ({"id": 50, "size": 0.5}, "4X4_50 has the markers 0 to 49, not 50"),
        ({"id": 5, "size": 0.5, "inside": INSIDE}, "needs another dictionary"),
        ({"id": 5, "size": 0.1, "dictionary": "6X6_250", "inside": INSIDE}, "smaller than"),
        ({"id": 5, "size": 0.5, "with": 3}, "'with' is not known here"),
    ],
)
def test_a_marker_that_cannot_be_is_told_before_the_flight(marker: Any, message: str) -> None:
    params = LandOn.Params(marker=marker)
    with pytest.raises(Unflyable) as error:
        LandOn.plan(params, START)
    assert message in str(error.value) and error.value.parameter == "marker"
    failed = landing(shown(world_of()), {"marker": marker})
    failed.step()
    assert failed.outcome is not None and failed.word == "failed"
    assert message in failed.outcome.fields["reason"]


@pytest.mark.parametrize("marker", [UNKNOWN, {"id": UNKNOWN, "size": 0.5}, MARKER])
def test_a_marker_that_is_known_in_flight_only_may_be(marker: Any) -> None:
    assert LandOn.plan(LandOn.Params(marker=marker), START) is None
