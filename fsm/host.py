"""The interface between a graph and its host: behaviours, host names, events, reactions.

fsm knows nothing of drones; whoever runs graphs describes itself in one :class:`Vocabulary` and
gives the behaviours life through the :class:`Host` protocol.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from fsm.values.types import Type

PERIOD = 0.025
"""Seconds of one mission period."""

Reaction = Literal["none", "land", "suspend", "resume"]
"""The host's reaction to an event that no active state handles: none, end the mission with a
landing, or suspend the mission until an event whose reaction is to resume it."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a behaviour or of a mission."""

    name: str
    type: Type
    default: Any = None
    required: bool = False
    live: bool = False
    """May stand under ``live:`` and change in flight."""
    help: str = ""
    unit: str = ""
    """The unit its default is shown in."""
    names: str = ""
    """The kind of what its value names: the vehicle needs the capability ``KIND.value``."""


@dataclass(frozen=True)
class BehaviorInfo:
    """The facts about a behaviour that a graph is checked against."""

    name: str
    help: str = ""
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    outcomes: Mapping[str, Mapping[str, Type]] = field(default_factory=dict)
    """Word → fields of ``event``; ``failed`` (with ``reason``) is implicit. Empty: never ends."""
    events: Mapping[str, Mapping[str, Type]] = field(default_factory=dict)
    publishes: Mapping[str, Type] = field(default_factory=dict)
    blank: Any = None
    """The object it publishes before its first step."""
    controls: tuple[str, ...] = ()
    requires: tuple[str, ...] = ()
    ends_landed: bool = False
    """Every ``done`` leaves the vehicle on the ground."""
    takes_off: bool = False
    """Every ``done`` leaves it in the air."""
    needs_flight: bool = False
    """It moves a vehicle that is in the air already."""
    on_trust: bool = False
    """Only its name is known: it is not checked how a graph uses it."""
    implementation: Any = None
    """The host's own object, from which it starts the behaviour."""

    @property
    def may_take_off(self) -> bool:
        """Whether it may leave the ground; a landed vehicle stays there under any other."""
        return self.takes_off or "takeoff" in self.requires

    def named(self, given: Mapping[str, Any]) -> Iterator[str]:
        """The capabilities that the values of its parameters name, defaults included.

        ``given`` are those that it is given; None is one that names nothing, or is not known yet.
        """
        for name, parameter in self.parameters.items():
            value = given.get(name, parameter.default)
            if parameter.names and value is not None:
                yield f"{parameter.names}.{value}"


@dataclass(frozen=True)
class Function:
    """A registered function, for `call`; it returns at once and moves nothing."""

    name: str
    help: str = ""
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    implementation: Any = None
    """The host's own object, which it calls."""
    on_trust: bool = False
    """Only its name is known: its arguments are not checked."""


@dataclass(frozen=True)
class Vocabulary:
    """Everything of its host that a graph may name."""

    behaviors: Mapping[str, BehaviorInfo] = field(default_factory=dict)
    names: Mapping[str, Type] = field(default_factory=dict)
    """Host names in the order in which the host gives their values each period."""
    events: Mapping[str, Mapping[str, Type]] = field(default_factory=dict)
    """Events the host may post, with their fields."""
    urgent: tuple[str, ...] = ()
    """Names, or families like ``operator.*``, that go ahead of all other events."""
    reactions: Mapping[str, Reaction] = field(default_factory=dict)
    """The host's reactions by event; to any other event it is ``land``."""
    must_land: tuple[str, ...] = ()
    """Urgent events after which a mission must land (see :mod:`fsm.checks.safety`)."""
    places: frozenset[str] | None = None
    """Named places of the world, where known before the flight."""
    functions: Mapping[str, Function] = field(default_factory=dict)
    """The functions that `call` may run, by name."""
    peers: frozenset[str] | None = None
    """The vehicles of the fleet that the mission is part of; None when it flies alone."""
    needs: Mapping[str, str] = field(default_factory=dict)
    """The capabilities that the host's values need, by names such as ``vehicle.wind``."""

    def is_urgent(self, event: str) -> bool:
        """Whether an event goes ahead of all others."""
        return any(matches(pattern, event) for pattern in self.urgent)

    def reaction(self, event: str) -> Reaction:
        """The host's reaction to an event that no active state handles."""
        return self.reactions.get(event, "land")


def matches(pattern: str, event: str) -> bool:
    """Whether a pattern (``battery.low``, or a family like ``battery.*``) names this event."""
    if pattern.endswith(".*"):
        return event.startswith(pattern[:-1])
    return pattern == event


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of a behaviour: its outcome, and the fields that ``event`` has then."""

    word: str
    fields: Mapping[str, Any] = field(default_factory=dict)


class Activity(Protocol):
    """A behaviour that runs for one state. It never raises: an error is the outcome ``failed``."""

    @property
    def published(self) -> Any:
        """The values seen under its name, an object with the declared fields."""

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        """Run it for one period, with the present values of its ``live`` parameters."""

    def progress(self) -> Mapping[str, Any] | None:
        """Its progress as JSON, to go on from later; asked before :meth:`stop`."""

    def saved(self) -> Mapping[str, Any]:
        """The values that :meth:`Host.resume` needs; :func:`fsm.values.packing.pack` takes them."""

    def stop(self) -> None:
        """End it. Called once, whether it ended by itself or its state was left."""


class Host(Protocol):
    """The services that a running graph needs from the program that runs it."""

    def begin(
        self,
        behavior: BehaviorInfo,
        state: str,
        parameters: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
    ) -> Activity:
        """Start a behaviour. Never raises: one that cannot start fails in its first step."""

    def resume(self, behavior: BehaviorInfo, state: str, saved: Mapping[str, Any]) -> Activity:
        """Go on with a behaviour of a saved run, from the values of its :meth:`Activity.saved`."""

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Run a registered function. Raises EvaluationError when it fails."""

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        """Give an event to another vehicle."""
