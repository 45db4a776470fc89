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

from collections.abc import Mapping
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
    }
)
"""Seconds after which an order that is not done is lost, by verb."""

MANOEUVRES = frozenset({"takeoff", "land", "return_home"})
"""Orders that the vehicle flies autonomously; a set-point ends them."""


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
        self._sent: list[Order] = []
        self._under_way: dict[str, Order] = {}

    def send(self, verb: str, *arguments: Any) -> Order:
        """Queue a verb; if it is already sent or under way, the result is that order again."""
        last = self._sent[-1] if self._sent else self._under_way.get(verb)
        again = last is not None and last.verb == verb and not last.reason
        if last is not None and again and (last.state == "accepted" or last.arguments == arguments):
            return last
        order = Order(verb, arguments)
        self._sent.append(order)
        return order

    def supersede(self, reason: str) -> None:
        """Cancel the manoeuvres sent in this period, since a set-point was given after them."""
        for order in self._sent:
            if order.verb in MANOEUVRES:
                order.reason = reason

    def take(self) -> list[Order]:
        """Remove and return the orders to decide on, in the sequence in which they were sent."""
        if not self._sent:
            return []  # nearly always
        sent, self._sent = self._sent, []
        for order in sent:
            if order.reason:
                order.state = "refused"
        return [order for order in sent if not order.ended]

    def get(self, verb: str) -> Order | None:
        """The order of that verb that is under way, or None."""
        return self._under_way.get(verb)

    def accept(self, order: Order) -> None:
        """Mark an order as under way; all others under way end."""
        self.end(f"ended by: {order.verb}")
        order.state = "accepted"
        self._under_way[order.verb] = order

    def end(self, reason: str = "") -> None:
        """Mark all orders under way as done or, with a reason, as refused."""
        if not self._under_way:
            return
        for order in self._under_way.values():
            order.state, order.reason = ("refused", reason) if reason else ("done", "")
        self._under_way.clear()

    def expire(self, now: float) -> None:
        """Mark orders as lost that were not answered or done in time (``now``: session's clock)."""
        if not self._sent and not self._under_way:
            return
        for order in self._sent:
            if _age(order, now) >= ANSWER_WITHIN:
                order.state, order.reason = "lost", f"no answer within {ANSWER_WITHIN:g} s"
        self._sent = [order for order in self._sent if not order.ended]
        for verb, order in list(self._under_way.items()):
            if _age(order, now) >= DONE_WITHIN[verb]:
                order.state, order.reason = "lost", f"not done within {DONE_WITHIN[verb]:g} s"
                del self._under_way[verb]


def _age(order: Order, now: float) -> float:
    """Seconds since the period in which an order was sent."""
    if order.sent_at is None:
        order.sent_at = now
    return now - order.sent_at
