"""Events that are posted to missions at given times, as if they came from outside."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import isfinite
from types import MappingProxyType
from typing import Any

from fsm import Graph
from fsm.compiler.events import parse_event
from fsm.values.packing import pack, unpack
from hal.vehicle import Observation
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.units import TIME, read_quantity

_OPTIONAL: Mapping[str, frozenset[str]] = MappingProxyType(
    {"battery.low": frozenset({"level"}), "battery.critical": frozenset({"level"})}
)
"""Fields that need not be given: the vehicle's own values stand in for them."""


@dataclass(frozen=True)
class Post:
    """An event to be posted."""

    time: float
    """Seconds since the mission's start."""
    event: str
    fields: Mapping[str, Any] = field(default_factory=dict)
    to: str = ""
    """The vehicle of a fleet whose mission is told; empty for all of them."""

    def fields_at(self, seen: Observation) -> dict[str, Any]:
        """Its fields, with those of the vehicle's own that were not given."""
        own = {"level": seen.battery} if self.event in _OPTIONAL else {}
        return {**own, **self.fields}


_OF_VEHICLE = re.compile(r"\s*([a-z][a-z0-9_]*)\s*:(.*)", re.DOTALL)
"""A vehicle's name, which has no dot, before the event."""


def parse_posts(
    graphs: Mapping[str, Graph], texts: Iterable[str], warnings: list[Fault] | None = None
) -> tuple[Post, ...]:
    """Events for missions from texts, ``6s:tag.seen{id: 3}``, by their times.

    ``graphs``: the missions of a run, by vehicle. ``6s:cat:battery.low`` is for the cat's alone,
    what names no vehicle for every one. What is doubtful in them is added to ``warnings``. Raises
    UserError with the faults of all.
    """
    faults: list[Fault] = []
    found = []
    for text in texts:
        try:
            found.append(_parse(graphs, text, Where(f"--post {text}"), warnings))
        except UserError as error:
            faults.extend(error.faults)
    if faults:
        raise UserError.of(dict.fromkeys(faults))
    return tuple(sorted(found, key=lambda post: post.time))


def _parse(
    graphs: Mapping[str, Graph], text: str, place: Where, warnings: list[Fault] | None
) -> Post:
    moment, colon, event = text.partition(":")
    if not colon:
        hint = "a time and an event: --post 6s:battery.low"
        raise UserError("bad-post", "this does not say when which event comes", place, hint)
    time = read_quantity(moment.strip(), TIME, place)
    if not (isfinite(time) and time >= 0):
        message = f"'{moment}' is no time since the mission's start"
        raise UserError("bad-post", message, place, "0 s or later: --post 6s:battery.low")
    to = ""
    named = _OF_VEHICLE.fullmatch(event)
    if named is not None:
        to, event = named.groups()
        if to not in graphs:
            message = f"there is no vehicle '{to}' in this run"
            raise UserError("unknown-vehicle", message, place, nearest(to, graphs))
    name = event.partition("{")[0].strip()
    optional = _OPTIONAL.get(name, frozenset())
    told = dict.fromkeys([graphs[to]] if to else graphs.values())
    posts = [Post(time, *parse_event(each, event, place, warnings, optional), to) for each in told]
    return posts[0]


def post_fields(post: Post) -> dict[str, Any]:
    """A post as an object for JSON."""
    to = {"to": post.to} if post.to else {}
    return {"t": post.time, "event": post.event, **to, "fields": pack(post.fields)}


def post_of(fields: Mapping[str, Any]) -> Post:
    """The post in that object. Raises KeyError and ValueError for any other."""
    return Post(fields["t"], fields["event"], unpack(fields["fields"]), fields.get("to", ""))
