"""The battery by itself, and what becomes of a vehicle without one."""

from __future__ import annotations

from pathlib import Path

import pytest

from hal.fake import FakeSession
from hal.sim import open_session
from hal.sim.airframe import Airframe
from hal.sim.battery import Battery
from hal.sim.physics import GRAVITY
from hal.vehicle import Options, Velocity
from tests.hal.flying import decided, hovering, only, take_off, wait, wait_until

AIRFRAME = Airframe()
HOVER = AIRFRAME.mass * GRAVITY


def test_a_full_battery_hovers_for_its_endurance() -> None:
    battery = Battery(AIRFRAME, 1.0)
    battery.drain(HOVER, AIRFRAME.endurance / 2)
    assert battery.charge == pytest.approx(0.5)
    battery.drain(HOVER, AIRFRAME.endurance * 0.51)
    assert battery.charge == 0.0 and battery.empty


def test_more_thrust_drains_more_than_its_share() -> None:
    def drained(thrust: float) -> float:
        battery = Battery(AIRFRAME, 1.0)
        battery.drain(thrust, 1.0)
        return 1 - battery.charge

    standby = drained(0.0)
    assert 0 < standby < 0.2 * drained(HOVER)
    assert drained(2 * HOVER) - standby == pytest.approx(2**1.5 * (drained(HOVER) - standby))


def test_a_flight_drains_what_hovering_costs() -> None:
    with hovering() as (session, vehicle):
        before = vehicle.observe().battery
        after = wait(session, 36)[-1].battery
        assert before - after == pytest.approx(36 / AIRFRAME.endurance, rel=0.001)
        vehicle.command(Velocity(z=2.0))
        wait(session, 2)
        assert wait(session, 1)[-1].battery < after - 3 / AIRFRAME.endurance


PADS = """\
world: pads
battery: 40 %
start: {at: [0, 0, 0.2]}
boxes:
  pad: {at: [0, 0], size: [2, 2, 0.2], charges: 4000 W}
  plain: {at: [4, 0], size: [2, 2, 0.2]}
cylinders:
  ferry:
    radius: 1 m
    height: 20 cm
    charges: 400 W
    moves: {through: [[8, 0], [8, 6]], speed: 20 cm/s}
"""


@pytest.mark.parametrize(("x", "power"), [(0.0, 4000.0), (4.0, 0.0), (8.0, 400.0)])
def test_a_pad_charges_what_stands_on_it(x: float, power: float, tmp_path: Path) -> None:
    world = tmp_path / "pads.yaml"
    world.write_text(PADS.replace("at: [0, 0, 0.2]", f"at: [{x}, 0, 0.2]"))
    with open_session(Options(world=str(world))) as session:
        vehicle = only(session)
        before = wait(session, 1)[-1].battery
        net = (power - AIRFRAME.standby_power) / AIRFRAME.capacity
        assert wait(session, 2)[-1].battery - before == pytest.approx(2 * net, rel=1e-6)
        decided(session, vehicle.arm())
        armed = vehicle.observe().battery
        assert wait(session, 1)[-1].battery < armed, "its motors run"
        decided(session, vehicle.disarm())
        aloft = take_off(session, 2).observe().battery
        assert wait(session, 1)[-1].battery < aloft
        if power > 1000:
            order = vehicle.land()
            wait_until(session, lambda: order.ended, 10)
            assert wait(session, 10)[-1].battery == 1.0, "full, and no more"


def test_an_empty_battery_stops_the_motors(tmp_path: Path) -> None:
    world = tmp_path / "low.yaml"
    world.write_text("world: low\nbattery: 1 %\n")
    with open_session(Options(world=str(world))) as session:
        vehicle = take_off(session, 3)
        assert vehicle.observe().battery > 0
        landing = vehicle.land()
        session.wait()
        vehicle.takeoff(3)
        wait_until(session, lambda: not vehicle.observe().armed, 8)
        seen = vehicle.observe()
        assert (seen.battery, seen.mode) == (0.0, "stopped")
        assert "the battery is empty" in seen.health
        assert landing.ended
        wait_until(session, lambda: vehicle.observe().mode == "landed", 5)
        for verb in (vehicle.arm, lambda: vehicle.takeoff(1)):
            order = decided(session, verb())
            assert order.state == "refused" and "the battery is empty" in order.reason


def test_an_order_under_way_ends_with_the_battery() -> None:
    session = FakeSession()
    vehicle = take_off(session)
    order = vehicle.return_home()
    session.vehicles["drone"].battery = 0.0
    session.wait()
    assert (order.state, order.reason) == ("refused", "the battery is empty")
    assert only(session).observe().mode == "stopped"
