"""Compiles the executable content of SCXML: what `onentry`, `onexit` and transitions hold."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, NoReturn, TypeVar

from fsm.chart.executable import CONTENT, Action, ActionFunction, EventFields, Runtime
from fsm.expressions.compiled import Compiled, Evaluator
from fsm.faults import Faults
from fsm.scxml.datamodel import RUN_TIME, DataModel, Location, Names
from fsm.scxml.document import Element
from fsm.scxml.sending import Sending, seconds, unreachable
from fsm.values.functions import LOOP_BUDGET, Budget, EvaluationError, shown
from fsm.values.types import ANY
from vencejo.errors import UserError, Where, nearest

Made = TypeVar("Made")


@dataclass(frozen=True)
class Content:
    """Compiles executable content; mistakes are added to ``faults``."""

    model: DataModel
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
        """Compile an action; one that is ill-formed is a warning, and fails whenever it is run."""
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
        try:
            return compile_(element)
        except UserError as error:
            return self.failing(error)

    # -- pieces -----------------------------------------------------------------------------

    def failing(self, error: UserError) -> Callable[..., NoReturn]:
        """A function in place of what is ill-formed, which fails whenever it is called.

        Raises the error again when it is not one of run time.
        """
        fault = error.faults[0]
        if fault.code not in RUN_TIME or fault.where is None:
            raise error
        self.names.warn(fault.code, fault.message, fault.where, fault.hint)

        def fail(*_: object) -> NoReturn:
            raise EvaluationError(fault.message)

        return fail

    def compiled(
        self, compile_: Callable[[str, Where, Names], Made], text: str, where: Where
    ) -> Made:
        """Compile a text. Raises UserError, and then warns of none of its names."""
        found = Faults()
        made = compile_(text, where, replace(self.names, faults=found))
        self.faults.extend(found)
        return made

    def value(self, element: Element, attribute: str) -> Evaluator:
        """The compiled expression of an attribute that must be there. Raises UserError."""
        text = needed(element, attribute)
        return self.compiled(self.model.compile_value, text, element.place(attribute))

    def late(self, text: str, where: Where) -> Evaluator:
        """A compiled expression; one that is ill-formed fails when it is evaluated."""
        try:
            return self.compiled(self.model.compile_value, text, where)
        except UserError as error:
            return self.failing(error)

    def either(self, element: Element, literal: str, expression: str) -> Evaluator | None:
        """A value from a text in one attribute or an expression in another; None without both."""
        text, computed = element.get(literal), element.get(expression)
        alone(element, literal, expression)
        if text is not None:
            return lambda s, e: text
        return None if computed is None else self.late(computed, element.place(expression))

    def condition(self, element: Element) -> Compiled | None:
        text = element.get("cond")
        if text is None:
            return None
        where = element.place("cond")
        function: Evaluator
        try:
            function = self.compiled(self.model.compile_condition, text, where)
        except UserError as error:
            function = self.failing(error)
        return Compiled(ANY, function, text, where)

    def location(self, element: Element, attribute: str) -> Location:
        """The compiled location of an attribute that must be there. Raises UserError."""
        text = needed(element, attribute)
        return self.compiled(self.model.compile_location, text, element.place(attribute))

    def variable(self, element: Element, attribute: str) -> Location:
        """The variable in an attribute that must be there. Raises UserError."""
        location = self.location(element, attribute)
        if location.keys:
            message = f"'{element.get(attribute)}' is no variable"
            raise UserError("bad-location", message, element.place(attribute))
        return location

    def text(self, element: Element) -> Evaluator | None:
        """The value of an element's text; None when there is none. Raises UserError."""
        is_xml = element.children or (element.file is not None and element.text.startswith("<"))
        if is_xml:
            where = element.children[0].where if element.children else element.place("src")
            raise UserError(
                "not-supported",
                f"XML in <{element.tag}> is not supported",
                where,
                "give the value in `expr`, or as JSON",
            )
        if element.get("src") is not None:
            loaded(element)
        return self.model.content(element.text) if element.text else None

    def given(self, element: Element) -> Evaluator | None:
        """The value in `expr` or in the text of an element; None without both. Raises UserError."""
        text = self.text(element)
        if element.get("expr") is None:
            return text
        if text is not None:
            what = f"<{element.tag}> has a value in `expr` and another inside"
            raise UserError("conflicting-values", what, element.place("expr"), "remove one")
        return self.late(element.attributes["expr"], element.place("expr"))

    def fields(self, element: Element) -> dict[str, Evaluator]:
        """Compile the data that `namelist`, `param` and `content` give to an event.

        An event gets copies: what a variable holds later is not its.
        """
        found: dict[str, Evaluator] = {}
        for name in (element.get("namelist") or "").split():
            found[name] = self.late(name, element.place("namelist"))
        for child in element.all("param"):
            alone(child, "expr", "location")
            attribute = "location" if child.get("expr") is None else "expr"
            text = needed(child, attribute)
            found[needed(child, "name")] = self.late(text, child.place(attribute))
        for child in element.all("content"):
            if found:
                what = "<content> stands beside named data"
                raise UserError("conflicting-values", what, child.where, "keep one of both")
            whole = self.given(child)
            found = {} if whole is None else {CONTENT: whole}
        return {name: _copied(value) for name, value in found.items()}

    # -- actions ----------------------------------------------------------------------------

    def assign(self, element: Element) -> ActionFunction:
        name = needed(element, "location").strip()
        value = self.given(element) or self.value(element, "expr")
        location = self.location(element, "location")

        def run(instance: Runtime, event: EventFields) -> None:
            found = value(instance.slots, event)
            location.assign(instance.slots, event, found)
            instance.record("set", name=name, value=deepcopy(found))

        return run

    def script(self, element: Element) -> ActionFunction:
        if element.get("src") is not None:
            loaded(element)
        where = element.text_where or element.where
        statements = self.compiled(self.model.compile_script, element.text, where)

        def run(instance: Runtime, event: EventFields) -> None:
            for statement in statements:
                found = statement.value(instance.slots, event)
                statement.location.assign(instance.slots, event, found)
                instance.record("set", name=statement.location.name, value=deepcopy(found))

        return run

    def log(self, element: Element) -> ActionFunction:
        value = self.value(element, "expr") if element.get("expr") is not None else None
        label = element.get("label")

        def run(instance: Runtime, event: EventFields) -> None:
            parts = [label] if label else []
            parts += [self.model.text_of(value(instance.slots, event))] if value else []
            instance.record("log", text=": ".join(parts))

        return run

    def raise_(self, element: Element) -> ActionFunction:
        name = needed(element, "event")
        return lambda instance, event: instance.raise_event(name, {})

    def send(self, element: Element) -> ActionFunction:
        name = self.either(element, "event", "eventexpr")
        if name is None:
            raise UserError("missing-attribute", "<send> needs an `event`", element.where)
        alone(element, "id", "idlocation")
        if element.get("delay") is not None:
            seconds(element.attributes["delay"], element.place("delay"))
        keep_id: Callable[[list[Any], EventFields, Any], None] | None = None
        if element.get("idlocation") is not None:
            try:
                keep_id = self.location(element, "idlocation").assign
            except UserError as error:
                keep_id = self.failing(error)
        self.warn_of_target(element)
        return Sending(
            self.model,
            name,
            self.fields(element),
            self.either(element, "target", "targetexpr"),
            self.either(element, "type", "typeexpr"),
            self.either(element, "delay", "delayexpr"),
            element.get("id"),
            keep_id,
            self.counter,
        ).run

    def warn_of_target(self, element: Element) -> None:
        """Warn of a `<send>` whose written target or type can never be reached."""
        wrong = unreachable(element.get("target") or "", element.get("type") or "")
        if wrong is not None:
            hint = f"it raises {wrong.event} at run time; without target it goes to this document"
            self.faults.warn("not-sent", wrong.message, element.place(wrong.attribute), hint)

    def cancel(self, element: Element) -> ActionFunction:
        id_ = self.either(element, "sendid", "sendidexpr")
        if id_ is None:
            raise UserError("missing-attribute", "<cancel> needs a `sendid`", element.where)
        text_of = self.model.text_of
        return lambda instance, event: instance.cancel(text_of(id_(instance.slots, event)))

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
        budget = self.budget or Budget()
        actions = replace(self, budget=budget).actions(element.children)
        array = self.value(element, "array")
        item = self.variable(element, "item").slot
        index = self.variable(element, "index").slot if element.get("index") is not None else None

        def run(instance: Runtime, event: EventFields) -> None:
            if self.budget is None:
                budget.left = LOOP_BUDGET
            values = array(instance.slots, event)
            if not isinstance(values, (list, tuple)):
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


def _copied(value: Evaluator) -> Evaluator:
    return lambda slots, event: deepcopy(value(slots, event))


def needed(element: Element, attribute: str) -> str:
    """The text of an attribute. Raises UserError when it is missing."""
    text = element.get(attribute)
    if text is None or not text.strip():
        message = f"<{element.tag}> needs `{attribute}`"
        raise UserError("missing-attribute", message, element.where)
    return text


def loaded(element: Element) -> None:
    """Raise UserError when the file that an element names in `src` was not read."""
    if element.file is None:
        what = "a file can only be read from beside a document that is a file itself"
        raise UserError("not-supported", what, element.place("src"), "write its text here")


def alone(element: Element, one: str, other: str) -> None:
    """Raise UserError when an element has two attributes of which it may have one."""
    if element.get(one) is not None and element.get(other) is not None:
        what = f"<{element.tag}> has both `{one}` and `{other}`"
        raise UserError("conflicting-values", what, element.place(other), "remove one")
