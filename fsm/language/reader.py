"""Reads the nodes of a mission file into its spec; finds every mistake of form."""

from __future__ import annotations

import re
from collections.abc import Callable
from difflib import get_close_matches
from typing import cast

from fsm.faults import Faults
from fsm.language import keys
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
from vencejo.errors import UserError, Where, nearest
from vencejo.nodes import Mapping, Scalar, Sequence, YamlNode, kind

LANGUAGE = 1
FLEET = "not-a-mission"
"""The code of the fault that a file is a fleet."""
MAX_STATE_DEPTH = 64

_DEFINE = re.compile(r"([A-Za-z][A-Za-z0-9_]*)\s*(?:\(([^()]*)\))?")


def spec_of(node: Mapping, file: str, name: str, faults: Faults) -> MissionSpec:
    """The mission of a file's nodes; every mistake of form goes to ``faults``."""
    return _Reader(faults).mission(node, file, name)


class _Reader:
    """Collects faults while it reads, so that one look shows them all."""

    def __init__(self, faults: Faults) -> None:
        self.faults = faults
        self.fail = faults.fail

    def mission(
        self, node: Mapping, file: str, stem: str, inside: Where | None = None
    ) -> MissionSpec:
        """A whole file, or the graph that begins at ``inside`` in one."""
        fleet = node.get("fleet")
        if fleet is not None and inside is None:
            raise UserError(
                FLEET,
                f"'{file}' is a fleet, and fleets do not fly yet",
                fleet.where,
                "`drone-cli check` checks it; `drone-cli run` flies one of its missions by itself",
            )
        if inside is None:
            node = self.keys(node, keys.ROOT_KEYS | keys.STATE_KEYS, "a mission")
        else:
            node = self.keys(node, keys.GRAPH_KEYS | keys.STATE_KEYS, "a graph")
        name = self.named_scalar(node, "mission", keys.MISSION_NAME, "letters, digits, - and _")
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
        priority = self.choice(node, "priority", ("inner", "outer")) or "inner"
        return MissionSpec(
            name=name.text if name else stem,
            file=file,
            root=self.state("", node, inside or node.where, 0),
            description=self.text(node, "description"),
            world=self.scalar(node, "world"),
            uses=self.scalars(node, "uses"),
            places=self.named(node, "places", keys.NAME),
            parameters=self.named(node, "parameters", keys.NAME),
            events=self.named(node, "events", keys.EVENT_NAME),
            outer_first=priority == "outer",
            node=node,
            graphs=self.graphs(node, file) if inside is None else (),
        )

    def graphs(self, node: Mapping, file: str) -> tuple[MissionSpec, ...]:
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
        root = depth == 0
        if depth > MAX_STATE_DEPTH:
            raise UserError("too-deep", f"states nest at most {MAX_STATE_DEPTH} deep", where)
        types = ("parallel",) if root else ("parallel", "final", "history")
        declared = self.choice(node, "type", types)
        type_ = cast(StateType, declared or self.usual_type(node))
        allowed = {"final": keys.FINAL_KEYS, "history": keys.HISTORY_KEYS}.get(
            type_, keys.STATE_KEYS
        )
        if not root:
            node = self.keys(node, allowed, f"a {declared} state" if declared else "a state")
        states = self.states(node, depth)
        if type_ == "parallel" and not states:
            self.fail("no-states", "a parallel state needs `states`", where)
        for key in ("with", "live", "as"):
            if node.get(key) and not node.get("do") and not node.get("include"):
                self.fail("no-behaviour", f"`{key}` needs a `do`", self.where(node, key))
        for key in ("do", "as", "states", "type"):
            if node.get("include") and node.get(key):
                message = f"`{key}` and `include` do not go together"
                hint = "put the `include` into a state of its own"
                self.fail("misplaced-include", message, self.where(node, key), hint)
        before = self.faults.errors
        triggers = self.triggers(node)
        flawed = self.faults.errors > before
        return StateSpec(
            name=name,
            where=where,
            type=type_,
            initial=self.scalar(node, "initial"),
            description=self.text(node, "description"),
            data=self.named(node, "data", keys.NAME),
            define=self.defines(node),
            entry=self.actions(node, "entry"),
            exit=self.actions(node, "exit"),
            throughout=self.actions(node, "throughout"),
            do=self.scalar(node, "do"),
            with_=self.named(node, "with", keys.NAME),
            live=self.named(node, "live", keys.NAME),
            as_=self.named_scalar(node, "as", keys.NAME, "letters, digits and _"),
            include=self.scalar(node, "include"),
            triggers=triggers,
            states=states,
            outcome=self.outcome(node),
            output=self.named(node, "output", keys.NAME),
            deep=self.boolean(node, "deep"),
            target=self.scalar(node, "target") if type_ == "history" else None,
            breakpoint=self.boolean(node, "breakpoint"),
            flawed=flawed,
        )

    def usual_type(self, node: Mapping) -> StateType:
        return "compound" if node.get("states") or node.get("include") else "atomic"

    def states(self, node: Mapping, depth: int) -> tuple[StateSpec, ...]:
        children = []
        for key, value in self.map(node, "states"):
            if not keys.SMALL_NAME.fullmatch(key.text):
                self.fail(
                    "bad-name",
                    f"'{key.text}' is no name for a state",
                    key.where,
                    "a small letter, then small letters, digits and _",
                )
            if isinstance(value, Scalar) and value.null:
                value = Mapping([], key.where)
            if not isinstance(value, Mapping):
                self.fail("wrong-type", f"a state is a map, not {kind(value)}", value.where)
                value = Mapping([], key.where)
            children.append(self.state(key.text, value, key.where, depth + 1))
        return tuple(children)

    def outcome(self, node: Mapping) -> str:
        scalar = self.named_scalar(node, "outcome", keys.SMALL_NAME, "an outcome is one small word")
        return scalar.text if scalar else "done"

    def defines(self, node: Mapping) -> tuple[DefineSpec, ...]:
        found = []
        for key, value in self.map(node, "define"):
            match = _DEFINE.fullmatch(key.text)
            arguments = (
                tuple(
                    argument.strip() for argument in (match[2] or "").split(",") if argument.strip()
                )
                if match
                else ()
            )
            if not match or any(not keys.NAME.fullmatch(argument) for argument in arguments):
                self.fail(
                    "bad-name",
                    f"'{key.text}' is no name to define",
                    key.where,
                    "name or name(a, b)",
                )
            elif isinstance(value, Scalar):
                found.append(DefineSpec(match[1], arguments, value, key.where))
            else:
                self.fail(
                    "wrong-type", f"a `define` is an expression, not {kind(value)}", value.where
                )
        return tuple(found)

    # -- transitions ------------------------------------------------------------------------

    def triggers(self, node: Mapping) -> tuple[TriggerSpec, ...]:
        found: list[TriggerSpec] = []
        kinds: tuple[TriggerKind, ...] = ("on", "when", "after")
        for trigger in kinds:
            for key, value in self.map(node, trigger):
                if trigger == "on" and not keys.TRIGGER.fullmatch(key.text):
                    self.fail(
                        "bad-event",
                        f"'{key.text}' is no outcome and no event",
                        key.where,
                        "an outcome is one word; an event has a dot"
                        + (": is a blank missing after the colon?" if ":" in key.text else ""),
                    )
                    continue
                found.append(self.trigger(trigger, key, value))
        always = node.get("always")
        if always is not None:
            key = next(key for key, _ in node if key.text == "always")
            found.append(self.trigger("always", key, always))
        return tuple(found)

    def trigger(self, trigger: TriggerKind, key: Scalar, value: YamlNode) -> TriggerSpec:
        many = isinstance(value, Sequence)
        items = value.items if isinstance(value, Sequence) else [value]
        if many and not items:
            self.fail("empty-transition", "the list of alternatives is empty", value.where)
        alternatives = [self.transition(trigger, key, item) for item in items]
        return TriggerSpec(trigger, key, tuple(a for a in alternatives if a is not None))

    def transition(
        self, trigger: TriggerKind, key: Scalar, node: YamlNode
    ) -> TransitionSpec | None:
        if isinstance(node, Scalar):
            if node.null or not node.text:
                hint = "name a target, or write {} for `taken, nothing happens`"
                if ":" in key.text:
                    hint = "is a blank missing after the colon? " + hint
                elif any(mark in key.text for mark in "([{"):
                    hint = "a key with a comma or bracket inside `{ }` needs quotes"
                self.fail("empty-transition", f"'{key.text}' leads nowhere", key.where, hint)
                return None
            return TransitionSpec((node,), node.where)
        if isinstance(node, Sequence):
            self.fail(
                "wrong-type",
                "a list is a list of alternatives; this is one inside another",
                node.where,
                "several regions are entered by `target: [a, b]`",
            )
            return None
        node = self.keys(node, keys.TRANSITION_KEYS, "a transition")
        hold = self.scalar(node, "for")
        if hold and trigger != "when":
            self.fail("misplaced-for", "`for` belongs to `when` only", self.where(node, "for"))
        return TransitionSpec(
            targets=self.scalars(node, "target"),
            where=node.where,
            guard=self.scalar(node, "guard"),
            actions=self.actions(node, "actions"),
            hold=hold,
            reenter=self.boolean(node, "reenter"),
            name=self.text(node, "name"),
            description=self.text(node, "description"),
        )

    def actions(self, node: Mapping, key: str) -> tuple[ActionSpec, ...]:
        value = node.get(key)
        if value is None:
            return ()
        found = []
        for block in value.items if isinstance(value, Sequence) else [value]:
            if not isinstance(block, Mapping):
                self.fail(
                    "wrong-type",
                    f"actions are a map like {{log: text}}, or a list of such, not {kind(block)}",
                    block.where,
                )
                continue
            block = self.keys(block, keys.ACTIONS, "actions")
            for name, argument in block:
                if name.text in keys.ACTIONS:
                    found.append(ActionSpec(cast(ActionKind, name.text), argument, name.where))
        return tuple(found)

    # -- pieces -----------------------------------------------------------------------------

    def keys(self, node: Mapping, allowed: frozenset[str], what: str) -> Mapping:
        """The map with each misspelt key read as the one that was meant."""
        meant: list[tuple[Scalar, YamlNode]] = []
        for key, value in node:
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
            near = get_close_matches(key.text, allowed - {other.text for other, _ in node}, n=1)
            if not near:
                meant.append((key, value))
            elif near[0] not in {k.text for k, _ in meant}:
                meant.append((Scalar(near[0], key.where), value))
            hint = nearest(key.text, allowed)
            if key.text in keys.ROOT_KEYS:
                hint = f"'{key.text}' stands at the top of the file only"
            elif ":" in key.text:
                hint = "is a blank missing after the colon?"
            self.fail("unknown-key", f"{what} has no key '{key.text}'", key.where, hint)
        return Mapping(meant, node.where)

    def where(self, node: Mapping, key: str) -> Where:
        return next((name.where for name, _ in node if name.text == key), node.where)

    def _expect(
        self, node: Mapping, key: str, what: str, test: Callable[[YamlNode], bool]
    ) -> YamlNode | None:
        value = node.get(key)
        if value is None or test(value):
            return value
        self.fail("wrong-type", f"`{key}` is {what}, not {kind(value)}", value.where)
        return None

    def scalar(self, node: Mapping, key: str) -> Scalar | None:
        value = self._expect(node, key, "a text", lambda v: isinstance(v, Scalar) and not v.null)
        return value if isinstance(value, Scalar) else None

    def named_scalar(
        self, node: Mapping, key: str, pattern: re.Pattern[str], hint: str
    ) -> Scalar | None:
        scalar = self.scalar(node, key)
        if scalar and not pattern.fullmatch(scalar.text):
            self.fail("bad-name", f"'{scalar.text}' is not a name", scalar.where, hint)
            return None
        return scalar

    def text(self, node: Mapping, key: str) -> str:
        scalar = self.scalar(node, key)
        return scalar.text if scalar else ""

    def boolean(self, node: Mapping, key: str) -> bool:
        value = self.choice(node, key, ("true", "false"))
        return value == "true"

    def choice(self, node: Mapping, key: str, options: tuple[str, ...]) -> str | None:
        scalar = self.scalar(node, key)
        if scalar is None or scalar.text in options:
            return scalar.text if scalar else None
        self.fail(
            "unknown-word",
            f"`{key}` is {' or '.join(options)}, not '{scalar.text}'",
            scalar.where,
            nearest(scalar.text, options),
        )
        return None

    def scalars(self, node: Mapping, key: str) -> tuple[Scalar, ...]:
        value = node.get(key)
        items = value.items if isinstance(value, Sequence) else [value] if value is not None else []
        found = []
        for item in items:
            if isinstance(item, Scalar) and not item.null:
                found.append(item)
            else:
                self.fail("wrong-type", f"`{key}` is a text or a list of texts", item.where)
        return tuple(found)

    def map(self, node: Mapping, key: str) -> list[tuple[Scalar, YamlNode]]:
        value = self._expect(node, key, "a map", lambda v: isinstance(v, Mapping))
        return value.entries if isinstance(value, Mapping) else []

    def named(self, node: Mapping, key: str, pattern: re.Pattern[str]) -> tuple[Named, ...]:
        found = []
        for name, value in self.map(node, key):
            if not pattern.fullmatch(name.text):
                what = "an event (it needs a dot)" if pattern is keys.EVENT_NAME else "a name"
                hint = None
                if isinstance(value, Scalar) and value.null:
                    hint = "a text with a comma inside `{ }` needs quotes; decimals have a point"
                self.fail("bad-name", f"'{name.text}' is not {what}", name.where, hint)
                continue
            found.append(Named(name, value))
        return tuple(found)
