"""Checks of the way through a mission: is the vehicle in the air where it must be, and does it end?

Each state gets the set of what may be so while it is active: the vehicle stands on the ground, it
flies, or that is not known. This follows the behaviours: one that takes off, one that ends landed.
Guards are taken to pass. Where a person, a fault or a condition on the vehicle may have changed it
(an urgent event that is more than advice, `failed`, `vehicle.flying`) it is not known, so that none
is warned of wrongly.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum

from fsm.chart.entry_sets import default_entry, entry_set
from fsm.chart.graph import Edge, Graph, Node
from fsm.checks.structure import late_timers, never_taken
from fsm.host import BehaviorInfo
from vencejo.errors import Fault


class Air(Enum):
    """Where the vehicle is."""

    GROUND = "on the ground"
    FLYING = "in the air"
    UNKNOWN = "not known"


@dataclass(frozen=True)
class _Step:
    """A state that may be entered while the vehicle is somewhere, and the way to it."""

    node: Node
    air: Air
    edge: Edge | None = None
    """The transition that enters it; None at the begin."""
    before: _Step | None = None

    def way(self) -> str:
        """The states passed through: ``takeoff → go → finish``."""
        names: list[str] = []
        step: _Step | None = self
        while step is not None:
            if not step.node.children:
                names.insert(0, step.node.path)
            step = step.before
        return " → ".join(names)


def check_way(graph: Graph) -> list[Fault]:
    """Warnings of motion on the ground, of ends in the air, of missions that never end and of
    endless cycles of landings.

    For a graph without errors: what it lacks may be what takes off.
    """
    endless = list(_never_ends(graph))
    behaviors = [node.invocation.behavior for node in graph.nodes if node.invocation]
    if not any(b.takes_off or b.needs_flight for b in behaviors):
        return endless
    dead = never_taken(graph, late_timers(graph))
    way = _Way(graph, dead)
    endless = endless or list(_endless_landings(graph, dead))
    return [*way.grounded(), *way.ends_in_air(), *endless]


class _Way:
    """The steps that may be made through a graph, each once, with one way to each."""

    def __init__(self, graph: Graph, dead: Collection[Edge]) -> None:
        self.graph = graph
        self.dead = dead
        self.steps: dict[tuple[Node, Air], _Step] = {}
        self.beside = set(_beside_motion(graph))
        self.doubtful = set(_doubtful(graph))
        self.entered: dict[Edge, list[Node]] = {}
        """The states that transitions enter, as far as they were asked for."""
        root = graph.root
        begin = (*entry_set(root, (root,), _nothing).states, root)
        pending = deque(_Step(node, Air.GROUND) for node in begin)
        while pending:
            step = pending.popleft()
            if (step.node, step.air) not in self.steps:
                self.steps[step.node, step.air] = step
                pending += self._following(step)

    def _following(self, step: _Step) -> Iterator[_Step]:
        """The steps after one: by its own transitions, and by those around that it triggers."""
        node = step.node
        behavior = node.invocation.behavior if node.invocation else None
        here = Air.UNKNOWN if node.index in self.beside else step.air
        vocabulary = self.graph.vocabulary
        words = [*behavior.outcomes, "failed"] if behavior else []
        if node.type == "final":
            words = [node.outcome]
        owner = node.parent.owner if node.type == "final" and node.parent else node
        for word in words:
            after = _after(behavior, word, here)
            around = (owner,) if word == "done" else (owner, *owner.ancestors)
            for place in around:
                yield from self._entered(step, place.edges_for(word, vocabulary), after)
        if node.children or node.type in ("final", "history"):
            return
        # Whatever else is taken, here or around, interrupts the behaviour.
        for place in (node, *node.ancestors):
            for edge in place.edges():
                if not _is_outcome(edge):
                    yield from self._entered(step, (edge,), _during(behavior, here))
            if place.type == "parallel":
                done = place.edges_for("done", vocabulary)
                yield from self._entered(step, done, _during(behavior, here))

    def _entered(self, step: _Step, edges: Iterable[Edge], air: Air) -> Iterator[_Step]:
        """The steps by alternatives, up to the first that is sure to be taken."""
        for edge in edges:
            if edge.domain is not None and edge not in self.dead:
                here = Air.UNKNOWN if edge in self.doubtful else air
                if edge not in self.entered:
                    self.entered[edge] = entry_set(edge.domain, edge.targets, _anything).states
                for node in self.entered[edge]:
                    after = _on_entry(node, here)
                    if (node, after) not in self.steps:
                        yield _Step(node, after, edge, step)
            if edge.guard is None:
                return

    def grounded(self) -> Iterator[Fault]:
        """Motion before any take-off."""
        for (node, air), step in self.steps.items():
            if air is Air.GROUND and node.invocation and node.invocation.behavior.needs_flight:
                yield Fault(
                    "not-flying",
                    f"'{node.invocation.behavior.name}' flies nowhere from the ground, and nothing "
                    f"takes off before it: {step.way()}",
                    node.where,
                    "lead through a state with `do: takeoff` first; a graph that is only included "
                    "may leave that to the missions around it",
                    "warning",
                )

    def ends_in_air(self) -> Iterator[Fault]:
        """Ends of the mission in `done` that no landing leads to."""
        for (node, air), step in self.steps.items():
            ends = _ends_mission(node, self.graph) and node.outcome == "done"
            if ends and air is Air.FLYING and step.edge is not None:
                yield Fault(
                    "ends-in-air",
                    f"the mission ends in the air: {step.way()}",
                    step.edge.where,
                    "lead to a state with `do: land` first; without one the host lands it there",
                    "warning",
                )


def _doubtful(graph: Graph) -> Iterator[Edge]:
    """The transitions before which the vehicle may have been brought elsewhere."""
    for node in graph.nodes:
        for edge in node.edges():
            if _goes_wrong(graph, edge) or (edge.guard and "host" in edge.guard.reads):
                yield edge
        for when in node.whens:
            if "host" in when.condition.reads:
                yield from when.edges


def _beside_motion(graph: Graph) -> Iterator[int]:
    """The states of regions beside which another region moves the vehicle."""
    for parallel in graph.nodes:
        regions = default_entry(parallel) if parallel.type == "parallel" else ()
        moving = [region for region in regions if _moves(graph, region)]
        for region in regions:
            if moving and moving != [region]:
                yield from range(region.index, region.last + 1)


def _moves(graph: Graph, region: Node) -> bool:
    invocations = (node.invocation for node in graph.nodes[region.index : region.last + 1])
    return any(i is not None and "motion" in i.behavior.controls for i in invocations)


def _nothing(history: Node) -> tuple[Node, ...]:
    return history.initial


def _anything(history: Node) -> tuple[Node, ...]:
    """What a history state may give back: any of its siblings, so all of them."""
    assert history.parent is not None
    return tuple(child for child in history.parent.children if child.type != "history")


def _is_outcome(edge: Edge) -> bool:
    return edge.kind == "on" and "." not in edge.trigger and edge.trigger != "*"


def _on_entry(node: Node, air: Air) -> Air:
    """Where the vehicle may be in a state that is entered while it is somewhere."""
    behavior = node.invocation.behavior if node.invocation else None
    return Air.UNKNOWN if behavior is not None and behavior.takes_off else air


def _after(behavior: BehaviorInfo | None, word: str, air: Air) -> Air:
    """Where the vehicle is when a behaviour has ended with an outcome."""
    if behavior is None:
        return air
    if word == "done" and (behavior.takes_off or behavior.ends_landed):
        return Air.FLYING if behavior.takes_off else Air.GROUND
    return _during(behavior, air)


def _during(behavior: BehaviorInfo | None, air: Air) -> Air:
    """Where the vehicle is when a behaviour is interrupted, or has ended in any way."""
    if behavior is None or "motion" not in behavior.controls:
        return Air.UNKNOWN if behavior is not None and behavior.on_trust else air
    if behavior.needs_flight:
        # On the ground it is warned of, once, and not of what follows.
        return Air.FLYING if air is Air.FLYING else Air.UNKNOWN
    return Air.GROUND if behavior.ends_landed and air is Air.GROUND else Air.UNKNOWN


def _endless_landings(graph: Graph, dead: Collection[Edge]) -> Iterator[Fault]:
    """Landings after which it takes off again, for ever unless something goes wrong."""
    led = {
        edge: entry_set(edge.domain, edge.targets, _anything).states
        for node in graph.nodes
        for edge in node.edges()
        if edge.domain is not None and edge not in dead and not _goes_wrong(graph, edge)
    }
    following = {
        node: [
            entered
            for place in _together(graph, node)
            for edge in place.edges()
            for entered in led.get(edge, ())
        ]
        for node in graph.nodes
        if not node.children
    }
    for node in graph.nodes:
        if not (node.invocation and node.invocation.behavior.ends_landed):
            continue
        found = _closure(node, following)
        ends = any(_ends_mission(each, graph) for each in found)
        again = [n for n in found if n.invocation and n.invocation.behavior.takes_off]
        if again and not ends and node in found:
            yield Fault(
                "endless-landings",
                f"after '{node.path}' it takes off again in '{again[0].path}', and so on for ever",
                node.where,
                "count the rounds, and lead to a final state after the last",
                "warning",
            )


def _goes_wrong(graph: Graph, edge: Edge) -> bool:
    """Whether a fault or the operator leads there; an event that is only advice is neither."""
    vocabulary, word = graph.vocabulary, edge.trigger
    urgent = vocabulary.is_urgent(word) and vocabulary.reaction(word) != "none"
    return edge.kind == "on" and (urgent or word == "failed")


def _together(graph: Graph, node: Node) -> Iterator[Node]:
    """The states whose transitions may be taken while a state is active."""
    outermost = node
    for ancestor in node.ancestors:
        yield ancestor
        if ancestor.type == "parallel":
            outermost = ancestor
    yield from graph.nodes[outermost.index : outermost.last + 1]


def _closure(start: Node, following: dict[Node, list[Node]]) -> dict[Node, None]:
    """The states that follow one, near ones first."""
    found: dict[Node, None] = {}
    pending = [start]
    while pending:
        for node in following.get(pending.pop(0), ()):
            if node not in found:
                found[node] = None
                pending.append(node)
    return found


def _never_ends(graph: Graph) -> Iterator[Fault]:
    """Missions that have no final state; of one that is never reached `unreachable` tells."""
    root = graph.root
    while root.children and root.children[0].border:
        root = root.children[0]
    if root.type == "parallel" or any(child.type == "final" for child in root.children):
        return
    yield Fault(
        "never-ends",
        "this mission never ends: it has no final state",
        graph.root.where,
        "finish: {type: final}, and a transition that leads there",
        "warning",
    )


def _ends_mission(node: Node, graph: Graph) -> bool:
    return node.type == "final" and node.parent is not None and node.parent.owner is graph.root
