"""Explores the situations that a graph can come into: an explicit-state model checker.

The safety proof (:mod:`fsm.checks.safety`) uses it. The vehicle may stay in the air for ever where
it comes to rest there, or where a *loop* can go on for ever: a set of situations that lead to each
other, in none of which it has landed. A loop is *fair* when nothing that is sure to happen is left
out for ever (weak fairness): whatever is due in all of its situations happens in it, or has its
state left or entered anew there.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeVar

from fsm.chart.graph import Edge, Graph
from fsm.checks.macrosteps import Macrosteps, Result, Situation, bits
from fsm.checks.possibilities import LANDED, Chances, Option, Possibilities

T = TypeVar("T")
FAILED = "error.execution"
"""What a mission hears when an expression or action of its own fails, which may be at any time."""
NAMED = 4
"""Active states of a situation that its name gives."""


class Move(NamedTuple):
    """One situation following another."""

    to: int
    """The number of the situation that follows."""
    relieved: int
    """What was due and has happened, or has been ended or begun anew."""
    edge: Edge | None


Moves = Mapping[int, Sequence[Move]]
"""The moves from each of some situations."""


class Answer(NamedTuple):
    """What follows when an event that must land has been handled in a situation."""

    event: str
    edge: Edge
    before: int
    after: int


class Explorer:
    """The situations of a graph, numbered as they were found, and the moves between them."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.can = Possibilities(graph)
        self.macrosteps = Macrosteps(graph, self.can)
        self.situations: list[Situation] = []
        self.moves: list[tuple[Move, ...]] = []
        """The moves from each situation without an event from outside."""
        self.came_from: list[int | None] = []
        """The situation from which each was found first; None for an initial one."""
        self.answers: list[Answer] = []
        self._numbers: dict[Situation, int] = {}
        self._must_land = frozenset(graph.vocabulary.must_land)
        self._at_once = self.can.raises and any(node.type == "parallel" for node in graph.nodes)
        """Whether it can matter that transitions of several regions are taken together: what they
        raise is heard when all of them have been taken.
        """

    def name(self, number: int) -> str:
        """The active leaf states of a situation."""
        paths = [self.graph.nodes[leaf].path for leaf in bits(self.situations[number].leaves)]
        more = f" and {len(paths) - NAMED} more" if len(paths) > NAMED else ""
        return " + ".join(paths[:NAMED]) + more

    def unseen(self) -> str:
        """The first situation that was found but not looked at."""
        number = len(self.moves)
        return self.name(number) if number < len(self.situations) else "its start"

    # -- which situations there are -----------------------------------------------------------

    def explore(self) -> None:
        """Find all situations that can be reached. Raises TooManyError, UnknownError."""
        for result in self.macrosteps.start():
            self._number(result.situation, None)
        for number, at in enumerate(self.situations):  # It grows meanwhile.
            self.moves.append(tuple(self._moves(number, at)))
            answered = set()
            chances = [self.can.chances(leaf) for leaf in bits(at.leaves)]
            self.macrosteps.spend(len(chances))
            for word in _unique(here.events for here in chances):
                for result in self.macrosteps.event(at, word):
                    after = self._number(result.situation, number)
                    if word not in self._must_land or after is None or result.edge is None:
                        continue
                    answer = Answer(word, result.edge, number, after)
                    if answer not in answered:
                        answered.add(answer)
                        self.answers.append(answer)

    def _number(self, situation: Situation | None, before: int | None) -> int | None:
        """The number of a situation; None where the host lands."""
        if situation is None:
            return None
        number = self._numbers.get(situation)
        if number is None:
            number = self._numbers[situation] = len(self.situations)
            self.situations.append(situation)
            self.came_from.append(before)
        return number

    def _moves(self, number: int, at: Situation) -> Iterator[Move]:
        """The moves by outcomes, timers, conditions and what the mission itself brings about."""
        found: dict[Move, None] = {}
        for result in self._results(at):
            to = self._number(result.situation, number)
            if to is not None:
                found[Move(to, result.relieved, result.edge)] = None
        yield from found

    def _results(self, at: Situation) -> Iterator[Result]:
        """Everything that can happen without an event from outside."""
        steps = self.macrosteps
        chances = [self.can.chances(leaf) for leaf in bits(at.leaves)]
        for ending in _unique(here.endings for here in chances):
            if not at.marks & ending.unless:
                yield from steps.ending(at, ending)
        yield from self._rounds(at, chances)
        yield from steps.always(at)
        yield from steps.finishing(at)
        yield from steps.own_events(at)
        if FAILED in self.can.words.taken:
            yield from steps.event(at, FAILED)

    def _rounds(self, at: Situation, chances: Sequence[Chances]) -> Iterator[Result]:
        """What timers and conditions can do."""
        marks: dict[Edge, int] = {}
        for timer in _unique(here.timers for here in chances):
            if at.marks & timer.mark or timer.behind & ~at.marks:
                continue
            marks.update((edge, timer.mark) for edge in timer.options if edge is not None)
            if None in timer.options:
                yield Result(at._replace(marks=at.marks | timer.mark), timer.mark, None)
        offers: list[list[Option]] = [
            [None, *here.conditions, *(e for t in here.timers for e in t.options if e in marks)]
            for here in chances
        ]
        if self._at_once:
            yield from self.macrosteps.together(at, offers, marks)
        else:
            for edge in _unique(offers):
                if edge is not None:
                    yield from self.macrosteps.together(at, [[edge]], marks)

    # -- staying in the air -------------------------------------------------------------------

    def breaks_off(self, number: int, move: Move) -> bool:
        """Whether a move ends a landing without the vehicle having landed."""
        if move.relieved & LANDED:
            return False
        at, landing = self.situations[number], 0
        for leaf in bits(at.leaves):
            for ending in self.can.chances(leaf).endings:
                landing |= ending.unless if ending.lands else 0
        return bool(move.relieved & landing & ~at.marks)

    def due(self, number: int) -> int:
        """What is sure to happen in a situation, unless its state is left."""
        at, due = self.situations[number], 0
        for leaf in bits(at.leaves):
            due |= self.can.chances(leaf).due
        due &= ~at.marks
        for mark in self.can.sent.values() if not self.can.cancels else ():
            due |= mark if at.marks & mark and not at.marks & mark << 1 else 0
        return due

    def reachable(self, starts: Iterable[int]) -> list[int]:
        """The situations that follow these without an event from outside, these included."""
        found = dict.fromkeys(starts)
        pending = list(found)
        for number in pending:  # It grows meanwhile.
            for move in self.moves[number]:
                if move.to not in found:
                    found[move.to] = None
                    pending.append(move.to)
        return pending

    def fair_loops(self, moves: Moves) -> list[frozenset[int]]:
        """The loops by these moves in which the vehicle may stay in the air for ever; a situation
        in which it comes to rest is one by itself.
        """
        inside = {
            number: [move for move in each if not move.relieved & LANDED]
            for number, each in moves.items()
            if not self.situations[number].marks & LANDED
        }

        def following(number: int) -> Iterator[int]:
            return (move.to for move in inside[number] if move.to in inside)

        def is_fair(loop: frozenset[int]) -> bool:
            left_out = -1
            for number in loop:
                left_out &= self.due(number)
                for move in inside[number]:
                    if move.to in loop:
                        left_out &= ~move.relieved
            return not left_out

        return [loop for loop in components(inside, following) if is_fair(loop)]


def ways(goals: Collection[int], moves: Moves) -> dict[int, Move]:
    """For each situation from which a goal can be reached, the first move of a shortest way there;
    none for the goals themselves.
    """
    back: dict[int, list[tuple[int, Move]]] = {}
    for number, each in moves.items():
        for move in each:
            back.setdefault(move.to, []).append((number, move))
    found: dict[int, Move] = {}
    pending = deque(goals)
    goals = set(goals)
    while pending:
        for number, move in back.get(pending.popleft(), ()):
            if number not in found and number not in goals:
                found[number] = move
                pending.append(number)
    return found


def components(
    numbers: Iterable[int], following: Callable[[int], Iterator[int]]
) -> Iterator[frozenset[int]]:
    """Strongly connected components, by Tarjan's algorithm (1972) without recursion."""
    order: dict[int, int] = {}
    low: dict[int, int] = {}
    open_: dict[int, None] = {}
    for start in numbers:
        if start in order:
            continue
        work = [(start, following(start))]
        order[start] = low[start] = len(order)
        open_[start] = None
        while work:
            number, left = work[-1]
            for after in left:
                if after not in order:
                    order[after] = low[after] = len(order)
                    open_[after] = None
                    work.append((after, following(after)))
                    break
                if after in open_:
                    low[number] = min(low[number], order[after])
            else:
                work.pop()
                if work:
                    outer = work[-1][0]
                    low[outer] = min(low[outer], low[number])
                if low[number] == order[number]:
                    yield _popped(open_, number)


def _popped(open_: dict[int, None], root: int) -> frozenset[int]:
    """Take a component off Tarjan's stack, down to its root."""
    component = set()
    while root not in component:
        component.add(open_.popitem()[0])
    return frozenset(component)


def _unique(parts: Iterable[Iterable[T]]) -> Iterable[T]:
    return dict.fromkeys(each for part in parts for each in part)
