"""Every flight of a small mission, by the engine itself: what the safety proof is compared with.

The engine flies each mission period under every order of outcomes, timers and conditions. Time
stands still: a timer goes off when it is told to. What the vehicle sees (``see.a`` and so on)
changes freely from one period to the next. A flight may go on for ever in a *loop* of situations if
it is fair: what is due in all of them (a behaviour that can end, a timer, a sent event) happens in
it, or its state is left or entered anew.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations, product
from types import SimpleNamespace
from typing import Any, NamedTuple

from fsm import BehaviorInfo, Graph, Instance, Node, Outcome, Vocabulary
from fsm.checks.exploration import components
from fsm.engine.state import State
from fsm.values.types import BOOL, MapOf

MUST_LAND = "operator.abort"
SIGHTS = "abc"
MOTION = ("motion",)
BEHAVIORS = (
    BehaviorInfo("takeoff", outcomes={"done": {}}, controls=MOTION, takes_off=True),
    BehaviorInfo("goto", outcomes={"done": {}, "blocked": {}}, controls=MOTION),
    BehaviorInfo("hover", controls=MOTION),
    BehaviorInfo("land", outcomes={"done": {}}, controls=MOTION, ends_landed=True),
    BehaviorInfo("look", events={"tag.seen": {}}),
    BehaviorInfo("wait", outcomes={"done": {}}),
)
VOCABULARY = Vocabulary(
    behaviors={behavior.name: behavior for behavior in BEHAVIORS},
    names={"see": MapOf(dict.fromkeys(SIGHTS, BOOL))},
    events={MUST_LAND: {}, "go.now": {}},
    urgent=("operator.*",),
    must_land=(MUST_LAND,),
)
MAX_SITUATIONS = 1_500
MAX_SENT = 3


class TooLargeError(Exception):
    """A mission has more situations than are flown."""


Due = tuple[str, int, int]
"""What is sure to happen: its kind, its state, and which entry of that state it belongs to."""


@dataclass(frozen=True)
class _Activity:
    """A behaviour that ends when it is told to; it has no state of its own."""

    state: str
    endings: Mapping[str, str]
    published: None = None

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        word = self.endings.get(self.state)
        return None if word is None else Outcome(word)

    def progress(self) -> None:
        return None

    def saved(self) -> Mapping[str, Any]:
        return {}

    def stop(self) -> None:
        pass


class _Period(NamedTuple):
    """What happens in one mission period."""

    seen: tuple[bool, ...]
    events: tuple[str, ...] = ()
    timers: tuple[tuple[int, int], ...] = ()
    """State and number of the timers that go off."""
    endings: tuple[tuple[str, str], ...] = ()
    """States whose behaviours end, with their outcomes."""
    sent: bool = False
    """Whether the next sent event comes."""


@dataclass
class _Situation:
    """The engine between two periods."""

    state: State
    landed: bool
    due: frozenset[Due] = frozenset()
    moves: list[tuple[int, frozenset[Due]]] = field(default_factory=list)
    """The situations that follow without an event from outside, with what was due all along."""


class Flights:
    """All flights of one mission."""

    def __init__(self, graph: Graph, source: str) -> None:
        self.graph = graph
        self.sights = list(
            product(*((False, True) if f"see.{name}" in source else (False,) for name in SIGHTS))
        )
        self.endings: dict[str, str] = {}
        self.instance = Instance(graph, self)
        self.situations: list[_Situation] = []
        self.answers: set[int] = set()
        """The situations after the event that must land has been handled."""
        self._numbers: dict[Hashable, int] = {}

    # -- the graph's host ---------------------------------------------------------------------

    def begin(self, behavior: BehaviorInfo, state: str, *_: Any) -> _Activity:
        return _Activity(state, self.endings)

    def resume(self, behavior: BehaviorInfo, state: str, *_: Any) -> _Activity:
        return _Activity(state, self.endings)

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        raise LookupError(name)

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        raise LookupError(to)

    # -- flying -------------------------------------------------------------------------------

    def can_stay_up(self) -> bool:
        """Whether the vehicle may stay in the air for ever after the event that must land.

        Raises TooLargeError.
        """
        before = _Situation(self.instance.state, landed=False)
        for seen in self.sights:
            self._move(before, _Period(seen))
        for at in self.situations:  # It grows meanwhile.
            at.due = frozenset(self._due(at.state))
            for period in self._periods(at.state):
                self._move(at, period)
        return bool(self._reachable() & self._staying())

    def _move(self, at: _Situation, period: _Period) -> None:
        """Fly a period; once more for each way in which a behaviour ends in its first step."""
        self._fly_on(at, period)
        old, state = at.state, self.instance.state
        begun = [
            self.graph.nodes[index]
            for index in state.running
            if index not in old.running or old.entries[index] != state.entries[index]
        ]
        for node in begun if not state.outcome else ():
            for word in self._words(node):
                self._fly_on(at, period._replace(endings=((node.path, word),)))

    def _fly_on(self, at: _Situation, period: _Period) -> None:
        after = self._fly(at.state, period, at.landed)
        outside = set(period.events) - {"tag.seen"}
        if after is None:
            return
        if outside == {MUST_LAND}:
            self.answers.add(after)
        if not outside:
            at.moves.append((after, frozenset(self._kept(at, period))))

    def _kept(self, at: _Situation, period: _Period) -> Iterator[Due]:
        """What was due, of states that have not been left since; a sent event, unless it came."""
        entries = self.instance.state.entries
        come = at.state.delayed[0].event.name if period.sent else ""
        for due in at.due:
            if entries.get(due[1]) == due[2] or (due[1] < 0 and due[0] != come):
                yield due

    def _fly(self, before: State, period: _Period, landed: bool) -> int | None:
        """The situation after one period; None where the host lands the vehicle."""
        instance = self.instance
        instance.go_on_from(before.copy())
        instance.records = []
        state = instance.state
        for node, index in period.timers:
            state.timers[node][index].due = 0.0
        if period.sent:
            state.delayed[0].due = 0.0
        self.endings.clear()
        self.endings.update(period.endings)
        for event in period.events:
            instance.post(event)
        see = SimpleNamespace(**dict(zip(SIGHTS, period.seen, strict=True)))
        instance.period(0.0, (see,))
        if instance.ended or instance.reactions:
            return None
        return self._number(state, self._has_landed(state, period, landed))

    def _has_landed(self, state: State, period: _Period, landed: bool) -> bool:
        by_path = self.graph.by_path
        for path, word in period.endings:
            invocation = by_path[path].invocation
            if invocation and invocation.behavior.ends_landed and word == "done":
                landed = True
        for node in state.configuration.behaving:
            running = state.running.get(node.index)
            if node.invocation and node.invocation.behavior.may_take_off:
                landed = landed and bool(running and running.ended)
        return landed

    def _number(self, state: State, landed: bool) -> int:
        key = (*_key(state), landed)
        number = self._numbers.get(key)
        if number is None:
            if len(self.situations) >= MAX_SITUATIONS or len(state.delayed) > MAX_SENT:
                raise TooLargeError
            number = self._numbers[key] = len(self.situations)
            self.situations.append(_Situation(state, landed))
        return number

    # -- what can happen ----------------------------------------------------------------------

    def _periods(self, state: State) -> Iterator[_Period]:
        running = [
            node
            for node in state.configuration.behaving
            if node.invocation and not state.running[node.index].ended
        ]
        endings = [(node.path, word) for node in running for word in self._words(node)]
        timers = [
            (index, number)
            for index, each in state.timers.items()
            for number, timer in enumerate(each)
            if timer.due is not None
        ]
        looks = any(node.invocation and node.invocation.behavior.events for node in running)
        for seen in self.sights:
            yield _Period(seen)
            yield _Period(seen, (MUST_LAND,))
            yield _Period(seen, ("go.now",))
            if looks:
                for events in ((), (MUST_LAND,), ("go.now",)):
                    yield _Period(seen, (*events, "tag.seen"))
            if state.delayed:
                yield _Period(seen, sent=True)
            for count in (1, 2):
                for some in combinations(timers, count):
                    yield _Period(seen, timers=some)
            for count in (1, 2):
                for ended in combinations(endings, count):
                    if len(dict(ended)) == count:
                        yield _Period(seen, endings=ended)

    def _words(self, node: Node) -> list[str]:
        return sorted({*node.invocation.behavior.outcomes, "failed"}) if node.invocation else []

    def _due(self, state: State) -> Iterator[Due]:
        for node in state.configuration.behaving:
            outcomes = node.invocation.behavior.outcomes if node.invocation else {}
            if outcomes and not state.running[node.index].ended:
                yield "end", node.index, state.entries[node.index]
        for index, timers in state.timers.items():
            for number, timer in enumerate(timers):
                if timer.due is not None:
                    yield f"timer {number}", index, state.entries[index]
        for sent in state.delayed:
            yield sent.event.name, -1, 0

    # -- staying up ---------------------------------------------------------------------------

    def _reachable(self) -> set[int]:
        """The situations after the event that must land, without a further one from outside."""
        found = set(self.answers)
        pending = list(found)
        for number in pending:
            new = {after for after, _ in self.situations[number].moves} - found
            found |= new
            pending += new
        return found

    def _staying(self) -> set[int]:
        """The situations of fair loops in the air."""

        def following(number: int) -> Iterator[int]:
            moves = self.situations[number].moves
            return (after for after, _ in moves if not self.situations[after].landed)

        aloft = [number for number, at in enumerate(self.situations) if not at.landed]
        found: set[int] = set()
        for loop in components(aloft, following):
            inside = [
                kept
                for number in loop
                for after, kept in self.situations[number].moves
                if after in loop
            ]
            # Nothing is left out for ever, and periods pass even where nothing happens.
            names = [{due[:2] for due in kept} for kept in inside]
            if inside and not set.intersection(*names):
                found |= loop
        return found


def _key(state: State) -> tuple[Hashable, ...]:
    """What the future depends on, apart from the numbers of entries."""
    return (
        state.configuration.mask,
        tuple(sorted((index, each.ended) for index, each in state.running.items())),
        frozenset(state.finished),
        tuple(
            (index, tuple(timer.due and 1.0 for timer in timers))
            for index, timers in sorted(state.timers.items())
        ),
        tuple(
            (index, tuple((a.since is None, frozenset(a.due), frozenset(a.spent)) for a in armed))
            for index, armed in sorted(state.conditions.items())
        ),
        tuple(
            (index, tuple(node.index for node in memory.states))
            for index, memory in sorted(state.memories.items())
        ),
        tuple((each.name, each.owner and each.owner.index) for each in state.external),
        tuple(each.event.name for each in state.delayed),
    )
