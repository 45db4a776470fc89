"""The values of `vehicle` in expressions: the observation, in the mission frame."""

from __future__ import annotations

from math import pi

import pytest

from behaviors.vocabulary import VEHICLE
from hal.fake import FakeSession
from tests.behaviors.flying import Rig
from vencejo.geometry import Point

ON_GROUND = {
    "position": "(0.00, 0.00, 0.00)",
    "velocity": "(0.00, 0.00, 0.00)",
    "yaw": "1.5708",
    "altitude": "0",
    "speed": "0",
    "battery": "0.75",
    "armed": "false",
    "flying": "false",
    "mode": "landed",
    "authority": "mission",
    "home": "(-10.00, -5.00, 0.00)",
    "wind": "(3.00, -4.00, 0.00)",
}
IN_FLIGHT = {
    # Of the period of 25 ms before, at 2 m/s to the north and 1 m/s up.
    "position": "(3.00, 4.05, 6.03)",
    "velocity": "(0.00, 2.00, 1.00)",
    "yaw": "1.5708",
    "altitude": "6.025",
    "speed": "2.23607",
    "battery": "0.75",
    "armed": "true",
    "flying": "true",
    "mode": "flying",
    "authority": "mission",
    "home": "(-10.00, -5.00, 0.00)",
    "wind": "(3.00, -4.00, 0.00)",
}


def reporting(names: tuple[str, ...]) -> Rig:
    """A mission that logs these values when asked, of a vehicle that starts far from its home."""
    session = FakeSession()
    vehicle = session.vehicles["drone"]
    vehicle.position, vehicle.yaw, vehicle.battery = Point(10.0, 5.0, 0.0), pi / 2, 0.75
    vehicle.estimated_wind = Point(3.0, -4.0, 0.0)
    vehicle.capabilities |= {"wind"}
    text = "; ".join(f"${{vehicle.{name}}}" for name in names)
    return Rig(
        "mission: report\nevents: {report.wanted: {}}\n"
        f"on: {{report.wanted: {{actions: {{log: '{text}'}}}}}}\n"
        "states:\n"
        "  wait: {after: {1 s: takeoff}}\n"
        "  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: fly}}\n"
        "  fly: {do: move, with: {forward: 2 m/s, up: 1 m/s}, after: {9 s: land}}\n"
        "  land: {do: land, on: {done: end}}\n  end: {type: final}\n",
        session=session,
    )


def told(rig: Rig) -> list[str]:
    """What the mission logs in the next period."""
    before = len(rig.records)
    rig.pilot.instance.post("report.wanted")
    rig.period()
    (text,) = [fields["text"] for kind, fields in rig.records[before:] if kind == "log"]
    return str(text).split("; ")


def test_every_value_is_the_vehicle_s_in_the_mission_frame() -> None:
    assert set(ON_GROUND) == set(IN_FLIGHT) == set(VEHICLE)
    rig = reporting(tuple(VEHICLE))
    assert dict(zip(VEHICLE, told(rig), strict=True)) == ON_GROUND
    rig.until_in("fly")
    rig.run(1)
    rig.vehicle.position = Point(13.0, 9.0, 6.0)
    assert dict(zip(VEHICLE, told(rig), strict=True)) == IN_FLIGHT


@pytest.mark.parametrize("who", ["operator", "autopilot", "none"])
def test_the_authority_is_who_commands_it_now(who: str) -> None:
    rig = reporting(("authority",))
    assert told(rig) == ["mission"]
    setattr(rig.vehicle, "authority", who)  # noqa: B010 (a literal type)
    assert told(rig) == [who]


@pytest.mark.parametrize(
    ("state", "mode"), [("wait", "landed"), ("takeoff", "taking-off"), ("land", "landing")]
)
def test_the_mode_is_the_vehicle_s_own_word(state: str, mode: str) -> None:
    rig = reporting(("mode",))
    rig.until_in(state)
    rig.run(0.1)
    assert told(rig) == [mode]


@pytest.mark.parametrize(
    ("condition", "state"),
    [
        ("vehicle.velocity.z > 0.9", "takeoff"),
        ("vehicle.velocity.z > 0.9 m/s", "takeoff"),
        ("vehicle.wind.y < -3 m/s and hypot(vehicle.wind.x, vehicle.wind.y) > 4 m/s", "fly"),
        ("vehicle.speed > 1.9 m/s", "takeoff"),
        ("vehicle.armed", "takeoff"),
        ("vehicle.flying", "takeoff"),
        ("vehicle.mode == 'flying'", "takeoff"),
        ("vehicle.position.y > 3 m and vehicle.altitude > 4 m", "fly"),
        ("distance(vehicle.position, vehicle.home) > 12 m", "fly"),
        ("vehicle.yaw < 80 deg", "fly"),
        ("vehicle.battery < 50 %", "fly"),
    ],
)
def test_conditions_wait_for_them(condition: str, state: str) -> None:
    """Each becomes true in the state that makes it so, and not before."""
    session = FakeSession()
    session.vehicles["drone"].yaw = pi / 2
    session.vehicles["drone"].estimated_wind = Point(0.0, -2.0, 0.0)
    session.vehicles["drone"].capabilities |= {"wind"}
    rig = Rig(
        "mission: conditions\nstates:\n"
        f'  flight:\n    when: {{"{condition}": seen}}\n    states:\n'
        "      wait: {after: {1 s: takeoff}}\n"
        "      takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: fly}}\n"
        "      fly: {do: move, with: {forward: 2 m/s, up: 1 m/s, yaw_rate: -5 deg/s}, "
        "after: {30 s: land}}\n"
        "  seen: {after: {1 s: land}}\n"
        "  land: {do: land, on: {done: end}}\n  end: {type: final}\n",
        session=session,
    )
    rig.until_in(f"flight.{state}")
    rig.run(0.5)
    rig.vehicle.battery = 0.4 if state == "fly" else 1.0
    if state == "fly":
        rig.vehicle.estimated_wind = Point(3.0, -4.0, 0.0)
    rig.until_in("seen")
    assert rig.states[-2] == f"flight.{state}"


def test_a_vehicle_that_estimates_no_wind_says_so() -> None:
    rig = reporting(("wind",))
    rig.vehicle.estimated_wind = None
    rig.run(0.1)
    rig.pilot.instance.post("report.wanted")
    rig.period()
    (message,) = [fields["message"] for kind, fields in rig.records if kind == "error"]
    assert message == "log: this vehicle does not estimate the wind"
