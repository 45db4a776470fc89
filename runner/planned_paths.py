"""The ways that a mission may fly, followed over its graph before the flight.

From the mission's begin on, whatever may come is followed: each outcome of a behaviour, each event,
condition and timer that a transition waits for, with the values of parameters and data as far as
they are known then. A guard that depends on the flight both passes and does not. Where the vehicle
is follows from the plans of the behaviours: at the end of a plan that is done, anywhere along one
that is interrupted. Ways are followed in the order of the battery that they take at the least, so
that the first way to a leg is the one that takes least.

The work is bounded (MAX_WORK); a mission with more ways has some that are not looked at, which is
told.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from itertools import count
from math import inf, isfinite
from typing import Any

from behaviors import UNKNOWN, PlannedLeg
from behaviors.plan import Unknown
from fsm import Graph
from fsm.chart.entry_sets import default_entry, entry_set, transition_domain
from fsm.chart.graph import Edge, Node
from fsm.chart.selection import chain
from fsm.expressions.compiled import Compiled
from fsm.expressions.scope import CONFIGURATION_SLOT, PERIOD_SLOT
from fsm.host import PERIOD, BehaviorInfo
from fsm.values.functions import FAILURES
from runner.planned_moment import (
    Actions,
    Moment,
    Way,
    is_finished,
    leaves_of,
    remembered,
    restorable,
)
from runner.planned_motion import Motion, Place, PlannedShape, Planner, Setting
from vencejo.errors import Fault
from vencejo.geometry import Point

MAX_WORK = 4_000
"""Moments, transitions and plans looked at, as a bound on the time: less than half a second."""
MAX_VALUES = 60
"""Visits of the same states with other data; after that data count as unknown."""


@dataclass(frozen=True, slots=True)
class PossibleLeg:
    """A leg that the mission may fly. Mission frame, metres."""

    node: Node
    """The state that flies it."""
    begin: Point | None
    """None where it is not known."""
    leg: PlannedLeg
    way: str
    """The states passed through up to this one: ``takeoff → go``."""
    charge: float
    """Share of a full battery that was taken before it, at the least."""
    sure: bool
    """Whether it begins at one place, not anywhere along a leg that was interrupted."""

    @property
    def behavior(self) -> BehaviorInfo:
        assert self.node.invocation is not None
        return self.node.invocation.behavior


@dataclass(slots=True)
class PossiblePaths:
    """All legs that a mission may fly, as far as they are known."""

    legs: list[PossibleLeg] = field(default_factory=list)
    """In the order of the battery that the ways to them take."""
    unknown: dict[Node, None] = field(default_factory=dict)
    """States that fly where only the flight knows; what follows them is unknown, too."""
    shapes: dict[PlannedShape, None] = field(default_factory=dict)
    """Points, routes and areas that behaviours are given, as far as they are known."""
    faults: list[Fault] = field(default_factory=list)
    """Plans that could not be asked for."""
    complete: bool = True
    """False where there are more ways than were followed."""


def possible_paths(graph: Graph, parameters: Mapping[str, Any], setting: Setting) -> PossiblePaths:
    """Follow the ways of a mission; ``parameters`` are those that differ from their defaults."""
    return _Walk(graph, parameters, setting).found


class _Walk:
    """Follows the ways, those first that take the least of the battery."""

    def __init__(self, graph: Graph, parameters: Mapping[str, Any], setting: Setting) -> None:
        self.graph = graph
        self.setting = setting
        self.found = PossiblePaths()
        self.planner = Planner(setting)
        self.taken = 0
        """Moments looked at and transitions taken, those of many states or events for several."""
        self.legs: set[tuple[Node, Point | None, Point, bool]] = set()
        self.slots = sorted(
            {data.slot for node in graph.nodes for data in node.data}
            | {given.slot for node in graph.nodes for given in node.given}
        )
        """Those of values that may change."""
        self.own_events = {
            event
            for node in graph.nodes
            if node.invocation
            for event in node.invocation.behavior.events
        }
        declared = {
            named.name.text
            for spec in (graph.source.closure() if graph.source else ())
            for named in spec.events
        }
        sent = {message.event for message in graph.messages if message.id_ is not None}
        raised = {message.event for message in graph.messages if message.id_ is None}
        self.only_raised = raised - sent - declared - set(graph.vocabulary.events)
        """Events that come from nowhere but the mission's own `raise`."""
        self.visits: dict[tuple[Node, ...], int] = {}
        seen: set[Any] = set()
        order, queue = count(), list[tuple[float, int, Moment]]()
        heappush(queue, (0.0, next(order), self.begin(parameters)))
        while queue and self.work < MAX_WORK:
            moment = heappop(queue)[2]
            key = self.key(moment)
            if key in seen:
                continue
            seen.add(key)
            self.taken += moment.size
            for following in self.following(moment):
                heappush(queue, (following.charge, next(order), following))
                if self.work >= MAX_WORK:
                    break
        self.found.complete = not queue
        self.found.faults, self.found.unknown = self.planner.faults, self.planner.unknown
        self.found.shapes = self.planner.shapes

    @property
    def work(self) -> int:
        return self.taken + self.planner.asked

    def key(self, moment: Moment) -> tuple[Any, ...]:
        """What tells a moment from others; the states' data become unknown after many visits."""
        visits = self.visits[moment.active] = self.visits.get(moment.active, 0) + 1
        if visits > MAX_VALUES:
            for slot in self.slots:
                moment.values[slot] = UNKNOWN
        values = repr([moment.values[slot] for slot in self.slots])
        memories = tuple(moment.memories.items())
        state = moment.active, moment.ended, moment.pending, memories, moment.resumed
        return *state, moment.place, moment.motion, values

    def begin(self, parameters: Mapping[str, Any]) -> Moment:
        graph, frame = self.graph, self.setting.frame
        values: list[Any] = [UNKNOWN] * graph.slots
        values[PERIOD_SLOT] = PERIOD
        for name, slot in graph.parameter_slots.items():
            parameter = graph.parameters[name]
            value = parameters.get(name, UNKNOWN if parameter.required else parameter.default)
            values[slot] = frame.located(parameter.type, value)
        place = Place((Point(0.0, 0.0, 0.0),), self.setting.yaw, False)
        moment = Moment((), values, place, Way(None, ()))
        root = graph.root
        entered = entry_set(root, default_entry(root), moment.memories.get).states
        return self.enter(moment, [root, *entered])

    # -- what may come next ---------------------------------------------------------------------

    def following(self, moment: Moment) -> Iterator[Moment]:
        """The moments that may follow one."""
        if moment.over:
            return
        for leaf in leaves_of(moment):
            for edge, sure in self.choices(moment, (n.always for n in self.chain(leaf))):
                yield self.take(moment, edge, self.anywhere(moment))
                if sure:
                    return
        if moment.pending:
            yield from self.hear(moment)
            return
        moment = self.start_motion(moment)
        interrupted = self.anywhere(moment)
        yield from self.outcomes(moment, interrupted)
        yield from self.events(moment, interrupted)
        yield from self.waits(moment, interrupted)

    def hear(self, moment: Moment) -> Iterator[Moment]:
        """The moments after the first of the pending outcomes and events has been heard."""
        (owner, name), rest = moment.pending[0], moment.pending[1:]
        moment = replace(moment, pending=rest)
        if owner is not None:
            if owner not in moment.active:
                yield moment
                return
            yield from self.offered(moment, self.heard_by(owner, name), name, self.anywhere(moment))
            return
        for leaf in leaves_of(moment):
            yield from self.offered(moment, self.chain(leaf), name, self.anywhere(moment))

    def offered(
        self, moment: Moment, nodes: Sequence[Node], name: str, place: Place
    ) -> Iterator[Moment]:
        """The moments after an outcome or event was offered to states; also if none takes it."""
        groups = (node.edges_for(name, self.graph.vocabulary) for node in nodes)
        for edge, sure in self.choices(moment, groups):
            yield self.take(moment, edge, place)
            if sure:
                return
        yield moment

    def outcomes(self, moment: Moment, interrupted: Place) -> Iterator[Moment]:
        """The moments after a behaviour has ended."""
        for node in moment.active:
            if node.invocation is None or node in moment.ended:
                continue
            behavior = node.invocation.behavior
            moves = moment.motion is not None and moment.motion.node is node
            for word in (*behavior.outcomes, "failed"):
                ended, place, charge = moment, moment.place, moment.charge
                if moves:
                    reached = self.reached(moment, word, interrupted)
                    if reached is None:
                        continue
                    place, charge = reached
                    ended = replace(moment, motion=None, place=place, charge=charge)
                ended = replace(ended, ended=moment.ended | {node})
                heard = self.heard_by(node, word)
                groups = (each.edges_for(word, self.graph.vocabulary) for each in heard)
                unheard = True
                for edge, sure in self.choices(moment, groups):
                    yield self.take(ended, edge, place)
                    unheard = not sure
                    if sure:
                        break
                if unheard and word != "failed":  # then the host lands
                    done = word == "done"
                    yield replace(ended, pending=self.finished(ended, node)) if done else ended

    def events(self, moment: Moment, interrupted: Place) -> Iterator[Moment]:
        """The moments after an event that a transition waits for."""
        taken: set[Edge] = set()
        possible = {
            event
            for node in moment.active
            if node.invocation
            for event in node.invocation.behavior.events
        }
        for leaf in leaves_of(moment):
            around = self.chain(leaf)
            for name in dict.fromkeys(name for node in around for name, _ in node.on):
                event = "any.event" if name == "*" else name
                impossible = event in self.only_raised or event in self.own_events - possible
                if "." not in event or impossible:
                    continue
                groups = (node.edges_for(event, self.graph.vocabulary) for node in around)
                for edge, sure in self.choices(moment, groups):
                    if edge not in taken:
                        taken.add(edge)
                        yield self.take(moment, edge, interrupted)
                    if sure:
                        break

    def waits(self, moment: Moment, interrupted: Place) -> Iterator[Moment]:
        """The moments after a condition has come true, or a timer is due."""
        for node in moment.active:
            for when in node.whens:
                if self.value(moment, when.condition) is not False:
                    for edge, sure in self.choices(moment, [when.edges]):
                        yield self.take(moment, edge, interrupted)
                        if sure:
                            break
            for after in node.afters:
                seconds = self.value(moment, after.duration)
                late = replace(moment, charge=moment.charge + self.hovering(moment, node, seconds))
                for edge, sure in self.choices(moment, [after.edges]):
                    yield self.take(late, edge, interrupted)
                    if sure:
                        break

    def choices(
        self, moment: Moment, groups: Iterable[Iterable[Edge]]
    ) -> Iterator[tuple[Edge, bool]]:
        """The transitions that may be taken, in order, each with whether it is sure to be."""
        for edges in groups:
            for edge in edges:
                passes = True if edge.guard is None else self.value(moment, edge.guard)
                if passes is not False:
                    sure = passes is True and edge.hold is None
                    yield edge, sure
                    if sure:
                        return

    def chain(self, leaf: Node) -> Sequence[Node]:
        return chain(leaf, self.graph.outer_first)

    def heard_by(self, owner: Node, word: str) -> Sequence[Node]:
        """The states that an outcome is offered to."""
        if word == "done":
            return (owner,)
        around = self.chain(owner)
        if word == "failed":
            return around
        within = tuple(owner.outwards())
        return [node for node in around if node in within]

    def value(self, moment: Moment, compiled: Compiled) -> Any:
        """The value of an expression; None where it is not known."""
        try:
            moment.values[CONFIGURATION_SLOT] = sum(node.mask for node in moment.active)
            value = compiled.function(moment.values, UNKNOWN)
        except FAILURES:
            return None
        return None if isinstance(value, Unknown) else value

    # -- a transition ---------------------------------------------------------------------------

    def take(self, moment: Moment, edge: Edge, place: Place) -> Moment:
        """The moment after a transition, taken while the vehicle is at a place."""
        self.taken += moment.size
        domain = transition_domain(edge, moment.memories.get)
        values = list(moment.values)
        actions = Actions(values)
        left = [n for n in moment.active if domain is not None and domain.contains(n)]
        gone = frozenset(left)
        for node in reversed(left):
            actions.run(node.exit_actions, node)
        actions.run(edge.actions, edge.node)
        motion = moment.motion
        stopped = motion is not None and motion.node in gone
        after = replace(
            moment,
            active=tuple(node for node in moment.active if node not in gone),
            values=values,
            place=place if stopped or motion is None else moment.place,
            motion=None if stopped else motion,
            ended=moment.ended - gone,
            resumed=moment.resumed - gone,
            pending=(*moment.pending, *actions.raised),
            memories={**moment.memories, **remembered(left, moment.active)}
            if left
            else moment.memories,
        )
        if domain is None:
            return after
        found = entry_set(domain, edge.targets, moment.memories.get)
        after = self.enter(after, found.states)
        if found.histories:
            kept = (node for h in found.histories for node in found.states if node in restorable(h))
            after.resumed = after.resumed | frozenset(kept)
            for node in after.resumed:
                for data in node.data:
                    after.values[data.slot] = UNKNOWN  # it comes back as it was then
        return after

    def enter(self, moment: Moment, entered: Sequence[Node]) -> Moment:
        """The moment after states have been entered."""
        active = sorted({*moment.active, *entered}, key=lambda node: node.index)
        actions = Actions(moment.values)
        names = tuple(node.path for node in entered if not node.children)
        after = replace(moment, active=tuple(active), way=Way(moment.way, names))
        for node in entered:
            self.fill(after, node)
            actions.run(node.entry, node)
            after.pending = (*after.pending, *actions.raised)
            actions.raised.clear()
            if node.type == "final":
                self.finish(after, node)
        return after

    def fill(self, moment: Moment, node: Node) -> None:
        for given in node.given:
            source = given.with_ if given.live is None else given.live
            value = given.default if source is None else self.value(moment, source)
            moment.values[given.slot] = UNKNOWN if source and value is None else value
        for data in node.data:
            value = self.value(moment, data.initial)
            known = value is not None or data.initial.constant
            moment.values[data.slot] = value if known else UNKNOWN

    def finish(self, moment: Moment, final: Node) -> None:
        """Note what an entered final state ends."""
        assert final.parent is not None
        owner = final.parent.owner
        if owner.parent is None:
            moment.over = True
            return
        done = self.finished(moment, owner) if final.outcome == "done" else ()
        moment.pending = (*moment.pending, (owner, final.outcome), *done)

    def finished(self, moment: Moment, region: Node) -> tuple[tuple[Node | None, str], ...]:
        """The pending outcomes, and `done` of a parallel state whose last region has finished."""
        parallel = region.parent
        if parallel is None or parallel.type != "parallel":
            return ()
        if not all(is_finished(each, moment) for each in default_entry(parallel)):
            return ()
        return ((parallel.owner, "done"),)

    # -- motion ---------------------------------------------------------------------------------

    def start_motion(self, moment: Moment) -> Moment:
        """The moment after a behaviour that moves the vehicle has begun, if one does."""
        behaving = [
            (node, node.invocation.behavior)
            for node in moment.active
            if node.invocation is not None and node not in moment.ended
        ]
        moving = [node for node, each in behaving if each.on_trust or "motion" in each.controls]
        for node, _ in behaving:
            if node not in moving:
                self.planner.look_at(node, lambda c: self.value(moment, c))
        for node in moving:
            if moment.motion is not None and moment.motion.node is node:
                continue
            motion = self.planner.motion(node, moment.place, lambda c: self.value(moment, c))
            if node in moment.resumed and any(len(c.legs) > 1 for c in motion.courses):
                motion = replace(motion, courses=())  # it goes on in the midst of them
                self.planner.unknown[node] = None
            following = replace(moment, motion=motion)
            self.note(following, motion)
            return following
        return moment

    def note(self, moment: Moment, motion: Motion) -> None:
        """Keep the legs of a motion that has begun, as far as they are flown."""
        horizon, way = self.horizon(moment), moment.way.shown()
        for course in motion.courses:
            charge, sure = moment.charge, len(motion.courses) == 1
            for begin, leg in course.flown(horizon):
                key = motion.node, begin, leg.to, sure
                if key not in self.legs:
                    self.legs.add(key)
                    found = PossibleLeg(motion.node, begin, leg, way, charge, sure)
                    self.found.legs.append(found)
                charge += self.planner.charge([(begin, leg)])

    def hovering(self, moment: Moment, node: Node, seconds: Any) -> float:
        """The share of a full battery taken until a state's timer is due, at the least."""
        timed = isinstance(seconds, (int, float)) and isfinite(seconds) and seconds > 0
        begun = moment.motion is None or moment.motion.node is node
        model = self.setting.model
        if not timed or model is None or node.children or not begun or not moment.place.flying:
            return 0.0
        here = Point(0.0, 0.0, 0.0)
        return model.leg_charge(here, here, None, seconds)

    def horizon(self, moment: Moment) -> float:
        """Seconds after which a timer is sure to have interrupted the motion that has begun."""
        motion, found = moment.motion, inf
        if motion is None:
            return found
        for node in moment.active:
            for after in node.afters:
                seconds = self.value(moment, after.duration)
                if isinstance(seconds, (int, float)) and any(
                    edge.guard is None and edge.domain and edge.domain.contains(motion.node)
                    for edge in after.edges
                ):
                    found = min(found, seconds)
        return found

    def anywhere(self, moment: Moment) -> Place:
        """Where the vehicle may be when what it does is interrupted."""
        motion = moment.motion
        return moment.place if motion is None else motion.anywhere(self.horizon(moment))

    def reached(self, moment: Moment, word: str, interrupted: Place) -> tuple[Place, float] | None:
        """Where the vehicle is when its motion has ended, and the charge taken by then; None if it
        cannot have ended so.
        """
        motion = moment.motion
        assert motion is not None
        if word != "done":
            return interrupted, moment.charge
        ended = motion.done(self.horizon(moment))
        if ended is None:
            return None
        place, courses = ended
        charges = [self.planner.charge(course.flown(inf)) for course in courses]
        return place, moment.charge + min(charges, default=0.0)
