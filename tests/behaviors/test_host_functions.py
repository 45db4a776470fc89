"""Limits and lights that missions set by `call`, and pictures that they keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hal import Lights
from hal.base import BaseVehicle
from hal.fake import FakeVehicle
from hal.vehicle import Frame, Intrinsics, Velocity
from tests.behaviors.flying import Rig
from vencejo.errors import UserError
from vencejo.geometry import Point

ROOM = """
mission: out_of_the_room
description: A low ceiling indoors, raised once outside.
states:
  takeoff:
    entry: {call: {limits: {max_altitude: 2.5 m, min_altitude: 50 cm}}}
    do: takeoff
    with: {altitude: 2 m}
    on: {done: inside}
  inside: {do: move, with: {up: 1 m/s, forward: 1 m/s}, after: {4 s: outside}}
  outside:
    entry: {call: {limits: {max_altitude: 8 m}}}
    do: move
    with: {up: 1 m/s}
    after: {4 s: land}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


def test_a_low_ceiling_indoors_is_raised_outside() -> None:
    rig = Rig(ROOM)
    rig.until_in("outside")
    assert rig.vehicle.position.z == pytest.approx(2.5)
    rig.until_in("land")
    assert rig.vehicle.position.z == pytest.approx(6.5, abs=0.1)
    rig.run(30)
    assert rig.pilot.outcome == "done" and rig.vehicle.position.z == 0


def call(*actions: str, photos: list[tuple[str, str]] | None = None) -> Rig:
    """A mission that calls these while it hovers, and goes on after errors; the name and camera of
    each photo is added to ``photos``.
    """
    entry = "[" + ", ".join(f"{{call: {action}}}" for action in actions) + "]"
    rig = Rig(
        "mission: m\nstates:\n  up: {do: takeoff, on: {done: fly, failed: down}}\n"
        f"  fly: {{entry: {entry}, do: hover, after: {{1 s: down}}, "
        'on: {error.execution: {actions: {log: "$event.message"}}}}\n'
        "  down: {do: land, on: {done: end, failed: end}}\n  end: {type: final}\n"
    )
    if photos is not None:
        rig.pilot.channel.on_photo = lambda name, camera, frame: photos.append((name, camera))
    rig.until_in("fly")
    rig.period()
    rig.period()
    return rig


def logged(rig: Rig) -> str:
    return "".join(fields["text"] for kind, fields in rig.records if kind == "log")


def test_a_profile_is_taken_whole_and_single_limits_go_over_it() -> None:
    rig = call("{limits: {profile: indoor, max_altitude: 3 m}}")
    assert logged(rig) == ""
    assert (rig.vehicle.limits.max_speed, rig.vehicle.limits.max_altitude) == (1.0, 3.0)


@pytest.mark.parametrize(
    ("action", "told"),
    [
        ("{limits: {profile: indor}}", "there is no profile 'indor' (did you mean 'indoor'?)"),
        ("{limits: {max_altitude: 1 m, min_altitude: 2 m}}", "must be below"),
        ("{limits: {max_speed: 0 m/s}}", "'max_speed' must be a number above 0"),
        ("{limits: {profile: indoor, max_speed: 0 m/s}}", "'max_speed' must be a number above 0"),
        ("{limits: {min_altitude: 200 m, max_altitude: 100 m}}", "must be below"),
    ],
)
def test_a_refused_limit_is_an_error_of_the_mission(action: str, told: str) -> None:
    rig = call(action)
    assert told in logged(rig)
    assert rig.vehicle.limits.max_speed == 5.0


def test_what_the_vehicle_refuses_is_an_error_too() -> None:
    rig = call("{limits: {max_altitude: 1 m}}")
    assert logged(rig) == ""
    again = call("{limits: {min_altitude: 10 m}}")
    assert logged(again) == ""
    refused = call("{limits: {max_altitude: 4 m}}", "{limits: {min_altitude: 5 m}}")
    assert "lowest altitude is above the highest" in logged(refused)


def test_lights() -> None:
    rig = call("{lights: {pattern: blink, color: green, rate: 2 Hz, duration: 3 s}}")
    assert rig.vehicle.shown == [Lights("blink", "green", 2.0, 3.0)]
    with pytest.raises(UserError) as refused:
        call("{lights: {color: mauve}}")
    assert refused.value.code in ("unknown-word", "wrong-type")


def test_a_limit_holds_for_set_points() -> None:
    rig = call("{limits: {max_speed: 50 cm/s}}")
    rig.vehicle.command(Velocity(x=3.0))
    rig.session.wait()
    assert rig.vehicle.observe().velocity.x == pytest.approx(0.5)


class Still:
    """A camera that shows one frame."""

    def __init__(self, frame: Frame | None) -> None:
        self.frame = frame

    def latest(self) -> Frame | None:
        return self.frame


@pytest.fixture
def picture(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[Rig, list[Any]]]:
    """Runs a mission with an action that keeps a picture; gives it, and the photos kept."""

    def run(
        action: str, active: str | None = "ventral", covered: bool = False
    ) -> tuple[Rig, list[Any]]:
        image, lens = np.zeros((8, 10, 3), np.uint8), Intrinsics.from_field_of_view(10, 8, 1.0)
        frame = Frame(image, 7, 0.1, lens, Point(0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        cameras = {"front": Still(frame), "ventral": Still(None if covered else frame)}
        kept: list[Any] = []
        monkeypatch.setattr(FakeVehicle, "active_camera", active)
        monkeypatch.setattr(
            FakeVehicle,
            "camera",
            lambda self, name: cameras[name] if name in cameras else BaseVehicle.camera(self, name),
        )
        return call(action, photos=kept), kept

    return run


def test_a_picture_of_the_active_camera_is_kept_under_its_name(
    picture: Callable[..., tuple[Rig, list[Any]]],
) -> None:
    assert picture('{save_picture: {name: "tag_${3 + 4}"}}')[1] == [("tag_7", "ventral")]
    named = "{save_picture: {name: gate, camera: front}}"
    assert picture(named, active=None)[1] == [("gate", "front")]


@pytest.mark.parametrize(
    ("action", "active", "covered", "told"),
    [
        ('{save_picture: {name: "../x"}}', "ventral", False, "'../x' is no name of a picture"),
        ("{save_picture: {name: x}}", None, False, "say which `camera` the picture is of"),
        ("{save_picture: {name: x}}", "ventral", True, "'ventral' has taken no picture yet"),
        ("{save_picture: {name: x, camera: rear}}", "ventral", False, "rear"),
    ],
)
def test_a_picture_that_cannot_be_kept(
    picture: Callable[..., tuple[Rig, list[Any]]],
    action: str,
    active: str | None,
    covered: bool,
    told: str,
) -> None:
    rig, kept = picture(action, active, covered)
    assert kept == []
    assert told in logged(rig)
