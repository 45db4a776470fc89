"""What can happen in each state of a graph, whatever its data and the world are like.

Guards and conditions may pass or not, constants apart. What has ended is kept in *marks*, a bit
mask with a few bits for each state, numbered in document order, so that those of a subtree are a
range: whether its behaviour has ended, whether in ``done``, and which of its timers have gone off.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

from fsm.chart.graph import Edge, Graph, Node, When
from fsm.chart.selection import chain
from fsm.checks.regions import actions_of, independent_states
from fsm.expressions.compiled import Compiled
from fsm.values.functions import FAILURES

LANDED = 1
"""The mark that a behaviour has brought the vehicle to the ground, until one takes off."""
Option = Edge | None
"""A transition that may be taken; None where all may be refused."""


class Ending(NamedTuple):
    """An outcome that the behaviour of a state can have."""

    node: Node
    word: str
    unless: int
    """The mark of its having ended."""
    marks: int
    """The marks that it adds."""
    lands: bool


class Timer(NamedTuple):
    """What becomes due once while its state is active: a duration, or a condition that is always
    true.
    """

    mark: int
    options: tuple[Option, ...]
    is_sure: bool
    """False where conditions of other states may go first whenever it is due."""
    behind: int
    """The marks of what has gone off before, since it goes first in its state."""


class Chances(NamedTuple):
    """What can happen in a leaf state and in those around it."""

    endings: tuple[Ending, ...]
    timers: tuple[Timer, ...]
    conditions: tuple[Edge, ...]
    """The transitions of its conditions."""
    events: tuple[str, ...]
    """Events from outside that some transition takes."""
    due: int
    """The marks that are sure to come, unless their state is left: a behaviour that can end does,
    a timer goes off."""


class Possibilities:
    """The chances of each leaf state, and who hears what."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.independent = independent_states(graph)
        self.chains = [tuple(chain(node, graph.outer_first)) for node in graph.nodes]
        """Each state with its ancestors, in the order in which events are offered to them."""
        actions = [action for node in graph.nodes for action in actions_of(node) if action.event]
        self.raises = bool(actions)
        """Whether the mission raises or sends events."""
        outside = _events_from_outside(graph)
        inside = {event for node in graph.nodes for event in _events_while_active(node)}
        self.words = Words(graph, {*outside, *inside, *(action.event for action in actions)})
        self._outside = outside
        sent = sorted({action.event for action in actions if action.kind == "send"})
        self.sent = {word: LANDED << 1 + 2 * number for number, word in enumerate(sent)}
        """Events that the mission sends to itself, each with the mark that it is on its way; the
        next mark says that another one may be.
        """
        heard, first = sorted(inside & self.words.taken), 1 + 2 * len(sent)
        self.posted = {word: 1 << first + number for number, word in enumerate(heard)}
        """Events that active states may post for the next period, each with the mark that it
        perhaps waits.
        """
        self.cancels = any(a.kind == "cancel" for node in graph.nodes for a in actions_of(node))
        """Whether the mission takes back what it has sent."""
        first += len(heard)
        self.first_mark = list(accumulate(map(_marks_of, graph.nodes), initial=first))
        """Where the marks of each state begin; one number more than there are states."""
        self._offered: dict[tuple[int, str], tuple[Option, ...]] = {}
        self._chances: dict[int, Chances] = {}
        self._here: dict[int, Chances] = {}

    # -- marks --------------------------------------------------------------------------------

    def marks_inside(self, domain: Node) -> int:
        """The marks of all states inside a state."""
        first, end = self.first_mark[domain.index + 1], self.first_mark[domain.last + 1]
        return (1 << end) - (1 << first)

    def ended(self, node: Node) -> int:
        """The mark that the behaviour of a state has ended."""
        return 1 << self.first_mark[node.index]

    def done(self, node: Node) -> int:
        """The mark that the behaviour of a state has ended in ``done``."""
        return 2 << self.first_mark[node.index]

    def posting(self) -> Iterator[tuple[Node, int]]:
        """The states that may post events while they are active, with the marks of those."""
        for node in self.graph.nodes:
            marks = 0
            for word in set(_events_while_active(node)):
                marks |= self.posted.get(word, 0)
            for action in node.throughout:
                if action.event and action.kind == "send":
                    marks |= 3 * self.sent[action.event]
            if marks:
                yield node, marks

    # -- chances ------------------------------------------------------------------------------

    def chances(self, leaf: int) -> Chances:
        """The chances of a leaf state together with those of the states around it."""
        found = self._chances.get(leaf)
        if found is None:
            here = [self._chances_of(node) for node in self.chains[leaf]]
            found = self._chances[leaf] = Chances(
                tuple(each for chances in here for each in chances.endings),
                tuple(each for chances in here for each in chances.timers),
                tuple(each for chances in here for each in chances.conditions),
                tuple(dict.fromkeys(each for chances in here for each in chances.events)),
                sum(chances.due for chances in here),
            )
        return found

    def _chances_of(self, node: Node) -> Chances:
        found = self._here.get(node.index)
        if found is None:
            found = self._here[node.index] = self._new_chances(node)
        return found

    def _new_chances(self, node: Node) -> Chances:
        endings = tuple(self._endings(node))
        timers = tuple(self._timers(node))
        sure = [timer.mark for timer in timers if timer.is_sure]
        if node.invocation and node.invocation.behavior.outcomes:
            sure.append(self.ended(node))
        conditions = tuple(
            edge
            for when in node.whens
            if constant_of(when.condition) is not False and not _lasts(when)
            for edge in when.edges
            if constant_of(edge.guard) is not False
        )
        heard = tuple(word for word in self.words.heard_in(node) if word in self._outside)
        return Chances(endings, timers, conditions, heard, sum(sure))

    def _endings(self, node: Node) -> Iterator[Ending]:
        if node.invocation is None:
            return
        behavior = node.invocation.behavior
        for word in {**behavior.outcomes, "failed": None}:
            lands = behavior.ends_landed and word == "done"
            marks = self.ended(node) | (self.done(node) if word == "done" else 0)
            yield Ending(node, word, self.ended(node), marks | (LANDED if lands else 0), lands)

    def _timers(self, node: Node) -> Iterator[Timer]:
        mark, behind = 4 << self.first_mark[node.index], 0
        for when in _lasting(node):
            options = alternatives(when.edges)
            yield Timer(mark, options, self._goes_first(node), behind)
            behind |= 0 if None in options else mark
            mark <<= 1
        for after in node.afters:
            yield Timer(mark, alternatives(after.edges), True, behind)
            mark <<= 1

    def _goes_first(self, node: Node) -> bool:
        """Whether no condition of another state can forestall those of a state for ever."""
        inside = self.graph.nodes[node.index + 1 : node.last + 1]
        in_region = any(around.type == "parallel" for around in node.ancestors)
        return not in_region and not any(other.whens for other in inside)

    # -- who hears what -----------------------------------------------------------------------

    def offered(self, leaf: int, event: str) -> tuple[Option, ...]:
        """The transitions that may take an event which is offered to a leaf and then outwards."""
        found = self._offered.get((leaf, event))
        if found is None:
            edges = (e for node in self.chains[leaf] for e in self.words.edges(node, event))
            found = self._offered[leaf, event] = alternatives(edges)
        return found

    def always(self, leaf: int) -> tuple[Option, ...]:
        """The ``always`` transitions that a leaf and the states around it may take."""
        return alternatives(edge for node in self.chains[leaf] for edge in node.always)

    def outcome(self, owner: Node, word: str) -> tuple[Option, ...]:
        """The transitions that may take an outcome of a state: ``done`` is heard by that state
        alone, only ``failed`` climbs out of its graph.
        """
        asked: Sequence[Node] = self.chains[owner.index]
        if word == "done":
            asked = (owner,)
        elif word != "failed":
            within = set(owner.outwards())
            asked = [node for node in asked if node in within]
        vocabulary = self.graph.vocabulary
        return alternatives(edge for node in asked for edge in node.edges_for(word, vocabulary))


class Words:
    """The events of a graph, and which transitions of each state take them."""

    def __init__(self, graph: Graph, names: Iterable[str]) -> None:
        self._edges: dict[str, dict[int, tuple[Edge, ...]]] = {}
        self._heard: dict[int, list[str]] = {}
        names = sorted(names)
        known = set(names)
        for node in graph.nodes:
            heard: dict[str, None] = {}
            for pattern, edges in node.on:
                if not edges or ("." not in pattern and pattern != "*"):
                    continue  # An outcome, or what forbids one.
                exact = pattern in known
                for name in [pattern] if exact else names:
                    if exact or node.matches(pattern, name, graph.vocabulary):
                        heard[name] = None
                        taken = self._edges.setdefault(name, {})
                        taken[node.index] = taken.get(node.index, ()) + edges
            if heard:
                self._heard[node.index] = list(heard)
        self.taken = frozenset(self._edges)
        """The events that some transition takes."""

    def edges(self, node: Node, event: str) -> tuple[Edge, ...]:
        """The transitions that an event may take in one state, in order."""
        return self._edges.get(event, {}).get(node.index, ())

    def heard_in(self, node: Node) -> Sequence[str]:
        """The events that some transition of a state takes."""
        return self._heard.get(node.index, ())


def _events_from_outside(graph: Graph) -> frozenset[str]:
    """The events of the host and those declared, and one of each family that some state takes."""
    vocabulary = graph.vocabulary
    specs = graph.source.closure() if graph.source else ()
    families = {p for node in graph.nodes for p, _ in node.on if p.endswith(".*")}
    return frozenset(
        {
            *vocabulary.events, *vocabulary.must_land,
            *(event.name.text for spec in specs for event in spec.events),
            *(family.removesuffix("*") + "event" for family in families),
            "error.execution", "error.livelock", "any.event",
        }
    )  # fmt: skip


def _events_while_active(node: Node) -> Iterator[str]:
    """The events that a state may post in each period in which it is active."""
    if node.invocation:
        yield from node.invocation.behavior.events
    yield from (action.event for action in node.throughout if action.event)


def constant_of(compiled: Compiled | None) -> bool | None:
    """Whether a guard or condition is always true or always false; None where that depends."""
    if compiled is None:
        return True
    if not compiled.constant:
        return None
    try:
        return compiled.value() is True
    except FAILURES:
        return False


def alternatives(edges: Iterable[Edge]) -> tuple[Option, ...]:
    """The alternatives up to the first that is sure to be taken; None at the end if none is."""
    found: list[Option] = []
    for edge in edges:
        passes = constant_of(edge.guard)
        if passes is not False:
            found.append(edge)
        if passes:
            return tuple(found)
    return (*found, None)


def _lasting(node: Node) -> list[When]:
    """The conditions of a state that are always true, and so become due once."""
    return [when for when in node.whens if _lasts(when)]


def _lasts(when: When) -> bool:
    # With several alternatives that must last, the first is not the first to become due.
    in_order = len(when.edges) == 1 or all(edge.hold is None for edge in when.edges)
    return in_order and constant_of(when.condition) is True


def _marks_of(node: Node) -> int:
    """How many marks a state has."""
    return 2 + len(node.afters) + len(_lasting(node))
