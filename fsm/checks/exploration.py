"""The configurations a graph can be in, and how they follow each other when guards are ignored.

What the safety proof (:mod:`fsm.checks.safety`) walks through. Sets of states are bit masks, one
bit for the index of each state: a hundred thousand configurations are looked at in about a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import Edge, Graph, Node
from fsm.chart.selection import without_conflicts
from fsm.checks.possibilities import Possibilities, Task, owner_of, until_unguarded

MAX_CONFIGURATIONS = 100_000

Config = tuple[int, int]
"""The mask of the active states that have no states inside; and the mask of what has ended there:
of a state whose behaviour ended in ``done`` the bit ``2 · index``, after any other outcome the
next one."""
Move = tuple[Task, Config]


class TooManyError(Exception):
    """More configurations than are looked at."""


class Explorer:
    """The configurations of a graph, and how they follow each other."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.nodes = graph.nodes
        self.can = Possibilities(graph)
        self.takers = {
            event: takers
            for event in graph.vocabulary.must_land
            if (takers := self.can.takers(event))
        }
        """The events that must land and that somebody handles, with the states that do."""
        self._moves: dict[Config, tuple[list[Move], bool]] = {}

    def name(self, config: Config) -> str:
        return " + ".join(self.nodes[leaf].path for leaf in _bits(config[0]))

    # -- which configurations there are -------------------------------------------------------

    def reach(self) -> dict[Config, Config | None]:
        """Every configuration that can be at rest, in breadth-first order, each with the earlier
        one it is reached from.
        """
        root = self.graph.root
        came_from: dict[Config, Config | None] = {
            (self.can.mask(nodes), 0): None for nodes in self.can.entries(root, (root,))
        }
        resting: dict[Config, Config | None] = {}
        pending = list(came_from)
        happenings = self.can.happenings
        for config in pending:  # it grows meanwhile
            if len(came_from) > MAX_CONFIGURATIONS:
                raise TooManyError
            if self.over(config):
                continue
            origin = came_from[config]
            moves, passing = self.moves(config)
            # A state only passed through does not belong to the path a person sees.
            here = origin if passing else config
            following = [after for _, after in moves]
            if not passing:
                resting[config] = origin
                leaves, ended = config
                following += [
                    (leaves & kept | entered, ended & kept_ended)
                    for leaf in _bits(leaves)
                    for kept, kept_ended, entered in happenings[leaf]
                ]
            for after in following:
                if after not in came_from:
                    came_from[after] = here
                    pending.append(after)
        return resting

    def active(self, leaves: int) -> tuple[Node, ...]:
        """The active states, those around each leaf in the order in which they are asked."""
        seen = (node for leaf in _bits(leaves) for node in self.can.chains[leaf])
        return tuple(dict.fromkeys(seen))

    def over(self, config: Config) -> bool:
        """Whether the mission has ended: the host lands it."""
        if config[0] & self.can.ends:
            return True
        return self.can.whole is not None and self.finished(self.can.whole, config)

    def lands(self, config: Config) -> bool:
        return bool(config[0] & self.can.landing)

    def finished(self, node: Node, config: Config) -> bool:
        """Whether a parallel state, or a region of one, has finished."""
        if node.type == "parallel":
            regions = [
                region for region in default_entry(node) if region.index not in self.can.apart
            ]
            return all(self.finished(region, config) for region in regions)
        if not node.children:
            return bool(config[1] >> 2 * node.index & 1)
        if node.children[0].border:
            return self.finished(node.children[0], config)
        return any(c.type == "final" and config[0] & c.mask for c in node.children)

    # -- how they follow each other -----------------------------------------------------------

    def answers(self, configs: Iterable[Config]) -> Iterator[Config]:
        for config in configs:
            for event, takers in self.takers.items():
                if config[0] & takers:
                    yield from (answer for _, answer in self.answer(config, event))

    def answer(self, config: Config, event: str) -> Iterator[tuple[tuple[Edge, ...], Config]]:
        """How a configuration may take an event; nothing where it is left to the host."""
        options = [
            self.can.offered(leaf, event) for leaf in _bits(config[0] & self.takers.get(event, 0))
        ]
        for picked in product(*options):
            edges = tuple(dict.fromkeys(edge for edge in picked if edge is not None))
            if len(edges) > 1:
                edges = tuple(without_conflicts(edges, self.graph.outer_first))
            for effects in product(*map(self.can.effects, edges)) if edges else ():
                leaves, ended = config
                for effect in effects:
                    leaves, ended = leaves & effect.kept, ended & effect.kept_ended
                for effect in effects:
                    leaves |= effect.entered
                yield edges, (leaves, ended)

    def moves(self, config: Config) -> tuple[list[Move], bool]:
        """What may follow by itself, and whether something follows at once."""
        known = self._moves.get(config)
        if known is None:
            if len(self._moves) > MAX_CONFIGURATIONS:
                raise TooManyError
            moves, certain = self.at_once(config)
            if not certain:
                moves += self.in_time(config)
            self._moves[config] = known = (list(dict.fromkeys(moves)), certain)
        return known

    def at_once(self, config: Config) -> tuple[list[Move], bool]:
        """What ``always`` and final states lead to, and whether one of them is sure to be taken."""
        offers: list[list[Edge | None]] = []
        leaves, ended = config
        some_ended = ended or leaves & self.can.finals
        if not some_ended and not leaves & self.can.choosing:
            return [], False
        for node in self.active(leaves):
            if node.always:
                offers.append(until_unguarded(node.always))
            if not some_ended:
                continue
            if node.type == "final":
                heard_by = self.can.heard_by(owner_of(node), node.outcome)
                offers.append(self.can.choices(heard_by, node.outcome))
            elif node.type == "parallel" and self.finished(node, config):
                offers.append(self.can.choices((node.owner,), "done"))
        moves: list[Move] = [
            (None, (leaves & kept | entered, ended & kept_ended))
            for edges in offers
            for edge in edges
            if edge is not None and edge.targets
            for kept, kept_ended, entered in self.can.effects(edge)
        ]
        certain = any(all(edge is not None and edge.targets for edge in edges) for edges in offers)
        return moves, certain

    def in_time(self, config: Config) -> list[Move]:
        """What outcomes and ``after`` lead to."""
        moves: list[Move] = []
        leaves, ended = config
        courses = self.can.courses
        for leaf in _bits(leaves):
            for task, unless, mark, effects in courses[leaf]:
                if ended & unless:
                    continue
                for effect in effects:
                    if effect is None:
                        moves.append((task, (leaves, ended | mark)))
                    else:
                        kept, kept_ended, entered = effect
                        after = leaves & kept | entered, (ended | mark) & kept_ended
                        moves.append((task, after))
        return moves

    def due(self, config: Config) -> set[Task]:
        """What is sure to move on, sooner or later."""
        found: set[Task] = set()
        leaves, ended = config
        for node in self.active(leaves):
            runs = not ended >> 2 * node.index & 3
            if runs and node.invocation and node.invocation.behavior.outcomes:
                found.add(("do", node.index, 0))
            for number, after in enumerate(node.afters):
                if all(edge and edge.targets for edge in until_unguarded(after.edges)):
                    found.add(("after", node.index, number))
        return found

    # -- loops and dead ends ------------------------------------------------------------------

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
        return [] if self.lands(config) or self.over(config) else self.moves(config)[0]

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


def _bits(mask: int) -> Iterator[int]:
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest


def _popped(open_: dict[Config, None], root: Config) -> set[Config]:
    """Take a component off Tarjan's stack, down to its root."""
    component = set()
    while True:
        config, _ = open_.popitem()
        component.add(config)
        if config == root:
            return component
