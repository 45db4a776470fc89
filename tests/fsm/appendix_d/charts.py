"""Statecharts as plain data: what the interpreter of appendix D runs and the writers write."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

Action = tuple[str, str, tuple["State", ...]]
"""``("raise", event, ())``, or ``("log", text, states)``: it tells which of these are active."""


@dataclass(eq=False)
class Transition:
    source: State
    events: str
    """Event descriptors; empty for none."""
    targets: list[State] = field(default_factory=list)
    condition: tuple[bool, State] | None = None
    """Passes when ``In(state)`` has this value; None always passes."""
    internal: bool = False
    actions: list[Action] = field(default_factory=list)


@dataclass(eq=False)
class State:
    id: str
    kind: str
    """``atomic``, ``compound``, ``parallel``, ``final``, ``shallow`` or ``deep`` (history)."""
    parent: State | None
    children: list[State] = field(default_factory=list)
    """History states and others, in document order."""
    default: Transition | None = None
    """The initial transition of a compound state, the default transition of a history state."""
    transitions: list[Transition] = field(default_factory=list)
    onentry: list[Action] = field(default_factory=list)
    onexit: list[Action] = field(default_factory=list)

    @property
    def is_history(self) -> bool:
        return self.kind in ("shallow", "deep")

    def __post_init__(self) -> None:
        self.ancestors: tuple[State, ...] = ()
        """From the parent outwards."""
        if self.parent is not None:
            self.ancestors = (self.parent, *self.parent.ancestors)

    def is_inside(self, other: State) -> bool:
        return other in self.ancestors

    def walk(self) -> Iterator[State]:
        """This state and all inside, in document order."""
        yield self
        for child in self.children:
            yield from child.walk()
