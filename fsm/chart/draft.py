"""The draft of a graph: the intermediate form between a language and an immutable graph.

The front ends for YAML and SCXML add the states in document order, resolve targets, and compile the
contents of states and transitions into their drafts. From these :func:`fsm.chart.graph.build_nodes`
makes the states and transitions of a graph. Rules that hold in both languages stand here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from fsm.chart.executable import Action, Data, Given, Invocation
from fsm.chart.nesting import Nested
from fsm.expressions.compiled import Compiled
from fsm.language.reader import MAX_STATE_DEPTH
from fsm.language.spec import StateType, TriggerKind
from vencejo.errors import Where

__all__ = ["MAX_STATE_DEPTH", "Draft", "StateDraft", "TransitionDraft", "compatible"]


@dataclass(slots=True, eq=False, repr=False)
class TransitionDraft:
    """One alternative of a transition."""

    kind: TriggerKind
    trigger: str
    where: Where
    targets: tuple[StateDraft, ...] = ()
    reenter: bool = False
    """True to leave the source even when all targets lie inside it."""
    guard: Compiled | None = None
    hold: Compiled | None = None
    """Duration for which its condition must hold; None for none."""
    actions: tuple[Action, ...] = ()
    name: str = ""


Alternatives = Sequence[TransitionDraft]


@dataclass(slots=True, eq=False, repr=False)
class StateDraft(Nested):
    """One state. Its fields are those of :class:`fsm.chart.graph.Node`, and explained there."""

    name: str
    path: str
    type: StateType
    where: Where
    parent: StateDraft | None
    index: int
    last: int
    depth: int
    """Number of its ancestors."""
    border: bool = False
    description: str = ""
    children: list[StateDraft] = field(default_factory=list)
    initial: tuple[StateDraft, ...] = ()
    deep: bool = False
    given: tuple[Given, ...] = ()
    data: tuple[Data, ...] = ()
    entry: tuple[Action, ...] = ()
    default_actions: tuple[Action, ...] = ()
    exit_actions: tuple[Action, ...] = ()
    throughout: tuple[Action, ...] = ()
    invocation: Invocation | None = None
    on: Sequence[tuple[str, Alternatives]] = ()
    """Transitions by the pattern that their events match."""
    whens: Sequence[tuple[Compiled, Alternatives]] = ()
    afters: Sequence[tuple[Compiled, Alternatives]] = ()
    always: Alternatives = ()
    outcome: str = "done"
    output: Sequence[tuple[str, Compiled]] = ()


class Draft(list[StateDraft]):
    """The states of a graph that is being read, in document order."""

    def add(
        self, name: str, path: str, type_: StateType, where: Where, parent: StateDraft | None
    ) -> StateDraft:
        """The next state in document order, as the last child of ``parent``."""
        index = len(self)
        depth = parent.depth + 1 if parent else 0
        state = StateDraft(name, path, type_, where, parent, index, index, depth)
        self.append(state)
        if parent is not None:
            parent.children.append(state)
        while parent is not None:
            parent.last = index
            parent = parent.parent
        return state


def compatible(a: StateDraft, b: StateDraft) -> bool:
    """Whether a transition may enter both: they lie in different regions of one parallel state.

    A history state stands for everything inside its parent.
    """
    a, b = _entered(a), _entered(b)
    common = a
    while not common.index <= b.index <= common.last:
        assert common.parent is not None, "the root is around every state"
        common = common.parent
    return common.type == "parallel" and common is not a and common is not b


def _entered(target: StateDraft) -> StateDraft:
    """The state that a target fills: itself, or a history state's parent."""
    return target.parent if target.type == "history" and target.parent else target
