"""Base classes for backends: orders, the validity of set-points, and refusal of what is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import inf, isfinite
from types import MappingProxyType
from typing import Any, Generic, Self, TypeVar

from hal.lights import Lights, Rgb
from hal.limits import Limits
from hal.orders import MOTION, Decision, Order, Orders
from hal.vehicle import (
    ACCEPTED,
    PERIOD,
    PERIODS_PER_SECOND,
    VALIDITY,
    Answer,
    Attitude,
    Camera,
    Hold,
    Observation,
    Position,
    Sensor,
    Setpoint,
    Unavailable,
    Velocity,
    VisionPose,
    is_finite,
)
from vencejo.geometry import Point

_EPSILON = 1e-9
"""Seconds within which two times count as equal."""
_NEEDED: Mapping[type[Setpoint], str] = MappingProxyType(
    {Velocity: "velocity", Position: "position", Attitude: "attitude"}
)
"""The capability that each kind of set-point needs; every vehicle can hold."""
Decide = Callable[..., Decision]
"""Decides on a verb, given its arguments, and begins to carry it out."""


def not_to_be_swapped(*, aloft: bool, armed: bool) -> str:
    """The reason why a battery cannot be swapped now; empty when it can."""
    return "the vehicle is in the air" if aloft else "the motors are running" if armed else ""


class BaseVehicle:
    """A vehicle to inherit from (see :class:`hal.vehicle.Vehicle`, and docs/backends.md).

    Verbs and set-points are queued, and carried out by :meth:`begin_period` within ``wait()``.
    A verb without a decision raises Unavailable; so do cameras, sensors and vision poses unless a
    subclass provides them.
    """

    capabilities: frozenset[str] = frozenset()
    profiles: Mapping[str, Limits] = MappingProxyType({})
    model = ""
    color: Rgb | None = None

    def __init__(self, name: str, decisions: Mapping[str, Decide]) -> None:
        """``decisions``: the function that decides on each verb that the vehicle has."""
        self.orders = Orders()
        self._name = name
        self._decisions = decisions
        self._given: tuple[Setpoint, float] | None = None
        """The set-point given since the last period, and the seconds for which it is valid."""
        self._expires = inf
        """Time at which the set-point being flown expires, session's clock."""
        self._seen: Observation | None = None
        self._now = 0.0
        """Time at the end of the last period, seconds of the session's clock."""

    # Methods for subclasses to override.

    @property
    def limits(self) -> Limits:
        """See the contract: a vehicle that does not override it does not know its limits."""
        return Limits()

    def refusal(self) -> str:
        """The reason why the vehicle cannot fly a set-point now; empty when it can."""
        return ""

    def fly(self, setpoint: Setpoint) -> None:
        """Follow a set-point from this period on."""
        raise NotImplementedError

    # The mission period.

    def advance(self, now: float) -> None:
        """Simulate the mission period that ends at ``now``, seconds of the session's clock.

        It calls ``begin_period``, moves the vehicle, and calls ``end_period``. Only vehicles of a
        BaseSession need it.
        """
        raise NotImplementedError

    def begin_period(self, heard: bool = True) -> None:
        """Carry out the set-point and the orders given since the last period.

        Where nothing was ``heard`` of that, its set-point is lost, and the validity of the last one
        runs out.
        """
        given, self._given = self._given, None
        if heard and given is not None:
            setpoint, valid_for = given
            self._expires = inf if isinstance(setpoint, Hold) else self._now + valid_for
            if self.orders.under_way:
                self.orders.end("ended by a command")
            self.fly(setpoint)
        elif self._now >= self._expires - _EPSILON:
            self._expires = inf
            if not self.refusal():
                self.fly(Hold())
        if heard and (self.orders.sent or self.orders.superseded):
            for order in self.orders.take():
                self._carry_out(order, self.decide(order))

    def decide(self, order: Order) -> Decision:
        """Carry out an order as far as that can be done at once."""
        return self._decisions[order.verb](*order.arguments)

    def _carry_out(self, order: Order, decision: Decision) -> None:
        if decision.state != "accepted":
            order.state, order.reason = decision
            return
        self.orders.accept(order)
        if order.verb in MOTION:
            self._expires = inf

    def remaining_validity(self) -> float:
        """Seconds from the last observation on for which its set-point is valid: a vehicle whose
        period takes longer holds for the rest of it. Infinite where there is nothing to run out.
        """
        return self._expires - self._now

    @property
    def landing_with(self) -> Point | None:
        """The velocity over the ground that it is to land with, m/s; None over one place."""
        order = self.orders.under_way.get("land")
        return order.arguments[0] if order is not None and order.arguments else None

    def end_period(self, seen: Observation) -> None:
        """End a mission period with its observation; orders that took too long are lost."""
        self._seen, self._now = seen, seen.time
        if self.orders.sent or self.orders.under_way:
            self.orders.expire(seen.time)

    # The contract.

    @property
    def name(self) -> str:
        return self._name

    def observe(self) -> Observation:
        """See the contract. Raises RuntimeError before the first ``wait()``."""
        if self._seen is None:
            raise RuntimeError("nothing is known of a vehicle before the first wait()")
        return self._seen

    def command(self, setpoint: Setpoint, valid_for: float = VALIDITY) -> Answer:
        """See the contract. Raises ValueError for numbers that are not finite, or no validity."""
        if not is_finite(setpoint):
            raise ValueError(f"a set-point needs finite numbers: {setpoint}")
        if not 0.0 < valid_for < inf:
            raise ValueError(f"a set-point is valid for some seconds, not for {valid_for}")
        needed = _NEEDED.get(type(setpoint))
        if needed is not None and needed not in self.capabilities:
            return Answer(False, f"the vehicle '{self._name}' has no capability '{needed}'")
        reason = self.refusal()
        if reason:
            return Answer(False, reason)
        if self.orders.sent or self.orders.under_way:
            self.orders.supersede("ended by a command")
        self._given = setpoint, valid_for
        return ACCEPTED

    def send(self, verb: str, *arguments: Any) -> Order:
        """Send a verb. Raises Unavailable when the vehicle does not have it."""
        if verb not in self._decisions:
            raise Unavailable(f"the vehicle '{self._name}' cannot {verb.replace('_', ' ')}")
        return self.orders.send(verb, *arguments)

    def arm(self) -> Order:
        return self.send("arm")

    def disarm(self) -> Order:
        return self.send("disarm")

    def takeoff(self, altitude: float) -> Order:
        return self.send("takeoff", altitude)

    def land(self, moving: Point | None = None) -> Order:
        """See the contract. Raises ValueError for a velocity that is not finite."""
        if moving is None:
            return self.send("land")
        if not isfinite(moving.x + moving.y):
            raise ValueError(f"a landing needs a finite velocity: {moving}")
        if "land.moving" not in self.capabilities:
            raise Unavailable(f"the vehicle '{self._name}' cannot land on what moves")
        return self.send("land", moving)

    def return_home(self) -> Order:
        return self.send("return_home")

    def emergency_stop(self) -> Order:
        return self.send("emergency_stop")

    def reset(self) -> Order:
        return self.send("reset")

    def trim(self) -> Order:
        return self.send("trim")

    def lights(self, lights: Lights) -> Order:
        return self.send("lights", lights)

    def swap_battery(self) -> Order:
        return self.send("swap_battery")

    def configure(self, limits: Limits) -> Answer:
        """Refuses: a vehicle without the capability ``limits`` has none to change."""
        if not limits.given():
            return ACCEPTED
        return Answer(False, f"the vehicle '{self._name}' has no limits to change")

    def camera(self, name: str) -> Camera:
        raise Unavailable(f"the vehicle '{self._name}' has no camera '{name}'")

    @property
    def active_camera(self) -> str | None:
        return None

    def use_camera(self, name: str | None = None) -> None:
        """Every camera is active: nothing is to be done."""
        if name is not None:
            self.camera(name)

    def sensor(self, name: str) -> Sensor:
        raise Unavailable(f"the vehicle '{self._name}' has no sensor '{name}'")

    def send_vision_pose(self, pose: VisionPose) -> None:
        raise Unavailable(f"the vehicle '{self._name}' takes no vision poses")


V = TypeVar("V", bound=BaseVehicle)


class BaseSession(Generic[V]):
    """A session to inherit from (see :class:`hal.vehicle.Session`).

    Each ``wait`` advances its vehicles by one mission period, as a simulator does.
    """

    engine = "none"
    settings: Mapping[str, object] = MappingProxyType({})
    places: Mapping[str, Point] = MappingProxyType({})
    geographic: tuple[float, float, float] | None = None
    ground_height: Callable[[float, float], float] | None = None

    def __init__(self, vehicles: Iterable[V]) -> None:
        self.vehicles: Mapping[str, V] = MappingProxyType({each.name: each for each in vehicles})
        self.periods = 0
        """Number of mission periods so far."""

    def wait(self) -> float:
        """See the contract."""
        self.periods += 1
        for vehicle in self.vehicles.values():
            vehicle.advance(self.periods / PERIODS_PER_SECOND)
        return PERIOD

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        """Nothing to close."""
