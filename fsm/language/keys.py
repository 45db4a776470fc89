"""The words of the mission language: which keys may stand where, and what names look like."""

from __future__ import annotations

import re
from typing import get_args

from fsm.language.spec import ActionKind

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
        "graphs",
    ]
)
GRAPH_KEYS = frozenset({"description", "places", "parameters", "events"})
"""What a graph kept under `graphs` has, besides the keys of a state."""
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
        "include",
        "on",
        "when",
        "after",
        "always",
        "description",
        "breakpoint",
    ]
)
FINAL_KEYS = frozenset({"type", "outcome", "output", "entry", "description", "breakpoint"})
HISTORY_KEYS = frozenset({"type", "deep", "target", "description"})
NOT_YET = frozenset({"filters"})
"""Words of the language that this version does not fly yet."""
TRANSITION_KEYS = frozenset({"target", "guard", "actions", "for", "reenter", "name", "description"})
ACTIONS = frozenset(get_args(ActionKind))

SMALL_NAME = re.compile(r"[a-z][a-z0-9_]*")
"""Of states, outcomes and vehicles."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
"""Of parameters, data and whatever else an expression can name."""
MISSION_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
EVENT_NAME = re.compile(r"[a-z][a-z0-9_]*(\.[a-z0-9_]+)+")
TRIGGER = re.compile(r"\*|[a-z][a-z0-9_]*(\.[a-z0-9_]+)*(\.\*)?")
"""What may stand under `on`: an outcome, an event, all of a family, or all."""
