"""Explores the configurations of a graph, with guards ignored: an explicit-state model checker.

The safety proof (:mod:`fsm.checks.safety`) uses it. Sets of states are bit masks, one bit for the
index of each state: a hundred thousand configurations are visited in about a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import Edge, Graph, Node
from fsm.chart.selection import without_conflicts
from fsm.checks.possibilities import Effect, Possibilities, Task, owner_of, up_to_unguarded

MAX_CONFIGURATIONS = 100_000

Config = tuple[int, int]
"""The mask of the active leaf states, and the mask of the behaviours that have ended: the bit
``2 · index`` of a state whose behaviour ended in ``done``, the next bit after any other outcome."""
Move = tuple[Task, Config]


class TooManyError(Exception):
    """There are more configurations than may be explored."""


class Explorer:
    """The state space of a graph: its configurations and the moves between them."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.nodes = graph.nodes
        self.can = Possibilities(graph)
        self.takers = {
            event: takers
            for event in graph.vocabulary.must_land
            if (takers := self.can.takers(event))
        }
        """The events that must land and that some state handles, with the mask of the leaves in or
        around which one does."""
        self._moves: dict[Config, tuple[list[Move], bool]] = {}

    def name(self, config: Config) -> str:
        return " + ".join(self.nodes[leaf].path for leaf in _bits(config[0]))

    # -- which configurations there are -------------------------------------------------------

    def reach(self) -> dict[Config, Config | None]:
        """All stable configurations that can be reached, in breadth-first order, each with its
        predecessor; None for the initial ones. Raises TooManyError.
        """
        root = self.graph.root
        came_from: dict[Config, Config | None] = {
            (self.can.mask(nodes), 0): None for nodes in self.can.entries(root, (root,))
        }
        resting: dict[Config, Config | None] = {}
        pending = list(came_from)
        triggered = self.can.triggered
        for config in pending:  # it grows meanwhile
            if len(came_from) > MAX_CONFIGURATIONS:
                raise TooManyError
            if self.has_ended(config):
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
                    for kept, kept_ended, entered in triggered[leaf]
                ]
            for after in following:
                if after not in came_from:
                    came_from[after] = here
                    pending.append(after)
        return resting

    def active(self, leaves: int) -> tuple[Node, ...]:
        """The active states, in the order in which events are offered to them."""
        seen = (node for leaf in _bits(leaves) for node in self.can.chains[leaf])
        return tuple(dict.fromkeys(seen))

    def has_ended(self, config: Config) -> bool:
        """Whether the mission has ended; then the host lands the vehicle."""
        if config[0] & self.can.ends:
            return True
        return self.can.root_parallel is not None and self.finished(self.can.root_parallel, config)

    def lands(self, config: Config) -> bool:
        """Whether a behaviour that ends on the ground is active."""
        return bool(config[0] & self.can.landing)

    def finished(self, node: Node, config: Config) -> bool:
        """Whether a parallel state, or a region of one, has finished."""
        if node.type == "parallel":
            regions = [
                region for region in default_entry(node) if region.index not in self.can.independent
            ]
            return all(self.finished(region, config) for region in regions)
        if not node.children:
            return bool(config[1] >> 2 * node.index & 1)
        if node.children[0].border:
            return self.finished(node.children[0], config)
        return any(c.type == "final" and config[0] & c.mask for c in node.children)

    # -- how they follow each other -----------------------------------------------------------

    def answers(self, configs: Iterable[Config]) -> Iterator[Config]:
        """The configurations after an event that must land has been handled in one of these."""
        for config in configs:
            for event, takers in self.takers.items():
                if config[0] & takers:
                    yield from (answer for _, answer in self.answer(config, event))

    def answer(self, config: Config, event: str) -> Iterator[tuple[tuple[Edge, ...], Config]]:
        """The transitions by which a configuration may take an event, and the configuration after
        them; nothing where the event is left to the host.
        """
        options = [
            self.can.offered(leaf, event) for leaf in _bits(config[0] & self.takers.get(event, 0))
        ]
        for picked in product(*options):
            edges = list(dict.fromkeys(edge for edge in picked if edge is not None))
            for effects in product(*map(self.can.effects, edges)) if edges else ():
                yield self.together(config, dict(zip(edges, effects, strict=True)))

    def together(
        self, config: Config, offered: Mapping[Edge, Effect]
    ) -> tuple[tuple[Edge, ...], Config]:
        """Those of the transitions with these effects that do not conflict, and what they make of
        a configuration.
        """

        def in_conflict(a: Edge, b: Edge) -> bool:
            return bool(~offered[a].kept & ~offered[b].kept)

        taken = tuple(without_conflicts(offered, in_conflict, self.graph.outer_first))
        leaves, ended = config
        for edge in taken:
            leaves, ended = leaves & offered[edge].kept, ended & offered[edge].kept_ended
        for edge in taken:
            leaves |= offered[edge].entered
        return taken, (leaves, ended)

    def moves(self, config: Config) -> tuple[list[Move], bool]:
        """The moves without an event from outside, and whether the configuration is left at once.

        Raises TooManyError.
        """
        known = self._moves.get(config)
        if known is None:
            if len(self._moves) > MAX_CONFIGURATIONS:
                raise TooManyError
            moves, certain = self.immediate_moves(config)
            if not certain:
                moves += self.eventual_moves(config)
            self._moves[config] = known = (list(dict.fromkeys(moves)), certain)
        return known

    def immediate_moves(self, config: Config) -> tuple[list[Move], bool]:
        """The moves by ``always`` and by a final state, and whether one of them must happen."""
        offers: list[list[Edge | None]] = []
        leaves, ended = config
        some_ended = ended or leaves & self.can.finals
        if not some_ended and not leaves & self.can.with_always:
            return [], False
        for node in self.active(leaves):
            if node.always:
                offers.append(up_to_unguarded(node.always))
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

    def eventual_moves(self, config: Config) -> list[Move]:
        """The moves by outcomes of behaviours and by ``after``."""
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
        """The behaviours and timers that are sure to move the configuration on, sooner or later."""
        found: set[Task] = set()
        leaves, ended = config
        for node in self.active(leaves):
            runs = not ended >> 2 * node.index & 3
            if runs and node.invocation and node.invocation.behavior.outcomes:
                found.add(("do", node.index, 0))
            for number, after in enumerate(node.afters):
                if all(edge and edge.targets for edge in up_to_unguarded(after.edges)):
                    found.add(("after", node.index, number))
        return found

    # -- loops and dead ends ------------------------------------------------------------------

    def endless(self, starts: Iterable[Config]) -> dict[Config, Config | None]:
        """The configurations from which the vehicle may never land, each with a successor for which
        the same holds; None where there is no successor at all.

        Strongly connected components by Tarjan's algorithm (1972), without recursion.
        """
        bad: dict[Config, Config | None] = {}
        number: dict[Config, int] = {}
        low: dict[Config, int] = {}
        open_: dict[Config, None] = {}
        for start in starts:
            if start in number:
                continue
            work = [(start, iter(self.successors(start)))]
            number[start] = low[start] = len(number)
            open_[start] = None
            while work:
                config, following = work[-1]
                for _, after in following:
                    if after not in number:
                        number[after] = low[after] = len(number)
                        open_[after] = None
                        work.append((after, iter(self.successors(after))))
                        break
                    if after in open_:
                        low[config] = min(low[config], number[after])
                else:
                    work.pop()
                    if work:
                        outer = work[-1][0]
                        low[outer] = min(low[outer], low[config])
                    if low[config] == number[config]:
                        self.judge_component(_popped(open_, config), bad)
        return bad

    def successors(self, config: Config) -> list[Move]:
        """The moves that are followed; none from where the vehicle lands."""
        return [] if self.lands(config) or self.has_ended(config) else self.moves(config)[0]

    def judge_component(self, component: set[Config], bad: dict[Config, Config | None]) -> None:
        """Add the configurations of a component to ``bad`` if the vehicle may stay in it for
        ever, or leave it for a bad one; the components that follow it are judged already.
        """
        some = next(iter(component))
        if len(component) == 1 and (self.has_ended(some) or self.lands(some)):
            return
        within = [
            (config, task, after)
            for config in component
            for task, after in self.successors(config)
            if after in component
        ]
        exits = {
            config: after
            for config in component
            for _, after in self.successors(config)
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
