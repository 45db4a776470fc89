"""The safety proof: whatever happens, after an event that must end on the ground the mission lands.

The claim. Each event of ``Vocabulary.must_land`` is offered in every situation that the mission can
come into. Where no transition takes it, the host lands. Where one does, no further event from
outside is counted on, and outcomes, timers, conditions and ``error.execution`` come in any order;
yet the mission ends, where the host lands, or a behaviour that ends on the ground ends in ``done``,
and no take-off makes that undone for ever. A landing that is left, or fails, has landed nothing.

Guards and conditions may be true or false at any time, constants apart. What is sure to happen is
not put off for ever (weak fairness): a behaviour that can end does end, and a timer goes off,
unless their state is left or entered anew. The search is bounded by its steps
(:data:`fsm.checks.macrosteps.MAX_STEPS`); what it did not look at is not proven.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from fsm.chart.graph import Edge, Graph
from fsm.checks import macrosteps
from fsm.checks.exploration import Answer, Explorer, Move, Moves, ways
from fsm.checks.macrosteps import TooManyError, UnknownError
from vencejo.errors import Fault

Step = tuple[int, Move]
"""A situation, and a move from it."""
SHOWN = 10
"""The most combinations of states that a path in a message names."""


def prove(graph: Graph) -> list[Fault]:
    """Warnings where the proof fails; none when it holds.

    ``never-lands`` and ``left-landing`` show how the vehicle may stay in the air, ``not-proven``
    says what was not looked at.
    """
    if not graph.vocabulary.must_land:
        return []
    behaviors = (node.invocation.behavior for node in graph.nodes if node.invocation)
    trusted = sorted({behavior.name for behavior in behaviors if behavior.on_trust})
    if trusted:
        return [_not_proven(graph, f"its own behaviours ({', '.join(trusted)}) were not looked at")]
    explorer = Explorer(graph)
    try:
        explorer.explore()
    except TooManyError:
        reason = f"after {macrosteps.MAX_STEPS:,} steps not everything had been looked at"
        return [_not_proven(graph, f"{reason}, such as what follows from {explorer.unseen()}")]
    except UnknownError as error:
        return [_not_proven(graph, f"{error} was not looked at")]
    return list(_violations(explorer))


def _not_proven(graph: Graph, reason: str) -> Fault:
    return Fault(
        "not-proven",
        f"it is not proven that this mission always lands: {reason}",
        graph.root.where,
        f"test it with {', '.join(graph.vocabulary.must_land)} in flight",
        "warning",
    )


def warnings_with_proof(graph: Graph) -> tuple[Fault, ...]:
    """All warnings about a graph, those of the proof included; a transition that can break off a
    landing is told of once.
    """
    proof = prove(graph)
    told = {fault.where for fault in proof if fault.code == "left-landing"}
    known = [f for f in graph.warnings if f.code != "left-landing" or f.where not in told]
    return (*known, *proof)


class _Staying:
    """The situations from which the vehicle may stay in the air for ever, by some moves."""

    def __init__(self, explorer: Explorer, moves: Moves) -> None:
        self.moves = moves
        self._loop_of: dict[int, frozenset[int]] = {}
        for loop in explorer.fair_loops(moves):
            self._loop_of.update(dict.fromkeys(loop, loop))
        self._ways = ways(self._loop_of, moves)

    def __contains__(self, number: int) -> bool:
        return number in self._loop_of or number in self._ways

    def way_from(self, number: int) -> tuple[list[Step], list[Step]]:
        """A way into a loop, and once around it."""
        way: list[Step] = []
        while number not in self._loop_of:
            way.append((number, self._ways[number]))
            number = way[-1][1].to
        return way, self._round(number)

    def _round(self, start: int) -> list[Step]:
        inside = {number: self.moves[number] for number in self._loop_of[start]}
        back = ways([start], inside)
        others = [move for move in inside[start] if move.to in back]
        again = [move for move in inside[start] if move.to == start and move.relieved]
        move = next(iter(others or again), None)
        found: list[Step] = []
        number = start
        while move is not None:
            found.append((number, move))
            number = move.to
            move = back.get(number)
        return found


def _violations(explorer: Explorer) -> Iterator[Fault]:
    after = explorer.reachable(answer.after for answer in explorer.answers)
    moves = {number: explorer.moves[number] for number in after}
    stays = _Staying(explorer, moves)
    landing = {
        number: [move for move in each if not explorer.breaks_off(number, move)]
        for number, each in moves.items()
    }
    stays_unbroken = _Staying(explorer, landing)
    told: set[object] = set()
    for answer in explorer.answers:
        if answer.after in stays_unbroken:
            if (answer.event, answer.edge) not in told:
                told.add((answer.event, answer.edge))
                yield _never_lands(explorer, answer, stays_unbroken)
        elif answer.after in stays:
            edge = _leaving(explorer, stays, answer)
            if edge.where not in told:
                told.add(edge.where)
                yield _left_landing(explorer, answer, stays, edge)


def _never_lands(explorer: Explorer, answer: Answer, staying: _Staying) -> Fault:
    return Fault(
        "never-lands",
        f"'{answer.event}' may leave the vehicle in the air for ever: "
        f"{_story(explorer, answer, staying)}",
        answer.edge.where,
        "lead it to a state that lands, give the last state `after`, or leave the event to the "
        "host, which lands",
        "warning",
    )


def _left_landing(explorer: Explorer, answer: Answer, staying: _Staying, edge: Edge) -> Fault:
    trigger = edge.kind if edge.kind == "always" else f"{edge.kind} {edge.trigger}"
    return Fault(
        "left-landing",
        f"`{trigger}` can break off a landing and leave the vehicle in the air for ever: "
        f"{_story(explorer, answer, staying)}",
        edge.where,
        "lead it to a state that lands, or leave the failure of a landing to the host, which "
        "tries again",
        "warning",
    )


def _leaving(explorer: Explorer, staying: _Staying, answer: Answer) -> Edge:
    """The transition that leaves a landing on the way into a loop, or around it."""
    way, around = staying.way_from(answer.after)
    left = (move.edge for at, move in (*way, *around) if explorer.breaks_off(at, move))
    return next((edge for edge in left if edge is not None), answer.edge)


def _story(explorer: Explorer, answer: Answer, staying: _Staying) -> str:
    """How the mission comes to an event, and what may follow it."""
    before: list[int] = []
    number: int | None = answer.before
    while number is not None:
        before.insert(0, number)
        number = explorer.came_from[number]
    way, around = staying.way_from(answer.after)
    after = [answer.after, *(move.to for _, move in way)]
    loop = [move.to for _, move in around]
    told = f"{_path(explorer, before)}, then '{answer.event}' → "
    if len({explorer.name(number) for number in loop}) > 1:
        return f"{told}{_path(explorer, after + loop)}, and so on"
    if len(loop) == 1:
        return f"{told}{_path(explorer, after)} → {_path(explorer, loop)}, and so on"
    return f"{told}{_path(explorer, after)}, where it stays"


def _path(explorer: Explorer, numbers: list[int]) -> str:
    """Situations with arrows between them, those of one name in a row once, the middle left out."""
    names = [name for name, _ in groupby(map(explorer.name, numbers))]
    if len(names) > SHOWN:
        names = [*names[:2], "…", *names[2 - SHOWN :]]
    return " → ".join(names)
