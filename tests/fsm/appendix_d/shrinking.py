"""Makes a chart in which something differs as small as it gets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tests.fsm.appendix_d.charts import Action, State, Transition
from tests.fsm.appendix_d.comparison import difference
from vencejo.errors import UserError


def shrink(root: State, events: list[str], mission: bool) -> None:
    """Take away events, transitions, content and states as long as something still differs."""
    while any(_try_without(root, events, mission, part) for part in [events, *_parts(root)]):
        pass


def _try_without(root: State, events: list[str], mission: bool, part: list[Any]) -> bool:
    """Take away what is not needed of one list; whether that was anything."""
    taken = False
    for item in part[::-1]:
        if isinstance(item, State) and not _is_spare(item, root):
            continue
        place = part.index(item)
        del part[place]
        if _differs(root, events, mission):
            taken = True
        else:
            part.insert(place, item)
    return taken


def _differs(root: State, events: list[str], mission: bool) -> bool:
    try:
        return bool(difference(root, events, mission))
    except UserError:
        return False  # The checker refuses what is left.


def _parts(root: State) -> Iterator[list[Any]]:
    for state in [*root.walk()]:
        yield from (state.children, state.transitions)
        yield from _contents(state)


def _contents(state: State) -> Iterator[list[Action]]:
    yield from (state.onentry, state.onexit)
    yield from (transition.actions for transition in _transitions(state))


def _transitions(state: State) -> list[Transition]:
    return [*state.transitions, *([state.default] if state.default else [])]


def _is_spare(state: State, root: State) -> bool:
    """Whether the chart stays one without this state."""
    assert state.parent is not None
    inside = [*state.walk()]
    others = [other for other in root.walk() if other not in inside]
    named = {target for o in others for t in _transitions(o) for target in t.targets}
    named |= {t.condition[1] for o in others for t in _transitions(o) if t.condition}
    named |= {s for o in others for part in _contents(o) for _, _, asked in part for s in asked}
    remaining = [c for c in state.parent.children if c is not state and not c.is_history]
    return bool(remaining) and not any(each in named for each in inside)
