"""The battery by itself, and what becomes of a vehicle without one."""

from __future__ import annotations

from pathlib import Path

import pytest

from hal.fake import FakeSession
from hal.sim import open_session
from hal.sim.battery import Battery
from hal.sim.model import BatteryPack
from hal.sim.model_files import load_model
from hal.vehicle import Options, Velocity
from tests.hal.flying import decided, hovering, only, take_off, wait, wait_until

ARDRONE2 = load_model("ardrone2")
PACK = ARDRONE2.battery
HOVER = ARDRONE2.hover_power


def hovering_time(pack: BatteryPack, power: float) -> float:
    """Seconds until a battery is empty."""
    battery, seconds = Battery(pack, 1.0), 0
    while not battery.empty:
        battery.drain(power, 1.0)
        seconds += 1
    return seconds


def test_a_full_battery_hovers_for_its_endurance() -> None:
    assert hovering_time(PACK, HOVER) == pytest.approx(ARDRONE2.endurance, abs=1.5)


@pytest.mark.parametrize("charge", [1.0, 0.5, 0.1])
def test_the_voltage_sags_and_the_resistance_takes_its_part(charge: float) -> None:
    battery = Battery(PACK, charge)
    battery.drain(HOVER, 1.0)
    lost = (charge - battery.charge) * PACK.energy - HOVER
    current = HOVER / battery.voltage
    assert lost == pytest.approx(current**2 * PACK.resistance, rel=2e-2)
    assert PACK.voltage(charge) - battery.voltage == pytest.approx(current * 0.06, rel=2e-2)


def test_no_more_power_than_the_battery_can_give() -> None:
    most = PACK.full**2 / 4 / PACK.resistance
    assert PACK.current(2 * most, 1.0) == PACK.current(most, 1.0)


def test_a_flight_drains_what_hovering_costs() -> None:
    with hovering() as (session, vehicle):
        before = vehicle.observe().battery
        after = wait(session, 36)[-1].battery
        assert before - after == pytest.approx(36 / ARDRONE2.endurance, rel=0.01)
        vehicle.command(Velocity(z=2.0))
        wait(session, 2)
        assert wait(session, 1)[-1].battery < after - 3 / ARDRONE2.endurance


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
        net = power / PACK.energy - PACK.drain(PACK.current(PACK.standby, before), before)
        assert wait(session, 2)[-1].battery - before == pytest.approx(2 * net, rel=1e-3)
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
