"""Macrosteps of a graph with guards either way: everything that one event can lead to.

This follows :mod:`fsm.engine.interpreter` step by step (microsteps, then ``always`` before raised
events, until nothing moves), with sets of states as bit masks and without data: where a guard
depends on data, both ways are followed. A state that is only passed through is no place of rest.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, product
from typing import NamedTuple

from fsm.chart.entry_sets import Recorded, default_entry, entry_set, transition_domain
from fsm.chart.executable import Action
from fsm.chart.graph import Edge, Graph, Node
from fsm.chart.selection import exit_sets_meet, without_conflicts
from fsm.checks.possibilities import LANDED, Ending, Option, Possibilities

MAX_STEPS = 120_000
"""Steps that the proof may take in all."""
SCANNED = 16
"""States that are looked at in the time of a step."""
MAX_WAITING = 50
"""Raised events that may wait to be heard at one time."""


class TooManyError(Exception):
    """The proof takes more steps than it may."""


class UnknownError(Exception):
    """A graph does something that the proof cannot follow."""


class Situation(NamedTuple):
    """What the future depends on, between two mission periods."""

    leaves: int
    """The active leaf states."""
    marks: int
    """What has ended in the active states (see :mod:`fsm.checks.possibilities`)."""
    memory: int
    """What the history states remember."""


class Heard(NamedTuple):
    """An event, or the outcome of a state, that waits to be heard in a macrostep."""

    word: str
    owner: Node | None = None


Queue = tuple[Heard, ...]


class Result(NamedTuple):
    """One way in which a macrostep may go."""

    situation: Situation | None
    """None where the host lands the vehicle: the mission has ended, or it must react."""
    relieved: int
    """The marks of what has happened, and of the states that were left on the way."""
    edge: Edge | None
    """The first transition taken."""


class _Micro(NamedTuple):
    """Amid a macrostep."""

    leaves: int
    marks: int
    memory: int
    queue: Queue
    relieved: int
    edge: Edge | None


class _Effect(NamedTuple):
    """What taking some transitions together changes."""

    domains: tuple[Node, ...]
    left: int
    left_marks: int
    entered: int
    news: Queue
    """What is raised by the transitions and on entry, in order."""
    sent: tuple[str, ...]
    """What is sent by them."""


class Macrosteps:
    """The macrosteps of one graph, with their steps counted."""

    def __init__(self, graph: Graph, can: Possibilities) -> None:
        self.graph = graph
        self.can = can
        self.steps = 0
        self._leaves = _mask(
            node for node in graph.nodes if not node.children and node.index not in can.independent
        )
        self._inside = [
            (1 << node.last + 1) - (1 << node.index) & self._leaves for node in graph.nodes
        ]
        """The leaves of each state."""
        self._ends = _mask(n for n in graph.nodes if n.type == "final" and _ended(n) is graph.root)
        self._with_always = 0
        for node in graph.nodes:
            if node.always:
                self._with_always |= self._inside[node.index]
        self._takeoffs = [
            (self._inside[node.index], can.ended(node))
            for node in graph.nodes
            if node.invocation and node.invocation.behavior.may_take_off
        ]
        self._finishing = [node for node in graph.nodes if self._is_heard_to_finish(node)]
        """The parallel states whose end some transition takes."""
        self._raising = [
            node for node in reversed(graph.nodes) if any(a.event for a in node.exit_actions)
        ]
        """States that raise or send something when they are left, inner ones first."""
        self._histories = {
            node.index: (node, node.parent)
            for node in graph.nodes
            if node.type == "history" and node.parent is not None
        }
        sizes = (parent.last - parent.index for _, parent in self._histories.values())
        self._memory_at = dict(zip(self._histories, accumulate(sizes, initial=0), strict=False))
        """For each history state, where its bits begin in the memory."""
        size = can.first_mark[-1] + sum(parent.last for _, parent in self._histories.values())
        self._weight = 1 + size // 1250
        """What a step counts: large masks take their time and memory."""
        self._microstep_cost = (len(self._raising) + len(self._histories)) // SCANNED
        self._posting = [
            (
                -1 if node.index in can.independent else self._inside[node.index],
                can.ended(node),
                marks,
            )
            for node, marks in can.posting()
        ]
        self._posted = sum(can.posted.values())
        self._fixed: dict[tuple[Edge, ...], _Effect] = {}
        self._recalling: dict[tuple[tuple[Edge, ...], int, int], _Effect] = {}
        """The effects that depend on the memory."""

    def spend(self, steps: int = 1) -> None:
        """Count steps. Raises TooManyError."""
        self.steps += steps * self._weight
        if self.steps > MAX_STEPS:
            raise TooManyError

    # -- what may happen ----------------------------------------------------------------------

    def start(self) -> list[Result]:
        """The situations in which the mission may come to rest first."""
        root = self.graph.root
        entered = (root, *entry_set(root, default_entry(root), lambda history: None).states)
        leaves = _mask(entered) & self._leaves
        queue = self._with_ends(_news(entered), leaves, 0)
        marks = self._send(0, (a.event for node in entered for a in _of_kind("send", node.entry)))
        return self._settle([_Micro(leaves, marks, 0, queue, 0, None)])

    def always(self, at: Situation) -> list[Result]:
        """What ``always`` transitions may do when they are tested again."""
        return self._settle([self._begin(at)]) if at.leaves & self._with_always else []

    def event(self, at: Situation, word: str) -> list[Result]:
        """What an event may do that some transition takes; nothing where none does."""
        offers = [self.can.offered(leaf, word) for leaf in bits(at.leaves)]
        return self._taken(self._begin(at), offers, {})

    def ending(self, at: Situation, ending: Ending) -> list[Result]:
        """What the outcome of a behaviour may do."""
        begun = self._begin(at)
        marks, queue = begun.marks | ending.marks, begun.queue
        if ending.word == "done":
            queue = tuple(self._ends_with(ending.node, at.leaves, marks))
        relieved = ending.unless | (LANDED if ending.lands else 0)
        micro = begun._replace(marks=marks, queue=queue, relieved=relieved)
        return self._settle(self._hear(micro, Heard(ending.word, ending.node)))

    def own_events(self, at: Situation) -> Iterator[Result]:
        """What the events may do that were sent, or posted by active states."""
        for word, mark in self.can.posted.items():
            if at.marks & mark:
                yield from self._settle(self._hear(_Micro(*at, (), 0, None), Heard(word)))
        for word, mark in self.can.sent.items():
            if at.marks & mark:
                # Where there may be two, one may still be on its way.
                gone = 0 if at.marks & mark << 1 else mark
                micro = _Micro(at.leaves, at.marks & ~gone, at.memory, (), gone, None)
                yield from self._settle(self._hear(micro, Heard(word)))

    def finishing(self, at: Situation) -> Iterator[Result]:
        """What the ``done`` of a parallel state may do although its regions go on.

        Those that end in one period are heard one after the other, when all have ended.
        """
        for parallel in self._finishing:
            active = at.leaves & self._inside[parallel.index]
            if not active or self._is_finished(parallel, at.leaves, at.marks):
                continue
            if self._is_finished(parallel, at.leaves, at.marks, perhaps=True):
                begun = self._hear(self._begin(at), Heard("done", parallel.owner))
                yield from self._settle(begun)

    def together(
        self, at: Situation, offers: Sequence[Sequence[Option]], marks: Mapping[Edge, int]
    ) -> list[Result]:
        """What due timers and conditions may do that are taken together.

        ``offers`` are those of each leaf; ``marks`` are added with the transitions taken.
        """
        return self._taken(self._begin(at), offers, marks)

    # -- macrosteps ---------------------------------------------------------------------------

    def _begin(self, at: Situation) -> _Micro:
        """The begin of a macrostep that is not an event posted before. It may come first in a
        period, so that what active states post is heard after it, but not what was before.
        """
        marks = at.marks & ~self._posted | self._posts(at.leaves, at.marks)
        return _Micro(at.leaves, marks, at.memory, (), 0, None)

    def _taken(
        self, micro: _Micro, offers: Sequence[Sequence[Option]], marks: Mapping[Edge, int]
    ) -> list[Result]:
        """What the transitions on offer may do, where at least one is taken."""
        found = []
        for edges in self._selections(offers, micro.memory):
            added = 0
            for edge in edges:
                added |= marks.get(edge, 0)
            if edges:
                begun = micro._replace(marks=micro.marks | added, relieved=added)
                found.append(self._microstep(begun, edges))
        return self._settle(found)

    def _settle(self, begun: Iterable[_Micro | None]) -> list[Result]:
        """Where these may come to rest; the host lands where one is None."""
        results: dict[Result, None] = {}
        pending: list[_Micro] = []
        for micro in begun:
            if micro is None:
                results[Result(None, 0, None)] = None
            else:
                pending.append(micro)
        seen = set(pending)
        while pending:
            micro = pending.pop()
            self.spend()
            if len(micro.queue) > MAX_WAITING:
                raise UnknownError(f"what follows when over {MAX_WAITING} raised events wait")
            for after in self._following(micro):
                if after is None or isinstance(after, Situation):
                    results[Result(after, micro.relieved, micro.edge)] = None
                elif after not in seen:
                    seen.add(after)
                    pending.append(after)
                elif "error.livelock" in self.can.words.taken:
                    raise UnknownError("what `error.livelock` leads to")
        return list(results)

    def _following(self, micro: _Micro) -> Iterator[_Micro | Situation | None]:
        """The microsteps that may follow; where it rests; None where the host lands."""
        if micro.leaves & self._ends:
            yield None
            return
        if micro.leaves & self._with_always:
            refused = False
            offers = [self.can.always(leaf) for leaf in bits(micro.leaves)]
            for edges in self._selections(offers, micro.memory):
                if edges:
                    yield self._microstep(micro, edges)
                refused |= not edges
            if not refused:
                return
        if micro.queue:
            yield from self._hear(micro._replace(queue=micro.queue[1:]), micro.queue[0])
        else:
            yield self._rest(micro.leaves, micro.marks, micro.memory)

    def _rest(self, leaves: int, marks: int, memory: int) -> Situation:
        if marks & LANDED and any(
            leaves & inside and not marks & ended for inside, ended in self._takeoffs
        ):
            marks &= ~LANDED
        return Situation(leaves, marks | self._posts(leaves, marks), memory)

    def _posts(self, leaves: int, marks: int) -> int:
        """The marks of what the active states may post."""
        found = 0
        for inside, ended, posted in self._posting:
            if leaves & inside and not marks & ended:
                found |= posted
        return found

    def _hear(self, micro: _Micro, heard: Heard) -> Iterator[_Micro | None]:
        """What may follow when the first that waits is heard."""
        if heard.owner is not None:
            offers: Sequence[Sequence[Option]] = [self.can.outcome(heard.owner, heard.word)]
        else:
            offers = [self.can.offered(leaf, heard.word) for leaf in bits(micro.leaves)]
        for edges in self._selections(offers, micro.memory):
            if edges:
                yield self._microstep(micro, edges)
            else:
                yield None if self._is_for_host(heard) else micro

    def _is_for_host(self, heard: Heard) -> bool:
        """Whether the host lands when nothing takes this, or the mission ends with it."""
        vocabulary = self.graph.vocabulary
        if heard.owner is self.graph.root:
            return True
        if heard.word == "failed" or vocabulary.is_urgent(heard.word):
            return vocabulary.reaction(heard.word) == "land"
        return False

    def _selections(
        self, offers: Sequence[Sequence[Option]], memory: int
    ) -> dict[tuple[Edge, ...], None]:
        """The sets of transitions that may be taken together, one on offer for each leaf."""
        outer_first, recorded = self.graph.outer_first, self._recorded(memory)

        def in_conflict(a: Edge, b: Edge) -> bool:
            return exit_sets_meet(a, b, recorded)

        found: dict[tuple[Edge, ...], None] = {}
        for picked in product(*offers):
            self.spend(1 + len(offers) // SCANNED)
            edges = tuple(dict.fromkeys(edge for edge in picked if edge is not None))
            if len(edges) > 1:
                if len({edge.node.index for edge in edges}) < len(edges):
                    continue  # A state takes only one at a time.
                self.spend(len(edges) ** 2 // SCANNED)
                edges = tuple(without_conflicts(edges, in_conflict, outer_first))
            found[edges] = None
        return found

    # -- microsteps ---------------------------------------------------------------------------

    def _microstep(self, micro: _Micro, edges: tuple[Edge, ...]) -> _Micro:
        self.spend(self._microstep_cost)
        effect, memory = self._fixed.get(edges), micro.memory
        if self._histories:
            domains = effect.domains if effect else self._domains(edges, memory)
            memory = self._remember(micro, domains)
            effect = effect or self._recalling.get((edges, micro.memory, memory))
        effect = effect or self._new_effect(edges, micro.memory, memory)
        leaves = micro.leaves & ~effect.left | effect.entered
        marks = micro.marks & ~effect.left_marks
        queue = micro.queue
        if queue:
            queue = tuple(heard for heard in queue if not _is_inside(heard.owner, effect.domains))
        for node in self._raising:
            if micro.leaves & self._inside[node.index] and _is_inside(node, effect.domains):
                queue += tuple(Heard(a.event) for a in _of_kind("raise", node.exit_actions))
                marks = self._send(marks, (a.event for a in _of_kind("send", node.exit_actions)))
        if effect.news:
            queue += self._with_ends(effect.news, leaves, marks)
        if effect.sent:
            marks = self._send(marks, effect.sent)
        relieved = micro.relieved | effect.left_marks
        return _Micro(leaves, marks, memory, queue, relieved, micro.edge or edges[0])

    def _domains(self, edges: Iterable[Edge], memory: int) -> tuple[Node, ...]:
        """The states whose inside transitions leave."""
        recorded = self._recorded(memory)
        domains = (transition_domain(edge, recorded) for edge in edges)
        return tuple(domain for domain in domains if domain is not None)

    def _new_effect(self, edges: tuple[Edge, ...], before: int, memory: int) -> _Effect:
        """What transitions change; ``before`` is the memory before they leave what they leave."""
        asked = [edge for edge in edges if edge.by_history]
        look_up = self._recorded(memory)

        def recorded(history: Node) -> tuple[Node, ...] | None:
            asked.append(edges[0])
            return look_up(history)

        domains = self._domains(edges, before)
        entering: dict[int, Node] = {}
        targeted = (edge for edge in edges if edge.targets)
        for edge, domain in zip(targeted, domains, strict=True):
            entering |= entry_set(domain, edge.targets, recorded).entering
        left, left_marks = 0, 0
        for domain in domains:
            left |= self._inside[domain.index]
            left_marks |= self.can.marks_inside(domain)
        self.spend(len(entering))
        nodes = [entering[index] for index in sorted(entering)]
        taking = [action for edge in edges for action in edge.actions]
        news = (*(Heard(a.event) for a in _of_kind("raise", taking)), *_news(nodes))
        sending = _of_kind("send", (*taking, *(a for node in nodes for a in node.entry)))
        sent = tuple(action.event for action in sending)
        effect = _Effect(domains, left, left_marks, _mask(nodes) & self._leaves, news, sent)
        if asked:
            self._recalling[edges, before, memory] = effect
        else:
            self._fixed[edges] = effect
        return effect

    def _send(self, marks: int, words: Iterable[str]) -> int:
        """The marks when these events have been sent."""
        for word in words:
            mark = self.can.sent[word]
            marks |= mark << 1 if marks & mark else mark
        return marks

    # -- the ends of states -------------------------------------------------------------------

    def _with_ends(self, news: Iterable[Heard], leaves: int, marks: int) -> Queue:
        """What is raised, each outcome of a state followed by the ends of those around it."""
        found: list[Heard] = []
        for heard in news:
            found.append(heard)
            if heard.owner is not None:
                found += [
                    end for end in self._ends_with(heard.owner, leaves, marks) if end not in found
                ]
        return tuple(found)

    def _ends_with(self, region: Node, leaves: int, marks: int) -> Iterator[Heard]:
        """The ends of the parallel states whose last region has finished with this one."""
        parallel = region.parent
        if parallel is None or parallel.type != "parallel":
            return
        if self._is_finished(parallel, leaves, marks):
            yield Heard("done", parallel.owner)
            yield from self._ends_with(parallel.owner, leaves, marks)

    def _is_finished(self, node: Node, leaves: int, marks: int, *, perhaps: bool = False) -> bool:
        """Whether a parallel state or a region has finished.

        ``perhaps``: or may have done so within this period, although its end leads it on.
        """
        if node.type == "parallel":
            self.spend(len(node.children) // SCANNED)
            return all(
                (perhaps and self._goes_on(region))
                or self._is_finished(region, leaves, marks, perhaps=perhaps)
                for region in default_entry(node)
                if region.index not in self.can.independent
            )
        if not node.children:
            return bool(marks & self.can.done(node))
        if node.children[0].border:
            return self._is_finished(node.children[0], leaves, marks, perhaps=perhaps)
        return any(c.type == "final" and leaves & c.mask for c in node.children)

    def _goes_on(self, region: Node) -> bool:
        """Whether a transition leads on from the end of a region."""
        inner = region
        while inner.children and inner.children[0].border:
            inner = inner.children[0]
        words = {child.outcome for child in inner.children if child.type == "final"}
        if inner.type == "parallel":
            words = {"done"}
        elif not inner.children and inner.invocation:
            words = {"done"} & inner.invocation.behavior.outcomes.keys()
        taken = (edge for word in words for edge in self.can.outcome(region, word))
        return any(edge is not None and edge.targets for edge in taken)

    def _is_heard_to_finish(self, node: Node) -> bool:
        if node.type != "parallel" or node.index in self.can.independent:
            return False
        return self.can.outcome(node.owner, "done") != (None,)

    # -- history ------------------------------------------------------------------------------

    def _remember(self, micro: _Micro, domains: Sequence[Node]) -> int:
        """The memory with what was active in the states that are left."""
        memory = micro.memory
        for history, parent in self._histories.values():
            inside = micro.leaves & self._inside[parent.index]
            if not inside or not _is_inside(parent, domains):
                continue
            if not history.deep:
                inside = _mask(c for c in parent.children if inside & self._inside[c.index])
            size, begin = parent.last - parent.index, self._memory_at[history.index]
            memory &= ~((1 << size) - 1 << begin)
            memory |= inside >> parent.index + 1 << begin
        return memory

    def _recorded(self, memory: int) -> Recorded:
        """What tells the states that a history state stands for, None when it remembers none."""

        def recorded(history: Node) -> tuple[Node, ...] | None:
            _, parent = self._histories[history.index]
            size, first = parent.last - parent.index, parent.index + 1
            inside = memory >> self._memory_at[history.index] & (1 << size) - 1
            return tuple(self.graph.nodes[first + bit] for bit in bits(inside)) or None

        return recorded


def bits(mask: int) -> Iterator[int]:
    """The numbers of the bits that are set, the lowest first."""
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest


def _mask(nodes: Iterable[Node]) -> int:
    found = 0
    for node in nodes:
        found |= node.mask
    return found


def _is_inside(node: Node | None, domains: Iterable[Node]) -> bool:
    return node is not None and any(domain.contains(node) for domain in domains)


def _ended(final: Node) -> Node:
    """The state that a final state ends."""
    assert final.parent is not None
    return final.parent.owner


def _news(entered: Iterable[Node]) -> Iterator[Heard]:
    """What entering states raises, and the outcomes that final ones give."""
    for node in entered:
        yield from (Heard(a.event) for a in _of_kind("raise", node.entry))
        if node.type == "final":
            yield Heard(node.outcome, _ended(node))


def _of_kind(kind: str, actions: Iterable[Action]) -> Iterator[Action]:
    """The actions that raise, or send, an event of this mission."""
    return (action for action in actions if action.event and action.kind == kind)
