"""The contract of a behaviour: a reusable piece of flying with parameters and outcomes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from inspect import getdoc
from typing import TYPE_CHECKING, Any, ClassVar

from behaviors.params import BehaviorParams, fields_of, parameters_of
from fsm.host import BehaviorInfo, Outcome

if TYPE_CHECKING:
    from behaviors.detector import OwnDetector
    from behaviors.flight import Flight
    from behaviors.plan import Legs, PlanStart


class Behavior:
    """Subclass it, declare what it needs and gives, and write ``step``.

    One object serves one activation of one state: it is made when the state's behaviour starts and
    forgotten after ``stop``.
    """

    name: ClassVar[str] = ""
    """The word after ``do:``; by default the class name in snake case."""

    class Params(BehaviorParams):
        """No parameters."""

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None}
    """Word → dataclass of its ``event`` fields; ``failed`` is implicit; {} never ends."""
    events: ClassVar[Mapping[str, type | None]] = {}
    """Dotted names it may raise → dataclass of their fields."""
    publishes: ClassVar[type | None] = None
    """Dataclass with defaults, read in the graph as ``name.field``."""
    controls: ClassVar[tuple[str, ...]] = ("motion",)
    """Resources that it needs exclusively, such as ``motion``."""
    requires: ClassVar[tuple[str, ...]] = ()
    """Capabilities that the vehicle must have; checked before take-off."""
    ends_landed: ClassVar[bool] = False
    """True when every ``done`` leaves the vehicle on the ground."""
    takes_off: ClassVar[bool] = False
    """True when every ``done`` leaves the vehicle in the air, wherever it was."""
    needs_flight: ClassVar[bool] = False
    """True when it moves a vehicle that is in the air already."""
    detectors: ClassVar[Mapping[str, OwnDetector]] = {}
    """Of a behaviour that ships: the detectors in the mission's own files, by name."""

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        """Say before the flight where it will fly: its legs up to its end, or as long as it runs.

        ``params`` are the parameters as ``self.params`` has them. What is known in flight only is
        :data:`behaviors.plan.UNKNOWN`, there and in ``start``; what is computed of that raises
        NotKnown, which makes the plan unknown. None: it is not known where it flies.
        """
        return None

    def __init__(self, params: Any) -> None:
        self.params = params
        """The parameters; live ones are updated before every step."""

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        """Begin; ``progress`` is what ``progress()`` returned when the state was last left."""

    def step(self, flight: Flight) -> Outcome | str | None:
        """Run one mission period. Return an outcome to end, None to go on."""
        raise NotImplementedError

    def progress(self) -> dict[str, Any] | None:
        """The progress to resume from, as JSON; called before ``stop``. None for none."""
        return None

    def stop(self, flight: Flight) -> None:
        """End; called once, also when the behaviour is interrupted. Must not command motion."""


def name_of(behavior: type[Behavior]) -> str:
    """The word after ``do:`` for a class."""
    return behavior.name or snake_case(behavior.__name__)


def snake_case(name: str) -> str:
    """``FlyCircle`` as ``fly_circle``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def describe(behavior: type[Behavior], name: str = "") -> BehaviorInfo:
    """A behaviour as the checker and the help see it."""
    publishes = behavior.publishes
    return BehaviorInfo(
        name=name or name_of(behavior),
        help=getdoc(behavior) or "",
        parameters=parameters_of(behavior.Params),
        outcomes={word: fields_of(record) for word, record in behavior.outcomes.items()},
        events={event: fields_of(record) for event, record in behavior.events.items()},
        publishes=fields_of(publishes),
        blank=publishes() if publishes else None,
        controls=tuple(behavior.controls),
        requires=tuple(behavior.requires),
        ends_landed=behavior.ends_landed,
        takes_off=behavior.takes_off,
        needs_flight=behavior.needs_flight,
        implementation=behavior,
    )
