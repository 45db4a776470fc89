"""Orders: verbs sent to a vehicle, and the state of each.

An order changes only inside the session's ``wait()``::

    sent ──► accepted ──► done
      │          ├──────► refused   by the vehicle, or ended by another order or a set-point
      │          └──────► lost      not done in time
      ├──► done                     it was so already
      ├──► refused
      └──► lost

:class:`Orders` keeps this rule for backends; :class:`hal.base.BaseVehicle` connects it to verbs.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

OrderState = Literal["sent", "accepted", "done", "refused", "lost"]

ANSWER_WITHIN = 3.0
"""Seconds of the session's clock after which an order that was not answered is lost."""
DONE_WITHIN: Mapping[str, float] = MappingProxyType(
    {
        "arm": 5.0,
        "disarm": 5.0,
        "takeoff": 60.0,
        "land": 300.0,
        "return_home": 600.0,
        "emergency_stop": 5.0,
        "reset": 30.0,
        "trim": 10.0,
        "lights": 5.0,
        "swap_battery": 600.0,
    }
)
"""Seconds after which an order that is not done is lost, by verb."""

MANOEUVRES = frozenset({"takeoff", "land", "return_home"})
"""Orders that the vehicle flies by itself; a set-point ends them."""
MOTION = frozenset(DONE_WITHIN) - {"lights", "swap_battery"}
"""Orders of which one ends another; the others are carried out beside them."""


@dataclass(slots=True, eq=False)
class Order:
    """A verb that was sent to a vehicle; behaviours poll its ``state``."""

    verb: str
    arguments: tuple[Any, ...] = ()
    state: OrderState = "sent"
    reason: str = ""
    """The reason for a refusal or loss, in the autopilot's words if it gives any."""
    sent_at: float | None = None
    """End of the first period after it was sent, session's clock, seconds; set by the backend."""

    @property
    def ended(self) -> bool:
        """True when the state is final."""
        return self.state in ("done", "refused", "lost")


class Decision(NamedTuple):
    """A vehicle's answer to an order."""

    state: Literal["accepted", "done", "refused"]
    reason: str = ""


UNDER_WAY, DONE = Decision("accepted"), Decision("done")


def refused(reason: str) -> Decision:
    """The decision to refuse an order."""
    return Decision("refused", reason)


class Orders:
    """The orders of one vehicle: those sent, on which the backend decides, and those under way."""

    def __init__(self) -> None:
        self.sent: list[Order] = []
        """Not decided on yet."""
        self.under_way: dict[str, Order] = {}
        """Accepted, by verb."""
        self.superseded: dict[Order, str] = {}
        """Orders that count no more, with the reason that they are told in the next period."""

    def send(self, verb: str, *arguments: Any) -> Order:
        """Take down a verb. One that is already sent or under way is that order again, with these
        arguments, unless it was superseded, or another verb of motion was sent since.
        """
        motion = verb in MOTION
        alike = [order for order in self.sent if (order.verb in MOTION) == motion]
        last = alike[-1] if alike else self.under_way.get(verb)
        # A manoeuvre under way goes on whatever it is asked for anew; lights change.
        again = last is not None and last.verb == verb and last not in self.superseded
        going_on = last is not None and last.state == "accepted" and motion
        if last is not None and again and (going_on or last.arguments == arguments):
            last.arguments = arguments
            return last
        order = Order(verb, arguments)
        self.sent.append(order)
        return order

    def supersede(self, reason: str) -> None:
        """A set-point came after what was told so far: orders to fly count no more."""
        for order in (*self.sent, *self.under_way.values()):
            if order.verb in MANOEUVRES:
                self.superseded[order] = reason

    def take(self) -> list[Order]:
        """The orders to decide on now, in the sequence in which they were sent."""
        sent, self.sent = self.sent, []
        superseded, self.superseded = self.superseded, {}
        for order in sent:
            if order in superseded:
                order.state, order.reason = "refused", superseded[order]
        return [order for order in sent if not order.ended]

    def accept(self, order: Order) -> None:
        """The vehicle carries it out; what was under way ends, but for lights and motion beside
        each other.
        """
        self.end(f"ended by: {order.verb}", MOTION if order.verb in MOTION else {order.verb})
        order.state = "accepted"
        self.under_way[order.verb] = order

    def end(self, reason: str = "", verbs: Set[str] = MOTION) -> None:
        """End the orders under way of these verbs: as done or, with a reason, as refused."""
        for verb in [verb for verb in self.under_way if verb in verbs]:
            order = self.under_way.pop(verb)
            order.state, order.reason = ("refused", reason) if reason else ("done", "")

    def expire(self, now: float) -> None:
        """Give up what was not answered, or not done, in its time (session's clock, seconds)."""
        for order in self.sent:
            if _age(order, now) >= ANSWER_WITHIN:
                order.state, order.reason = "lost", f"no answer within {ANSWER_WITHIN:g} s"
        self.sent = [order for order in self.sent if not order.ended]
        for verb, order in list(self.under_way.items()):
            if _age(order, now) >= DONE_WITHIN[verb]:
                order.state, order.reason = "lost", f"not done within {DONE_WITHIN[verb]:g} s"
                del self.under_way[verb]


def _age(order: Order, now: float) -> float:
    """Seconds since the period in which an order was sent."""
    if order.sent_at is None:
        order.sent_at = now
    return now - order.sent_at
