"""The words of the mission language: which keys may stand where."""

from __future__ import annotations

from typing import get_args

from fsm.spec import ActionKind

ROOT_KEYS = frozenset(
    [
        "mission",
        "description",
        "world",
        "language",
        "uses",
        "places",
        "parameters",
        "events",
        "priority",
    ]
)
STATE_KEYS = frozenset(
    [
        "states",
        "initial",
        "type",
        "data",
        "define",
        "entry",
        "exit",
        "throughout",
        "do",
        "with",
        "live",
        "as",
        "on",
        "when",
        "after",
        "always",
        "description",
    ]
)
FINAL_KEYS = frozenset({"type", "outcome", "output", "entry", "description"})
HISTORY_KEYS = frozenset({"type", "deep", "target", "description"})
NOT_YET = frozenset({"include", "graphs", "filters", "breakpoint", "fleet", "vehicles", "until"})
"""Words of the language that this version does not fly yet."""
TRANSITION_KEYS = frozenset({"target", "guard", "actions", "for", "reenter", "name", "description"})
ACTIONS = frozenset(get_args(ActionKind))
