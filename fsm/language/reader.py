"""Reads the YAML values of a mission file into its spec; finds every mistake of form."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from difflib import get_close_matches
from typing import Any, cast

from fsm.faults import Faults
from fsm.language import keys
from fsm.language.keys import Key
from fsm.language.spec import (
    ActionKind,
    ActionSpec,
    DefineSpec,
    MissionSpec,
    Named,
    StateSpec,
    StateType,
    TransitionSpec,
    TriggerKind,
    TriggerSpec,
)
from fsm.language.value_kinds import Reader
from vencejo.errors import Correction, UserError, Where, certain, nearest
from vencejo.nodes import Mapping, Scalar, Sequence, YamlNode, kind

LANGUAGE = 1
FLEET = "not-a-mission"
"""The code of the fault that a file is a fleet."""
MAX_STATE_DEPTH = 64

_EXAMPLES = {
    "states": "states: {takeoff: {do: takeoff}, …}",
    "on": "on: {done: land}",
    "when": "when: {vehicle.battery < 30 %: land}",
    "after": "after: {10 s: land}",
    "with": "with: {altitude: 3 m}",
    "live": "live: {speed: $speed}",
    "parameters": "parameters: {height: 3 m}",
    "data": "data: {count: 0}",
    "define": "define: {high: vehicle.altitude > 9 m}",
    "places": "places: {pad: [1, 2, 0]}",
    "events": "events: {game.over: {}}",
    "graphs": "graphs: {scan: {states: {…}}}",
}
"""A hint for each key whose value is a map."""
_NO_NAMES = ("on", "when", "after", "with", "live")
"""Keys of a state that nobody takes for a state, though a map stands behind them."""
_DEFINE = re.compile(r"([A-Za-z][A-Za-z0-9_]*)\s*(?:\(([^()]*)\))?")


def spec_of(node: Mapping, file: str, name: str, faults: Faults) -> MissionSpec:
    """The mission of a file's YAML; every mistake of form goes to ``faults``.

    Raises UserError when the file is a fleet, or its states are too deep to be read.
    """
    return _Reader(faults).mission(node, file, name)


def _fields(rows: Iterable[Key]) -> tuple[Key, ...]:
    """The keys whose values become fields of a spec as they are."""
    return tuple(key for key in rows if not key.apart)


_MISSION_FIELDS = _fields(keys.TOP_ONLY.values())
_STATE_FIELDS = _fields(key for key in keys.KEYS if key is keys.ANY_STATE.get(key.name))
_TRANSITION_FIELDS = _fields(keys.AT["transition"].values())
_TRIGGERS = tuple(key for key in keys.AT["state"].values() if key.kind.reader == "triggers")
_ROOT_TYPES = ("parallel",)
_ALLOWED = {"final": keys.AT["final"], "history": keys.AT["history"]}
_TYPE, _PRIORITY = keys.ANY_STATE["type"], keys.AT["mission"]["priority"]


_Belongs = Callable[[Scalar, Scalar, YamlNode], bool]
"""Whether a key, with its value, may belong inside the key above it."""


def _is_key_of_state(_: Scalar, key: Scalar, value: YamlNode) -> bool:
    """Whether this is one of the keys of a state, where the names of states stand."""
    is_no_state = not isinstance(value, Mapping) or key.text in _NO_NAMES
    return key.text in keys.AT["state"] and is_no_state


def _is_key_of_transition(_: Scalar, key: Scalar, value: YamlNode) -> bool:
    return key.text in keys.AT["transition"]


def _misspelt(node: Mapping, key: str, allowed: Iterable[str]) -> YamlNode | None:
    """The value of what stands in a map in place of a key; None where nothing does."""
    return next((value for word, value in node if certain(word.text, allowed) == key), None)


def _looks_like_state(value: YamlNode) -> bool:
    return isinstance(value, Mapping) and any(
        key.text in ("do", "on", "states") for key, _ in value
    )


def _blank_missing(key: Scalar, more: str = "") -> str:
    """The hint for a key such as ``done:land``."""
    hint = f"is a blank missing after the colon? {more}".rstrip()
    name, _, value = key.text.partition(":")
    return Correction(key.text, f"{name}: {value}", hint) if key.plain and value else hint


class _Reader:
    """Collects faults while it reads, so that one look shows them all.

    A key that may not stand where it does is refused and read all the same, so that the mistakes
    in its value are shown too.
    """

    def __init__(self, faults: Faults) -> None:
        self.faults = faults
        self.fail = faults.fail
        self.readers: dict[Reader, Callable[[YamlNode, Key], Any]] = {
            "text": self.text,
            "scalar": self.scalar,
            "scalars": self.scalars,
            "boolean": self.boolean,
            "choice": self.choice,
            "name": self.name,
            "outcome": self.outcome,
            "named": self.named,
            "define": self.defines,
            "actions": self.actions,
        }

    def mission(
        self, node: Mapping, file: str, stem: str, inside: Where | None = None
    ) -> MissionSpec:
        """A whole file, or the graph that begins at ``inside`` in one."""
        fleet = node.get("fleet")
        if fleet is not None and inside is None:
            raise UserError(
                FLEET,
                f"'{file}' is a fleet, not a mission",
                fleet.where,
                "`drone-cli run` and `check` take fleets; elsewhere name one of its missions",
            )
        if inside is None:
            node = self.keys(node, keys.AT["mission"], "a mission")
        else:
            node = self.keys(node, keys.AT["graph"], "a graph")
        name = self.value(node, keys.AT["mission"]["mission"])
        language = node.get("language")
        if isinstance(language, Scalar) and language.text != str(LANGUAGE):
            self.fail(
                "unknown-language",
                f"this version reads language {LANGUAGE}, not {language.text}",
                language.where,
            )
        if node.get("states") is None and node.get("include") is None:
            self.fail(
                "no-states",
                f"a {'graph' if inside else 'mission'} needs `states`",
                inside or node.where,
                "see `drone-cli new` for a start",
            )
        priority = self.value(node, _PRIORITY)
        return MissionSpec(
            name=name.text if name else stem,
            file=file,
            root=self.state("", node, inside or node.where, 0),
            **self.fields(node, _MISSION_FIELDS),
            outer_first=priority == "outer",
            node=node,
            graphs=self.graphs(node, file) if inside is None else (),
        )

    def graphs(self, node: Mapping, file: str) -> tuple[MissionSpec, ...]:
        """The graphs that are kept in the file."""
        found = []
        for name, value in self.map(node, "graphs"):
            if not keys.NAME.fullmatch(name.text):
                self.fail("bad-name", f"'{name.text}' is not a name", name.where)
            if isinstance(value, Mapping):
                found.append(self.mission(value, file, name.text, name.where))
            else:
                self.fail("wrong-type", f"a graph is a map, not {kind(value)}", value.where)
        return tuple(found)

    # -- states -----------------------------------------------------------------------------

    def state(self, name: str, node: Mapping, where: Where, depth: int) -> StateSpec:
        """A state with all inside it; the root is the one of depth 0."""
        root = depth == 0
        if depth > MAX_STATE_DEPTH:
            raise UserError("too-deep", f"states nest at most {MAX_STATE_DEPTH} deep", where)
        type_node = node.get("type") or _misspelt(node, "type", keys.AT["state"])
        options = _ROOT_TYPES if root else _TYPE.kind.options
        declared = self.choice(type_node, _TYPE, options) if type_node else None
        if declared is None and isinstance(type_node, Scalar):
            declared = certain(type_node.text, options)
        unclear = type_node is not None and declared is None
        type_ = cast(StateType, declared or self.usual_type(node))
        if not root:
            allowed = _ALLOWED.get(type_, keys.AT["state"])
            node = self.keys(node, allowed, f"a {declared} state" if declared else "a state")
        before = self.faults.errors
        states = self.states(node, depth)
        flawed = type_ != "atomic" and not states and self.faults.errors > before
        if type_ == "parallel" and not states and not flawed:
            self.fail("no-states", "a parallel state needs `states`", where)
        self.refuse_combinations(node)
        before = self.faults.errors
        triggers = self.triggers(node)
        flawed = flawed or unclear or self.faults.errors > before
        target = node.get("target") if type_ == "history" else None
        return StateSpec(
            name=name,
            where=where,
            type=type_,
            triggers=triggers,
            states=states,
            flawed=flawed,
            **self.fields(node, _STATE_FIELDS),
            target=self.scalar(target, keys.AT["history"]["target"]) if target else None,
        )

    def usual_type(self, node: Mapping) -> StateType:
        """The type of a state that does not say it."""
        return "compound" if node.get("states") or node.get("include") else "atomic"

    def refuse_combinations(self, node: Mapping) -> None:
        """Refuse keys that lack the one they belong to, or that exclude each other."""
        for key in ("with", "live", "as"):
            if node.get(key) and not node.get("do") and not node.get("include"):
                self.fail("no-behaviour", f"`{key}` needs a `do`", self.where(node, key))
        for key in ("do", "as", "states", "type"):
            if node.get("include") and node.get(key):
                message = f"`{key}` and `include` do not go together"
                hint = "put the `include` into a state of its own"
                self.fail("misplaced-include", message, self.where(node, key), hint)

    def states(self, node: Mapping, depth: int) -> tuple[StateSpec, ...]:
        """The children of a state of that depth."""
        children = []
        for key, value in self.nested(self.map(node, "states"), _is_key_of_state, "a state"):
            if not keys.SMALL_NAME.fullmatch(key.text):
                self.fail(
                    "bad-name",
                    f"'{key.text}' is no name for a state",
                    key.where,
                    "a small letter, then small letters, digits and _",
                )
            if isinstance(value, Scalar) and value.null:
                value = Mapping([], key.where)
            read = isinstance(value, Mapping)
            if not isinstance(value, Mapping):
                hint = f"{key.text}: {{do: takeoff, on: {{done: …}}}}"
                self.fail("wrong-type", f"a state is a map, not {kind(value)}", value.where, hint)
                value = Mapping([], key.where)
            child = self.state(key.text, value, key.where, depth + 1)
            children.append(child if read else replace(child, flawed=True))
        return tuple(children)

    # -- transitions ------------------------------------------------------------------------

    def triggers(self, node: Mapping) -> tuple[TriggerSpec, ...]:
        """The triggers of a state: outcomes and events, conditions, durations, then `always`."""
        found: list[TriggerSpec] = []
        for key in _TRIGGERS:
            trigger = cast(TriggerKind, key.name)
            entries = self.nested(self.map(node, key.name), _is_key_of_transition, f"`{key.name}`")
            for cause, value in entries:
                if key.kind.pattern and not key.kind.pattern.fullmatch(cause.text):
                    hint = "an outcome is one word; an event has a dot"
                    self.fail(
                        "bad-event",
                        f"'{cause.text}' is no outcome and no event",
                        cause.where,
                        _blank_missing(cause, hint) if ":" in cause.text else hint,
                    )
                    continue
                found.append(self.trigger(trigger, cause, value))
        always = node.get("always")
        if always is not None:
            word = next(word for word, _ in node if word.text == "always")
            found.append(self.trigger("always", word, always))
        return tuple(found)

    def trigger(self, trigger: TriggerKind, key: Scalar, value: YamlNode) -> TriggerSpec:
        """A trigger with its transition, or with a list of alternatives."""
        many = isinstance(value, Sequence)
        items = value.items if isinstance(value, Sequence) else [value]
        if many and not items:
            self.fail("empty-transition", "the list of alternatives is empty", value.where)
        alternatives = [self.transition(trigger, key, item) for item in items]
        return TriggerSpec(trigger, key, tuple(a for a in alternatives if a is not None))

    def transition(
        self, trigger: TriggerKind, key: Scalar, node: YamlNode
    ) -> TransitionSpec | None:
        """One alternative: a target, or the long form. None when it cannot be read."""
        if isinstance(node, Scalar):
            if node.null or not node.text:
                hint = "name a target, or write {} for `taken, nothing happens`"
                if ":" in key.text:
                    hint = _blank_missing(key, hint)
                elif any(mark in key.text for mark in "([{"):
                    hint = "a key with a comma or bracket inside `{ }` needs quotes"
                self.fail("empty-transition", f"'{key.text}' leads nowhere", key.where, hint)
                return None
            return TransitionSpec(node.where, (node,))
        if isinstance(node, Sequence):
            self.fail(
                "wrong-type",
                "a list is a list of alternatives; this is one inside another",
                node.where,
                "several regions are entered by `target: [a, b]`",
            )
            return None
        node = self.keys(node, keys.AT["transition"], "a transition")
        found = TransitionSpec(node.where, **self.fields(node, _TRANSITION_FIELDS))
        if found.hold and trigger != "when":
            hint = "to wait, use `after`"
            self.fail(
                "misplaced-for", "`for` belongs to `when` only", self.where(node, "for"), hint
            )
        if found.reenter and not found.targets and node.get("target") is None:
            message, hint = "`reenter` needs a `target`", "without one nothing is left"
            self.fail("misplaced-reenter", message, self.where(node, "reenter"), hint)
        return found

    # -- keys -------------------------------------------------------------------------------

    def keys(self, node: Mapping, allowed: dict[str, Key], what: str) -> Mapping:
        """The map with each misspelt key read as the one that was meant."""
        meant: list[tuple[Scalar, YamlNode]] = []

        def belongs(before: Scalar, key: Scalar, value: YamlNode) -> bool:
            known = key.text in allowed or certain(key.text, allowed) or key.text in keys.NOT_YET
            return before.text in _EXAMPLES and before.text in allowed and not known

        entries = self.nested(node, belongs, what)
        present = {key.text for key, _ in entries}
        for key, value in entries:
            if key.text in allowed:
                meant.append((key, value))
                continue
            if key.text in keys.NOT_YET:
                meant.append((key, value))
                self.fail(
                    "not-yet",
                    f"'{key.text}' is part of the language but not of this version",
                    key.where,
                )
                continue
            near = get_close_matches(key.text, allowed, n=1)
            if not near:
                meant.append((key, value))
            elif near[0] not in present | {k.text for k, _ in meant}:
                meant.append((Scalar(near[0], key.where), value))
            hint = nearest(key.text, allowed)
            if key.text in keys.TOP_ONLY:
                hint = f"'{key.text}' stands at the top of the file only"
            elif ":" in key.text:
                hint = _blank_missing(key)
            elif allowed is keys.AT["state"] and _looks_like_state(value):
                hint = (
                    "indent it less, if it is a state beside this one; `states` holds those inside"
                )
            self.fail("unknown-key", f"{what} has no key '{key.text}'", key.where, hint)
        return Mapping(meant, node.where)

    def nested(
        self, entries: Iterable[tuple[Scalar, YamlNode]], belongs: _Belongs, what: str
    ) -> list[tuple[Scalar, YamlNode]]:
        """The entries of a map, with what lacks its indentation put inside the key above it.

        That is an empty key, and what stands on the lines below it in the same column though it
        belongs inside. It is one fault, at the first of them.
        """
        found: list[tuple[Scalar, YamlNode]] = []
        inside: Mapping | None = None
        for key, value in entries:
            before, above = found[-1] if found else (key, value)
            below = key.where.line > before.where.line and belongs(before, key, value)
            if inside is not None and below:
                inside.entries.append((key, value))
                continue
            inside = None
            if below and isinstance(above, Scalar) and above.null:
                hint = f"indent it further, if it belongs to `{before.text}` above it"
                self.fail("unknown-key", f"{what} has no key '{key.text}'", key.where, hint)
                inside = Mapping([(key, value)], key.where)
                found[-1] = before, inside
            else:
                found.append((key, value))
        return found

    def where(self, node: Mapping, key: str) -> Where:
        """The place of a key, or of the map that lacks it."""
        return next((name.where for name, _ in node if name.text == key), node.where)

    def fields(self, node: Mapping, rows: Iterable[Key]) -> dict[str, Any]:
        """The values of those keys that are there, by the fields they are read into.

        What cannot be read is left out, and so gets the field's own default.
        """
        given = {name.text: value for name, value in node}
        found = {}
        for key in rows:
            if key.name in given:
                value = self.readers[key.kind.reader](given[key.name], key)
                if value is not None:
                    found[key.field] = value
        return found

    def value(self, node: Mapping, key: Key) -> Any:
        """The value of one key; None when it is not there or cannot be read."""
        value = node.get(key.name)
        return None if value is None else self.readers[key.kind.reader](value, key)

    # -- values -----------------------------------------------------------------------------

    def scalar(self, value: YamlNode, key: Key) -> Scalar | None:
        if isinstance(value, Scalar) and not value.null:
            return value
        self.fail("wrong-type", f"`{key.name}` is a text, not {kind(value)}", value.where)
        return None

    def name(self, value: YamlNode, key: Key) -> Scalar | None:
        scalar = self.scalar(value, key)
        if scalar and key.kind.pattern and not key.kind.pattern.fullmatch(scalar.text):
            self.fail("bad-name", f"'{scalar.text}' is not a name", scalar.where, key.kind.hint)
            return None
        return scalar

    def outcome(self, value: YamlNode, key: Key) -> str | None:
        scalar = self.name(value, key)
        return scalar.text if scalar else None

    def text(self, value: YamlNode, key: Key) -> str | None:
        scalar = self.scalar(value, key)
        return scalar.text if scalar else None

    def boolean(self, value: YamlNode, key: Key) -> bool:
        return self.choice(value, key, ("true", "false")) == "true"

    def choice(
        self, value: YamlNode, key: Key, options: tuple[str, ...] | None = None
    ) -> str | None:
        """One of the words that the key takes; ``options`` where they are fewer here."""
        scalar, words = self.scalar(value, key), options or key.kind.options
        if scalar is None or scalar.text in words:
            return scalar.text if scalar else None
        self.fail(
            "unknown-word",
            f"`{key.name}` is {' or '.join(words)}, not '{scalar.text}'",
            scalar.where,
            nearest(scalar.text, words),
        )
        return None

    def scalars(self, value: YamlNode, key: Key) -> tuple[Scalar, ...]:
        found = []
        for item in value.items if isinstance(value, Sequence) else [value]:
            if isinstance(item, Scalar) and not item.null:
                found.append(item)
            else:
                self.fail("wrong-type", f"`{key.name}` is a text or a list of texts", item.where)
        return tuple(found)

    def map(self, node: Mapping, key: str) -> list[tuple[Scalar, YamlNode]]:
        """The entries of the map behind a key; none where the key is absent."""
        value = node.get(key)
        return [] if value is None else self.entries(value, key)

    def entries(self, value: YamlNode, key: str) -> list[tuple[Scalar, YamlNode]]:
        """The entries of a map; none for any other value, which is a fault."""
        if isinstance(value, Mapping):
            return value.entries
        message, hint = f"`{key}` is a map, not {kind(value)}", _EXAMPLES.get(key)
        self.fail("wrong-type", message, value.where, hint)
        return []

    def named(self, value: YamlNode, key: Key) -> tuple[Named, ...]:
        pattern, found = key.kind.pattern, []
        for name, inner in self.entries(value, key.name):
            if pattern and not pattern.fullmatch(name.text):
                what = "an event (it needs a dot)" if pattern is keys.EVENT_NAME else "a name"
                hint = None
                if isinstance(inner, Scalar) and inner.null:
                    hint = (
                        _blank_missing(name)
                        if ":" in name.text
                        else "a text with a comma inside `{ }` needs quotes; decimals have a point"
                    )
                self.fail("bad-name", f"'{name.text}' is not {what}", name.where, hint)
                continue
            found.append(Named(name, inner))
        return tuple(found)

    def defines(self, value: YamlNode, key: Key) -> tuple[DefineSpec, ...]:
        found = []
        for name, body in self.entries(value, key.name):
            match = _DEFINE.fullmatch(name.text)
            listed = match[2] or "" if match else ""
            arguments = tuple(part for word in listed.split(",") if (part := word.strip()))
            if not match or any(not keys.NAME.fullmatch(argument) for argument in arguments):
                message = f"'{name.text}' is no name to define"
                self.fail("bad-name", message, name.where, "name or name(a, b)")
            elif isinstance(body, Scalar):
                found.append(DefineSpec(match[1], arguments, body, name.where))
            else:
                message = f"a `define` is an expression, not {kind(body)}"
                self.fail("wrong-type", message, body.where)
        return tuple(found)

    def actions(self, value: YamlNode, key: Key) -> tuple[ActionSpec, ...]:
        found = []
        for block in value.items if isinstance(value, Sequence) else [value]:
            if not isinstance(block, Mapping):
                self.fail(
                    "wrong-type",
                    f"actions are a map like {{log: text}}, or a list of such, not {kind(block)}",
                    block.where,
                )
                continue
            block = self.keys(block, keys.AT["actions"], "actions")
            for name, argument in block:
                if name.text in keys.AT["actions"]:
                    found.append(ActionSpec(cast(ActionKind, name.text), argument, name.where))
        return tuple(found)
