"""Messages between the vehicles of a fleet: what is sent in a period arrives in the next one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

from behaviors.channel import Channel
from behaviors.pilot import Pilot
from fsm.values.conversion import convert
from fsm.values.functions import EvaluationError
from fsm.values.types import HEADING, POINT, ROUTE, ListOf, Type
from vencejo.geometry import Point


class _Sent(NamedTuple):
    """An event on its way."""

    sender: Pilot
    event: str
    fields: Mapping[str, Any]
    to: str


class Exchange:
    """Carries events between the missions of a fleet.

    Places are the same places on arrival: each mission counts them from its own home. Which fields
    are places is said by the types that the receiver declares; where it declares none, every point
    is one.
    """

    def __init__(self, pilots: Iterable[Pilot]) -> None:
        self._pilots = {pilot.vehicle.name: pilot for pilot in pilots}
        self._sent: list[_Sent] = []
        for pilot in self._pilots.values():
            pilot.on_send = partial(self._send, pilot)

    def _send(self, sender: Pilot, event: str, fields: Mapping[str, Any], to: str) -> None:
        self._sent.append(_Sent(sender, event, fields, to))

    def deliver(self) -> None:
        """Queue what was sent in this period, in its order; ``event.source`` is who sent it.

        What nobody hears any more is recorded as undelivered.
        """
        sent, self._sent = self._sent, []
        for sender, event, fields, to in sent:
            receiver = self._pilots.get(to)
            if receiver is None or receiver.outcome is not None:
                sender.instance.record("undelivered", event=event, to=to)
                continue
            declared = receiver.instance.graph.events.get(event, {})
            move = partial(_moved, sender.channel, receiver.channel)
            try:
                moved = {n: carried(declared.get(n), value, move) for n, value in fields.items()}
            except EvaluationError as error:
                message = f"{event} to '{to}': {error}"
                lost = {"message": message, "where": "send"}
                sender.instance.post("error.execution", lost)
                continue
            receiver.instance.post(event, {**moved, "source": sender.vehicle.name})


def _moved(sender: Channel, receiver: Channel, place: Any) -> Point:
    """A place of the sender's mission, as the receiver's counts it. Raises EvaluationError."""
    point = sender.frame.point(convert(place, POINT), sender.observation)
    return receiver.frame.from_world(sender.frame.to_world(point))


def carried(type_: Type | None, value: Any, move: Callable[[Any], Point]) -> Any:
    """A value of the sender's mission for a field of that type in the receiver's; None for a type
    that is not known. ``move`` gives the place there of one here.
    """
    if type_ == POINT or isinstance(value, Point):
        return move(value)
    if type_ == HEADING:
        return {"face": move(value["face"])} if isinstance(value, dict) else value
    if isinstance(value, (list, tuple)):
        if type_ == ROUTE:
            return [_waypoint(each, move) for each in value]
        item = type_.item if isinstance(type_, ListOf) else None
        return [carried(item, each, move) for each in value]
    if isinstance(value, dict):
        return {name: carried(None, each, move) for name, each in value.items()}
    return value


def _waypoint(value: Any, move: Callable[[Any], Point]) -> Any:
    """A point of a route, or ``{at: point, …}``."""
    if not (isinstance(value, dict) and "at" in value):
        return move(value)
    heading = carried(HEADING, value["heading"], move) if "heading" in value else None
    kept = {name: each for name, each in value.items() if name not in ("at", "heading")}
    return {"at": move(value["at"]), **kept, **({} if heading is None else {"heading": heading})}
