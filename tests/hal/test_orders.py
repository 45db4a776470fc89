"""Orders that a link answers late: what ends what."""

from __future__ import annotations

from hal import Lights, Setpoint, Velocity
from hal.base import BaseSession, BaseVehicle
from hal.fake import FakeVehicle
from hal.orders import UNDER_WAY, Orders
from hal.vehicle import PERIOD, VALIDITY, Hold


def test_lights_and_motion_go_on_beside_each_other() -> None:
    orders = Orders()
    takeoff, lights = orders.send("takeoff", 2.0), orders.send("lights", Lights("solid"))
    for order in orders.take():
        orders.accept(order)
    assert (takeoff.state, lights.state) == ("accepted", "accepted")
    orders.end()
    assert (takeoff.state, lights.state) == ("done", "accepted")
    orders.accept(orders.send("lights", Lights("off")))
    assert (lights.state, lights.reason) == ("refused", "ended by: lights")


def test_other_lights_are_another_order_and_equal_ones_the_same() -> None:
    orders = Orders()
    solid = orders.send("lights", Lights("solid"))
    assert orders.send("lights", Lights("solid")) is solid
    orders.accept(solid)
    orders.take()
    assert orders.send("lights", Lights("solid")) is solid
    assert orders.send("lights", Lights("off")) is not solid


class Slow(BaseVehicle):
    """Answers verbs some time later, and notes what it flies."""

    capabilities = frozenset({"velocity", "lights"})

    def __init__(self) -> None:
        super().__init__("slow", {"lights": lambda lights: UNDER_WAY})
        self.flown: list[Setpoint] = []

    def fly(self, setpoint: Setpoint) -> None:
        self.flown.append(setpoint)

    def advance(self, now: float) -> None:
        self.begin_period()
        other = FakeVehicle()
        other.advance(now)
        self.end_period(other.observe())


def test_lights_make_no_set_point_valid_for_longer() -> None:
    vehicle = Slow()
    session = BaseSession([vehicle])
    session.wait()
    vehicle.command(Velocity(x=1.0))
    lights = vehicle.lights(Lights("solid"))
    for _ in range(round(VALIDITY / PERIOD) + 1):
        session.wait()
    assert lights.state == "accepted"
    assert vehicle.flown == [Velocity(x=1.0), Hold()]
