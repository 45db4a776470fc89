"""The simulated rangefinder, which looks down from a vehicle."""

from __future__ import annotations

from math import cos, inf
from typing import Any

import pytest

from hal.engines import open_engine
from hal.sim import MODELS, SimSession, open_session
from hal.sim.sensors.rangefinder import RangefinderSpec
from hal.sim.sensors.sampling import newest_capture
from hal.vehicle import Options, Position, Reading, Sensor, Unavailable, Velocity
from tests.hal.flying import LONG, named, only, take_off, wait
from vencejo.errors import UserError
from vencejo.geometry import Point, roll_pitch_of
from worlds.loader import read_world

CAPABILITIES = MODELS.find(None).capabilities
SKIDS = 0.06
"""Height of the centre of mass above the skids, metres."""
TABLE = "boxes: {table: {at: [3, 0], size: [2, 2, 1]}}\n"
TROLLEY = """\
boxes: {trolley: {size: [1, 1, 0.5], moves: {through: [[0, 4], [0, -4]], speed: 2, turns: false}}}
"""


def session_on(text: str = "", vehicles: tuple[str, ...] = ("drone",), **down: Any) -> SimSession:
    world = read_world(f"world: test\nstart: {{at: [0, 8]}}\n{text}", "test.yaml")
    return SimSession(
        Options(named(*vehicles), settings={"sensors": {"down": down}}), world, open_engine()
    )


def reading_of(session: SimSession, name: str = "drone") -> Reading:
    reading = session.vehicles[name].sensor("down").latest()
    assert reading is not None
    return reading


def fly_to(session: SimSession, x: float, y: float, z: float) -> None:
    take_off(session, z)
    wait(session, 8, Position(Point(x, y, z)))


def test_a_vehicle_has_one_only_where_the_settings_ask_for_it() -> None:
    with open_session(Options()) as session:
        drone = session.vehicles["drone"]
        assert drone.capabilities == CAPABILITIES
        assert not any(word.startswith("sensor.") for word in CAPABILITIES)
        with pytest.raises(Unavailable, match=r"no sensor 'down' \(it has: none\)"):
            drone.sensor("down")
    with session_on() as session:
        drone = session.vehicles["drone"]
        assert drone.capabilities == CAPABILITIES | {"sensor.down"}
        assert isinstance(drone.sensor("down"), Sensor)
        with pytest.raises(Unavailable, match=r"no sensor 'up' \(it has: down\)"):
            drone.sensor("up")


def test_it_measures_from_the_centre_of_mass_to_what_is_below() -> None:
    with session_on(TABLE) as session:
        assert reading_of(session) == Reading(0.0, {"distance": pytest.approx(SKIDS, abs=1e-6)})
        for x, top in ((0.0, 0.0), (3.0, 1.0), (4.5, 0.0)):
            fly_to(session, x, 0.0, 3.0)
            height = only(session).observe().position.z
            distance = reading_of(session).values["distance"]
            assert distance == pytest.approx(height + SKIDS - top, abs=0.01)


def test_nothing_within_its_range_is_infinitely_far() -> None:
    with session_on(max_range=2.0) as session:
        fly_to(session, 0, 0, 1.9)
        assert reading_of(session).values["distance"] == pytest.approx(1.96, abs=0.01)
        fly_to(session, 0, 0, 2.1)
        assert reading_of(session).values == {"distance": inf}


def test_it_leans_with_the_vehicle() -> None:
    with session_on(rate=240) as session:
        fly_to(session, 0, 0, 3.0)
        drone = only(session)
        drone.command(Velocity(x=4.0), LONG)
        wait(session, 0.4)
        seen = drone.observe()
        roll, pitch = roll_pitch_of(seen.attitude)
        assert pitch > 0.2
        slant = (seen.position.z + SKIDS) / (cos(pitch) * cos(roll))
        assert reading_of(session).values["distance"] == pytest.approx(slant, rel=1e-6)


def test_it_looks_through_vehicles() -> None:
    with session_on("", ("above", "below")) as session:
        for name, height in (("above", 3.0), ("below", 1.0)):
            session.vehicles[name].takeoff(height)
        wait(session, 8)
        for name, height in (("above", 3.0), ("below", 1.0)):
            session.vehicles[name].command(Position(Point(0.0, 8.0, height)), LONG)
        wait(session, 6)
        assert reading_of(session, "above").values["distance"] == pytest.approx(3.06, abs=0.02)
        assert reading_of(session, "below").values["distance"] == pytest.approx(1.06, abs=0.02)


@pytest.mark.parametrize("rate", [1.0, 7.5, 25.0, 40.0, 100.0, 240.0])
def test_readings_come_at_its_own_rate(rate: float) -> None:
    with session_on(rate=rate) as session:
        times = [reading_of(session).time]
        for _ in range(120):
            session.wait()
            times.append(reading_of(session).time)
        for period, time in enumerate(times):
            expected = int(period / 40 * rate + 1e-9) / rate
            # At the first physics step at or after its time.
            assert 0 <= time - expected < 1 / 240 - 1e-9
        assert len(set(times)) == min(121, int(3 * rate) + 1)


def test_a_capture_is_at_the_first_step_at_or_after_its_time() -> None:
    assert [newest_capture(25.0, steps).step for steps in (0, 9, 10, 19, 20, 28, 29)] == [
        *(0, 0, 10, 10, 20, 20, 29)
    ]
    captures = [newest_capture(25.0, steps) for steps in range(241)]
    due = [capture for steps, capture in enumerate(captures) if capture.step == steps]
    assert [capture.sequence for capture in due] == list(range(26))
    assert due[-1].time == 1.0


def test_a_reading_is_of_its_capture_time_however_late_it_is_read() -> None:
    """A trolley has passed by when the reading is read."""
    readings = []
    for late in (0, 39):
        with session_on("places: {p: [0, 0, 0]}\n" + TROLLEY, rate=1.0) as session:
            fly_to(session, 0, 0, 3.0)
            while only(session).observe().time % 1.0 or not _trolley_below(session):
                session.wait()
            now = only(session).observe().time
            wait(session, late / 40)
            readings.append((now, reading_of(session)))
    (now, at_once), (_, later) = readings
    assert at_once == later and at_once.time == now
    assert at_once.values["distance"] == pytest.approx(3.06 - 0.5, abs=0.02)


def _trolley_below(session: SimSession) -> bool:
    """It passes below the vehicle after 2, 6, 10 … s."""
    return only(session).observe().time % 4.0 == 2.0


def test_it_changes_nothing_else_and_is_the_same_in_every_run() -> None:
    def flown(**settings: Any) -> tuple[list[object], list[object]]:
        seen: list[object] = []
        readings: list[object] = []
        options = Options(world="pursuit", seed=3, settings={"noise": 1.0, **settings})
        with open_session(options) as session:
            drone = session.vehicles["drone"]
            drone.takeoff(2.0)
            for period in range(200):
                if period == 120:
                    drone.command(Velocity(x=1.0, yaw_rate=0.5), LONG)
                session.wait()
                seen.append(drone.observe())
                if settings:
                    readings.append(drone.sensor("down").latest())
        return seen, readings

    plain, _ = flown()
    first, second = (flown(sensors={"down": {"rate": 100}}) for _ in range(2))
    assert first[0] == plain
    assert first == second and len(set(map(str, first[1]))) > 100


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (3, "'sensors' is a map of names"),
        ({"front": {}}, "the simulator has no sensor 'front'"),
        ({"down": 3}, "the sensor 'down' is 3; it must be a map of settings"),
        ({"down": {"range": 3}}, "the sensor 'down' has no 'range'"),
        ({"down": {"max_range": 0}}, "the sensor 'down' has a max_range of 0"),
        ({"down": {"max_range": "far"}}, "has a max_range of 'far'"),
        ({"down": {"rate": 500}}, "the sensor 'down' has a rate of 500"),
        ({"down": RangefinderSpec(rate=0.0)}, "the sensor 'down' has a rate of 0.0"),
    ],
)
def test_settings_that_cannot_be_are_told(given: object, message: str) -> None:
    with pytest.raises(UserError) as caught:
        open_session(Options(settings={"sensors": given}))
    assert caught.value.code == "bad-setting" and message in str(caught.value)


def test_a_specification_or_none_can_be_given_too() -> None:
    for given, known in ((RangefinderSpec(3.0, 10.0), True), (None, False)):
        with open_session(Options(settings={"sensors": {"down": given}})) as session:
            assert ("sensor.down" in session.vehicles["drone"].capabilities) == known


def test_hills_are_what_lies_below() -> None:
    rows = "[[0, 0, 0], [0, 2, 0], [0, 0, 0]]"
    hill = f"ground: {{terrain: {{size: 20, heights: {rows}}}}}\n"
    with session_on(hill) as session:
        fly_to(session, 0, 0, 4.0)
        height = only(session).observe().position.z
        expected = height + SKIDS - 2.0
        assert reading_of(session).values["distance"] == pytest.approx(expected, abs=0.02)
