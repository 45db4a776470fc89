"""The configurations a graph can be in, and how they follow each other when guards are ignored.

What the safety proof (:mod:`fsm.safety`) walks through.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product

from fsm.graph import Edge, Graph, Node, default_entry, entry_set
from fsm.regions import regions_apart
from fsm.selection import chain, without_conflicts

MAX_CONFIGURATIONS = 100_000

Config = tuple[tuple[int, ...], frozenset[int]]
"""Active states that have no states inside, and what has ended there: the index of a state whose
behaviour ended in ``done``, its complement (``~index``) after any other outcome."""
Task = tuple[str, int, int] | None
"""What moves a configuration on: a behaviour or a timer; None for what comes at once."""
Move = tuple[Task, Config]


class TooManyError(Exception):
    """More configurations than are looked at."""


class Explorer:
    """The configurations of a graph, and how they follow each other."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.nodes = graph.nodes
        self.vocabulary = graph.vocabulary
        self.apart = regions_apart(graph)
        self.chains = [tuple(chain(node, graph.outer_first)) for node in graph.nodes]
        self._moves: dict[Config, tuple[list[Move], bool]] = {}

    def name(self, config: Config) -> str:
        return " + ".join(self.nodes[leaf].path for leaf in config[0])

    # -- which configurations there are -----------------------------------------------------

    def reach(self) -> dict[Config, Config | None]:
        """Every configuration that can be at rest, in breadth-first order, each with the earlier
        one it is reached from.
        """
        came_from: dict[Config, Config | None] = {}
        resting: dict[Config, Config | None] = {}
        root = self.graph.root
        level: list[tuple[Config | None, Config]] = [
            (None, (self.leaves(nodes), frozenset())) for nodes in self.entries(root, (root,))
        ]
        while level:
            following: list[tuple[Config | None, Config]] = []
            for origin, config in level:
                if config in came_from:
                    continue
                came_from[config] = origin
                if len(came_from) > MAX_CONFIGURATIONS:
                    raise TooManyError
                if self.over(config):
                    continue
                moves, passing = self.moves(config)
                if not passing:
                    resting[config] = origin
                    moves = moves + list(self.happenings(config))
                # A state only passed through does not belong to the path a person sees.
                here = origin if passing else config
                following.extend((here, after) for _, after in moves)
            level = following
        return resting

    def happenings(self, config: Config) -> Iterator[Move]:
        """What events and conditions may do."""
        for node in self.active(config):
            for trigger, edges in node.on:
                if "." in trigger or trigger == "*":
                    yield from self.taken(config, edges)
            for when in node.whens:
                yield from self.taken(config, when.edges)

    def taken(self, config: Config, edges: Iterable[Edge]) -> Iterator[Move]:
        for edge in edges:
            if edge.targets:
                yield from ((None, after) for after in self.take(config, (edge,)))

    def answers(self, configs: Iterable[Config]) -> Iterator[Config]:
        for config in configs:
            for event in self.vocabulary.must_land:
                yield from (answer for _, answer in self.answer(config, event))

    def answer(self, config: Config, event: str) -> Iterator[tuple[tuple[Edge, ...], Config]]:
        """How a configuration may take an event; nothing where it is left to the host."""
        options = [self.choices(self.chains[leaf], event) for leaf in config[0]]
        for picked in product(*options):
            edges = tuple(dict.fromkeys(edge for edge in picked if edge is not None))
            if len(edges) > 1:
                edges = tuple(without_conflicts(edges, self.graph.outer_first))
            if edges:
                for after in self.take(config, edges):
                    yield edges, after

    # -- how they follow each other ---------------------------------------------------------

    def active(self, config: Config) -> Iterator[Node]:
        seen: set[int] = set()
        for leaf in config[0]:
            for node in self.chains[leaf]:
                if node.index not in seen:
                    seen.add(node.index)
                    yield node

    def over(self, config: Config) -> bool:
        """Whether the mission has ended: the host lands it."""
        root = self.graph.root
        return any(
            self.nodes[leaf].type == "final" and _owner(self.nodes[leaf]) is root
            for leaf in config[0]
        ) or any(
            node.type == "parallel" and node.owner is root and self.finished(node, config)
            for node in self.active(config)
        )

    def lands(self, config: Config) -> bool:
        return any(
            node.invocation is not None and node.invocation.behavior.ends_landed
            for node in self.active(config)
        )

    def choices(self, nodes: Sequence[Node], word: str) -> list[Edge | None]:
        """Every transition that may take an event here; None where it may find nobody."""
        found: list[Edge | None] = []
        for node in nodes:
            for edge in node.edges_for(word, self.vocabulary):
                found.append(edge)
                if edge.guard is None:
                    return found
        return [*found, None]

    def heard_by(self, owner: Node, word: str) -> Sequence[Node]:
        """The states that an outcome is offered to; only `failed` climbs out of its graph."""
        chain = self.chains[owner.index]
        if word == "done":
            return (owner,)
        if word == "failed":
            return chain
        within = tuple(owner.outwards())
        return [node for node in chain if node in within]

    def moves(self, config: Config) -> tuple[list[Move], bool]:
        """What may follow by itself, and whether something follows at once."""
        known = self._moves.get(config)
        if known is None:
            if len(self._moves) > MAX_CONFIGURATIONS:
                raise TooManyError
            at_once, certain = self.at_once(config)
            if not certain:
                at_once += self.in_time(config)
            self._moves[config] = known = (list(dict.fromkeys(at_once)), certain)
        return known

    def at_once(self, config: Config) -> tuple[list[Move], bool]:
        """What ``always`` and final states lead to, and whether one of them is sure to be taken."""
        offers: list[list[Edge | None]] = []
        for node in self.active(config):
            if node.always:
                offers.append(_until_unguarded(node.always))
            if node.type == "final":
                heard_by = self.heard_by(_owner(node), node.outcome)
                offers.append(self.choices(heard_by, node.outcome))
            if node.type == "parallel" and self.finished(node, config):
                offers.append(self.choices((node.owner,), "done"))
        moves: list[Move] = [
            (None, after)
            for edges in offers
            for edge in edges
            if edge is not None and edge.targets
            for after in self.take(config, (edge,))
        ]
        certain = any(all(edge is not None and edge.targets for edge in edges) for edges in offers)
        return moves, certain

    def in_time(self, config: Config) -> list[Move]:
        """What outcomes and ``after`` lead to."""
        moves: list[Move] = []
        leaves, ended = config
        for node in self.active(config):
            if node.invocation and node.index not in ended and ~node.index not in ended:
                task = ("do", node.index, 0)
                for word in {**node.invocation.behavior.outcomes, "failed": None}:
                    mark = node.index if word == "done" else ~node.index
                    stays = (leaves, ended | {mark})
                    for edge in self.choices(self.heard_by(node, word), word):
                        if edge is not None and edge.targets:
                            moves += [(task, after) for after in self.take(stays, (edge,))]
                        elif edge is not None or word != "failed":
                            moves.append((task, stays))
                        # A `failed` that nobody takes is the host's, and lands.
            for number, after in enumerate(node.afters):
                task = ("after", node.index, number)
                for edge in _until_unguarded(after.edges):
                    if edge is not None and edge.targets:
                        moves += [(task, then) for then in self.take(config, (edge,))]
        return moves

    def due(self, config: Config) -> set[Task]:
        """What is sure to move on, sooner or later."""
        found: set[Task] = set()
        for node in self.active(config):
            runs = node.index not in config[1] and ~node.index not in config[1]
            if runs and node.invocation and node.invocation.behavior.outcomes:
                found.add(("do", node.index, 0))
            for number, after in enumerate(node.afters):
                if all(edge and edge.targets for edge in _until_unguarded(after.edges)):
                    found.add(("after", node.index, number))
        return found

    def finished(self, node: Node, config: Config) -> bool:
        """Whether a parallel state, or a region of one, has finished."""
        if node.type == "parallel":
            regions = [region for region in default_entry(node) if region.index not in self.apart]
            return all(self.finished(region, config) for region in regions)
        if not node.children:
            return node.index in config[1]
        if node.children[0].border:
            return self.finished(node.children[0], config)
        leaves = (self.nodes[leaf] for leaf in config[0])
        return any(leaf.type == "final" and leaf.parent is node for leaf in leaves)

    def take(self, config: Config, edges: Sequence[Edge]) -> list[Config]:
        """What transitions taken together lead to; several where history decides."""
        leaves, ended = config
        options: list[list[tuple[int, ...]]] = []
        for edge in edges:
            domain = edge.domain
            if domain is None:
                continue
            left = range(domain.index + 1, domain.last + 1)
            leaves = tuple(leaf for leaf in leaves if leaf not in left)
            if ended:
                ended = frozenset(index for index in ended if max(index, ~index) not in left)
            if edge.entered is not None:
                options.append([self.leaves(edge.entered)])
            else:
                options.append([self.leaves(n) for n in self.entries(domain, edge.targets)])
        return [
            (tuple(sorted({*leaves, *(leaf for entered in picked for leaf in entered)})), ended)
            for picked in product(*options)
        ]

    def leaves(self, nodes: Iterable[Node]) -> tuple[int, ...]:
        return tuple(n.index for n in nodes if not n.children and n.index not in self.apart)

    def entries(self, domain: Node, targets: tuple[Node, ...]) -> list[list[Node]]:
        """What may be entered: a history state stands for any state it could remember."""
        asked: dict[int, Node] = {}

        def first(history: Node) -> tuple[Node, ...]:
            asked[history.index] = history
            return history.initial

        entered = entry_set(domain, targets, first)
        if not asked:
            return [entered]
        found = []
        for picked in product(*(_remembered(history) for history in asked.values())):
            memory = dict(zip(asked, picked, strict=True))
            found.append(
                entry_set(domain, targets, lambda h, memory=memory: memory.get(h.index, h.initial))  # type: ignore[misc]
            )
        return found

    # -- loops and dead ends ----------------------------------------------------------------

    def endless(self, starts: Iterable[Config]) -> dict[Config, Config | None]:
        """The configurations from which the ground may never be reached, each with a next one
        that is no better; None where nothing follows at all.
        """
        bad: dict[Config, Config | None] = {}
        number: dict[Config, int] = {}
        low: dict[Config, int] = {}
        open_: dict[Config, None] = {}
        for start in starts:
            if start in number:
                continue
            work = [(start, iter(self.onward(start)))]
            number[start] = low[start] = len(number)
            open_[start] = None
            while work:
                config, following = work[-1]
                for _, after in following:
                    if after not in number:
                        number[after] = low[after] = len(number)
                        open_[after] = None
                        work.append((after, iter(self.onward(after))))
                        break
                    if after in open_:
                        low[config] = min(low[config], number[after])
                else:
                    work.pop()
                    if work:
                        outer = work[-1][0]
                        low[outer] = min(low[outer], low[config])
                    if low[config] == number[config]:
                        self.judge(_popped(open_, config), bad)
        return bad

    def onward(self, config: Config) -> list[Move]:
        return [] if self.over(config) or self.lands(config) else self.moves(config)[0]

    def judge(self, component: set[Config], bad: dict[Config, Config | None]) -> None:
        """Add the configurations of a component, all that follow it being judged already."""
        some = next(iter(component))
        if len(component) == 1 and (self.over(some) or self.lands(some)):
            return
        within = [
            (config, task, after)
            for config in component
            for task, after in self.onward(config)
            if after in component
        ]
        exits = {
            config: after
            for config in component
            for _, after in self.onward(config)
            if after in bad and after not in component
        }
        due = set.intersection(*(self.due(config) for config in component))
        stays = not due if not within else not due - {task for _, task, _ in within}
        if not within and self.moves(some)[1]:
            stays = False
        if not stays and not exits:
            return
        if not within:
            bad[some] = exits.get(some)
            return
        pending = dict(exits)
        for config, _, after in within:
            pending.setdefault(config, after)
        bad.update(pending)


def _owner(final: Node) -> Node:
    """The state that a final state ends."""
    assert final.parent is not None
    return final.parent.owner


def _popped(open_: dict[Config, None], root: Config) -> set[Config]:
    """Take a component off Tarjan's stack, down to its root."""
    component = set()
    while True:
        config, _ = open_.popitem()
        component.add(config)
        if config == root:
            return component


def _until_unguarded(edges: Sequence[Edge]) -> list[Edge | None]:
    """The alternatives that may be taken; None at the end where all may be refused."""
    found: list[Edge | None] = []
    for edge in edges:
        found.append(edge)
        if edge.guard is None:
            return found
    return [*found, None]


def _remembered(history: Node) -> list[tuple[Node, ...]]:
    """Everything a history state may stand for."""
    assert history.parent is not None
    among = inside(history.parent) if history.deep else iter(history.parent.children)
    options = [n for n in among if n.type != "history" and not (history.deep and n.children)]
    if history.parent.type == "parallel":
        return [tuple(options)]
    return [(node,) for node in options]


def inside(node: Node | None) -> Iterator[Node]:
    """Every state inside a state, in document order."""
    for child in node.children if node else ():
        yield child
        yield from inside(child)
