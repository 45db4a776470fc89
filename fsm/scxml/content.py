"""Compiles the executable content of SCXML: what `onentry`, `onexit` and transitions hold."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NoReturn

from fsm.chart.executable import Action, ActionFunction, EventFields, Runtime
from fsm.expressions.compiled import Compiled, Evaluator
from fsm.faults import Faults
from fsm.scxml.document import Element
from fsm.scxml.ecmascript import (
    Names,
    compile_condition,
    compile_script,
    compile_value,
)
from fsm.scxml.ecmascript_values import text_of
from fsm.values.functions import LOOP_BUDGET, Budget, EvaluationError, shown
from fsm.values.types import ANY
from vencejo.errors import UserError, Where, nearest

_DELAY = re.compile(r"\s*(\d{1,12}(?:\.\d*)?|\.\d+)\s*(ms|s)\s*")
"""At most 12 digits before the point: a longer number could be slow to read, or infinite."""
_INTERNAL = "#_internal"
_PROCESSORS = ("scxml", "http://www.w3.org/TR/scxml/#SCXMLEventProcessor")


@dataclass(frozen=True)
class Content:
    """Compiles executable content; mistakes are added to ``faults``."""

    names: Names
    faults: Faults
    counter: int
    """Slot of the number of events sent without an id."""
    budget: Budget | None = None
    """The steps left to the outermost `foreach` around, shared by all loops inside it."""

    def blocks(self, handlers: Iterable[Element]) -> tuple[Action, ...]:
        """Compile handlers into one block each: when one fails, the next still runs."""
        blocks = [(handler, self.actions(handler.children)) for handler in handlers]
        if len(blocks) == 1:
            return blocks[0][1]
        return tuple(Action("block", handler.where, _block(actions)) for handler, actions in blocks)

    def actions(self, elements: Iterable[Element]) -> tuple[Action, ...]:
        found = []
        for element in elements:
            if element.tag.startswith(("{", "v:")):
                continue
            with self.faults.collecting():
                found.append(Action(element.tag, element.where, self.action(element)))
        return tuple(found)

    def action(self, element: Element) -> ActionFunction:
        kinds: Mapping[str, Callable[[Element], ActionFunction]] = {
            "assign": self.assign,
            "script": self.script,
            "log": self.log,
            "raise": self.raise_,
            "send": self.send,
            "cancel": self.cancel,
            "if": self.if_,
            "foreach": self.foreach,
        }
        compile_ = kinds.get(element.tag)
        if compile_ is None:
            raise UserError(
                "not-supported",
                f"<{element.tag}> is not among the actions that can be run",
                element.where,
                nearest(element.tag, kinds),
            )
        return compile_(element)

    # -- pieces -----------------------------------------------------------------------------

    def value(self, element: Element, attribute: str) -> Evaluator:
        """The compiled expression of an attribute that must be there."""
        return compile_value(needed(element, attribute), element.place(attribute), self.names)

    def optional(self, element: Element, literal: str, expression: str) -> Evaluator | None:
        """A value from a text in one attribute or an expression in another; None without both."""
        text = element.get(literal)
        if text is not None:
            return lambda s, e: text
        return self.value(element, expression) if element.get(expression) is not None else None

    def condition(self, element: Element) -> Compiled | None:
        text = element.get("cond")
        if text is None:
            return None
        where = element.place("cond")
        return Compiled(ANY, compile_condition(text, where, self.names), text, where)

    def slot(self, element: Element, attribute: str) -> int:
        return self.variable(needed(element, attribute), element.place(attribute))

    def variable(self, name: str, where: Where) -> int:
        if name not in self.names.variables or name.startswith("_"):
            hint = nearest(name, [n for n in self.names.variables if not n.startswith("_")])
            raise UserError("unknown-name", f"there is no variable '{name}'", where, hint)
        return self.names.variables[name]

    def fields(self, element: Element) -> dict[str, Evaluator]:
        """Compile the fields that `namelist` and `param` give to an event."""
        found: dict[str, Evaluator] = {}
        for name in (element.get("namelist") or "").split():
            self.variable(name, element.place("namelist"))
            found[name] = compile_value(name, element.place("namelist"), self.names)
        for child in element.children:
            if child.tag == "content":
                _unsupported(child, "<content>", "give the event's data by <param>")
            if child.tag == "param":
                attribute = "location" if child.get("expr") is None else "expr"
                found[needed(child, "name")] = self.value(child, attribute)
        return found

    # -- actions ----------------------------------------------------------------------------

    def assign(self, element: Element) -> ActionFunction:
        slot, name = self.slot(element, "location"), needed(element, "location")
        value = self.value(element, "expr")

        def run(instance: Runtime, event: EventFields) -> None:
            instance.slots[slot] = found = value(instance.slots, event)
            instance.record("set", name=name, value=found)

        return run

    def script(self, element: Element) -> ActionFunction:
        if element.get("src") is not None:
            _unsupported(element, "a script in another file", "write its assignments here")
        where = element.text_where or element.where
        statements = [
            (self.variable(assignment.name, where), assignment)
            for assignment in compile_script(element.text, where, self.names)
        ]

        def run(instance: Runtime, event: EventFields) -> None:
            for slot, assignment in statements:
                instance.slots[slot] = found = assignment.value(instance.slots, event)
                instance.record("set", name=assignment.name, value=found)

        return run

    def log(self, element: Element) -> ActionFunction:
        value = self.value(element, "expr") if element.get("expr") is not None else None
        label = element.get("label")

        def run(instance: Runtime, event: EventFields) -> None:
            parts = [label] if label else []
            parts += [text_of(value(instance.slots, event))] if value else []
            instance.record("log", text=": ".join(parts))

        return run

    def raise_(self, element: Element) -> ActionFunction:
        name = needed(element, "event")
        return lambda instance, event: instance.raise_event(name, {})

    def send(self, element: Element) -> ActionFunction:
        if element.get("targetexpr") is not None or element.get("typeexpr") is not None:
            _unsupported(element, "a computed target or type", None)
        target = element.get("target") or ""
        if target not in ("", _INTERNAL) or element.get("type") not in (None, *_PROCESSORS):
            _unsupported(element, "sending to others", "an event can go to this graph itself")
        name = self.optional(element, "event", "eventexpr")
        if name is None:
            raise UserError("missing-attribute", "<send> needs an `event`", element.where)
        fields = self.fields(element)
        text = element.get("delay")
        if text is not None:
            seconds(text, element.place("delay"))
        delay = self.optional(element, "delay", "delayexpr")
        id_ = element.get("id")
        location = None
        if element.get("idlocation") is not None:
            location = self.slot(element, "idlocation")

        def run(instance: Runtime, event: EventFields) -> None:
            slots = instance.slots
            data = {key: value(slots, event) for key, value in fields.items()}
            if target == _INTERNAL:
                instance.raise_event(text_of(name(slots, event)), data)
                return
            own = id_
            if own is None:
                slots[self.counter] += 1
                own = f"send.{slots[self.counter]}"
            if location is not None:
                slots[location] = own
            wait = _wait(delay(slots, event)) if delay else 0.0
            instance.send(text_of(name(slots, event)), data, wait, own)

        return run

    def cancel(self, element: Element) -> ActionFunction:
        id_ = self.optional(element, "sendid", "sendidexpr")
        if id_ is None:
            raise UserError("missing-attribute", "<cancel> needs a `sendid`", element.where)
        return lambda instance, event: instance.cancel(id_(instance.slots, event))

    def if_(self, element: Element) -> ActionFunction:
        needed(element, "cond")
        parts: list[tuple[Element, list[Element]]] = [(element, [])]
        for child in element.children:
            if child.tag in ("elseif", "else"):
                if parts[-1][0].tag == "else":
                    raise UserError("bad-if", f"<{child.tag}> comes after <else/>", child.where)
                if child.tag == "elseif":
                    needed(child, "cond")
                parts.append((child, []))
            else:
                parts[-1][1].append(child)
        branches = [(self.condition(head), self.actions(inside)) for head, inside in parts]

        def run(instance: Runtime, event: EventFields) -> None:
            for condition, actions in branches:
                if condition is None or instance.evaluate(condition, event, False) is True:
                    for action in actions:
                        action.run(instance, event)
                    return

        return run

    def foreach(self, element: Element) -> ActionFunction:
        array = self.value(element, "array")
        item = self.slot(element, "item")
        index = self.slot(element, "index") if element.get("index") is not None else None
        budget = self.budget or Budget()
        actions = replace(self, budget=budget).actions(element.children)

        def run(instance: Runtime, event: EventFields) -> None:
            if self.budget is None:
                budget.left = LOOP_BUDGET
            values = array(instance.slots, event)
            if not isinstance(values, list):
                raise EvaluationError(f"{shown(values)} is no list")
            for place, value in enumerate(budget.loop(list(values))):
                instance.slots[item] = value
                if index is not None:
                    instance.slots[index] = place
                for action in actions:
                    action.run(instance, event)

        return run


def _block(actions: tuple[Action, ...]) -> ActionFunction:
    return lambda instance, event: instance.run_actions(actions, event)


def needed(element: Element, attribute: str) -> str:
    """The text of an attribute. Raises UserError when it is missing."""
    text = element.get(attribute)
    if text is None or not text.strip():
        message = f"<{element.tag}> needs `{attribute}`"
        raise UserError("missing-attribute", message, element.where)
    return text


def seconds(text: str, where: Where) -> float:
    """A delay such as ``10ms`` or ``1.5s``. Raises UserError."""
    match = _DELAY.fullmatch(text)
    if match is None:
        raise UserError("bad-delay", f"'{text}' is no delay", where, "10ms or 1.5s")
    return float(match[1]) * (0.001 if match[2] == "ms" else 1.0)


def _wait(value: Any) -> float:
    if isinstance(value, str) and _DELAY.fullmatch(value):
        return seconds(value, Where(""))
    raise EvaluationError(f"{shown(value)} is no delay like '10ms'")


def _unsupported(element: Element, what: str, hint: str | None) -> NoReturn:
    raise UserError("not-supported", f"{what} is not supported", element.where, hint)
