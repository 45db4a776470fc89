"""What a graph may say about its host: behaviours, host names, events, reactions.

fsm knows nothing of drones; whoever runs graphs describes itself in one :class:`Vocabulary` and
gives the behaviours life through the :class:`Host` protocol.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from fsm.values.types import Type

Reaction = Literal["none", "land", "suspend", "resume"]
"""What the host does about an event that no active state handles: nothing, end the mission with a
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


@dataclass(frozen=True)
class BehaviorInfo:
    """A behaviour as graphs see it."""

    name: str
    help: str = ""
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    outcomes: Mapping[str, Mapping[str, Type]] = field(default_factory=dict)
    """Word → fields of ``event``; ``failed`` (with ``reason``) is implicit. Empty: never ends."""
    events: Mapping[str, Mapping[str, Type]] = field(default_factory=dict)
    publishes: Mapping[str, Type] = field(default_factory=dict)
    blank: Any = None
    """What it publishes before its first step."""
    controls: tuple[str, ...] = ()
    requires: tuple[str, ...] = ()
    ends_landed: bool = False
    on_trust: bool = False
    """Nothing but its name is known: whatever a graph says of it is believed."""
    implementation: Any = None
    """Whatever the host makes a running behaviour of."""


@dataclass(frozen=True)
class Function:
    """A registered function, for `call`: prompt, and never motion."""

    name: str
    help: str = ""
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    implementation: Any = None
    """Whatever the host runs for it."""
    on_trust: bool = False
    """Nothing but its name is known: whatever a graph gives it is believed."""


@dataclass(frozen=True)
class Vocabulary:
    """Everything a graph may name that is not its own."""

    behaviors: Mapping[str, BehaviorInfo] = field(default_factory=dict)
    names: Mapping[str, Type] = field(default_factory=dict)
    """Host names in the order in which the host gives their values each period."""
    events: Mapping[str, Mapping[str, Type]] = field(default_factory=dict)
    """Events the host may post, with their fields."""
    urgent: tuple[str, ...] = ()
    """Names, or families like ``operator.*``, that go ahead of all other events."""
    reactions: Mapping[str, Reaction] = field(default_factory=dict)
    """Event → what the host does when nobody handles it; what is not named gets ``land``."""
    must_land: tuple[str, ...] = ()
    """Urgent events after which a mission must land (see :mod:`fsm.checks.safety`)."""
    places: frozenset[str] | None = None
    """Named places of the world, where known before the flight."""
    functions: Mapping[str, Function] = field(default_factory=dict)
    """What `call` may run."""
    peers: frozenset[str] | None = None
    """The vehicles of the fleet that the mission is part of; None when it flies alone."""

    def is_urgent(self, event: str) -> bool:
        return any(matches(pattern, event) for pattern in self.urgent)

    def reaction(self, event: str) -> Reaction:
        return self.reactions.get(event, "land")


def matches(pattern: str, event: str) -> bool:
    """Whether ``battery.*`` or ``battery.low`` names this event."""
    if pattern.endswith(".*"):
        return event.startswith(pattern[:-1])
    return pattern == event


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a behaviour ended, and the fields that ``event`` has then."""

    word: str
    fields: Mapping[str, Any] = field(default_factory=dict)


class Activity(Protocol):
    """A behaviour at work for one state. It never raises: what goes wrong is ``failed``."""

    @property
    def published(self) -> Any:
        """The values seen under its name, an object with the declared fields."""

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        """One period with the present values of its ``live`` parameters."""

    def progress(self) -> Mapping[str, Any] | None:
        """How far it came, as JSON; asked before stop."""

    def saved(self) -> Mapping[str, Any]:
        """What :meth:`Host.resume` needs to go on with it, as values that can be packed."""

    def stop(self) -> None:
        """Called once, whether it ended by itself or its state was left."""


class Host(Protocol):
    """What a running graph asks of whoever runs it."""

    def begin(
        self,
        behavior: BehaviorInfo,
        state: str,
        parameters: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
    ) -> Activity:
        """Start a behaviour. Never raises: one that cannot start fails in its first step."""

    def resume(self, behavior: BehaviorInfo, state: str, saved: Mapping[str, Any]) -> Activity:
        """Go on with a behaviour of a saved run, from what its activity said in ``saved``."""

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Run a registered function. Raises EvaluationError when it fails."""

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        """Give an event to another vehicle."""
