"""The names of a mission: what each state's expressions can see, and in which slot it lies.

What is declared wrongly stays known, as a name of unknown type: one mistake makes one fault.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from fsm.actions import raised
from fsm.expressions import Compiled
from fsm.faults import Faults
from fsm.graph import Data, Invocation, Node
from fsm.literals import Context, read_value
from fsm.parameters import constant_value, named_type, read_parameter, widened
from fsm.scope import FIRST_HOST_SLOT, TIME_SLOT, Binding, Define, Scope
from fsm.spec import ActionSpec, MissionSpec, Named, StateSpec
from fsm.tree import Tree
from fsm.types import ANY, NAMED, TEXT, MapOf, Number, Type
from fsm.vocabulary import Parameter, Vocabulary
from vencejo.errors import UserError, nearest
from vencejo.geometry import Point
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar
from vencejo.units import TIME

Fields = Mapping[str, Type]
FAILED_FIELDS: Fields = MappingProxyType({"reason": TEXT})
ERROR_FIELDS: Fields = MappingProxyType({"message": TEXT, "where": TEXT})
OWN_EVENTS: Mapping[str, Fields] = MappingProxyType(
    {"error.execution": ERROR_FIELDS, "error.livelock": ERROR_FIELDS}
)


class Declarations:
    """Everything a mission declares."""

    def __init__(
        self, spec: MissionSpec, vocabulary: Vocabulary, tree: Tree, faults: Faults
    ) -> None:
        self.vocabulary = vocabulary
        self.tree = tree
        self.faults = faults
        self.slots = tree.first_slot + len(tree.nodes)
        self.scopes: dict[int, Scope] = {}
        self.parameters: dict[str, Parameter] = {}
        self.parameter_slots: dict[str, int] = {}
        self.places: dict[str, Any] = {}
        self.events: dict[str, Fields] = {**OWN_EVENTS, **vocabulary.events}
        """Declared events with their fields."""
        self.raised: dict[str, Fields] = {}
        """Events that the mission only raises, with the fields it gives them."""
        self._read_places(spec)
        host = self._host_scope()
        self._read_parameters(spec, host)
        self._read_events(spec)
        self._declare(tree.root, host)
        self._collect_raised()

    def slot(self) -> int:
        self.slots += 1
        return self.slots - 1

    def context(self, scope: Scope) -> Context:
        return Context(scope, self.places, self.vocabulary.places)

    # -- names of the whole mission ---------------------------------------------------------

    def _host_scope(self) -> Scope:
        scope = Scope()
        scope.names["time"] = Binding("time", "host", Number(TIME), TIME_SLOT)
        for index, (name, type_) in enumerate(self.vocabulary.names.items()):
            scope.names[name] = Binding(name, "host", type_, FIRST_HOST_SLOT + index)
        return scope

    def _read_places(self, spec: MissionSpec) -> None:
        for place in spec.places:
            value: Any = Point(0.0, 0.0, 0.0)
            with self.faults.collecting():
                context = self.context(Scope())
                value = constant_value(place.node, NAMED["point"], context).value()
            self.places[place.name.text] = value

    def _read_parameters(self, spec: MissionSpec, scope: Scope) -> None:
        for named in spec.parameters:
            name, where = named.name.text, named.name.where
            parameter = Parameter(name, ANY)
            with self.faults.collecting():
                parameter = read_parameter(named, self.context(Scope()), self.faults)
            slot = self.slot()
            with self.faults.collecting():
                scope.declare(Binding(name, "parameter", parameter.type, slot, where), where)
            self.parameters[name] = parameter
            self.parameter_slots[name] = slot

    def _read_events(self, spec: MissionSpec) -> None:
        for event in spec.events:
            name, where, node = event.name.text, event.name.where, event.node
            if name in self.events:
                self.faults.fail("name-taken", f"the event '{name}' exists already", where)
            fields: dict[str, Type] = {}
            if isinstance(node, MapNode):
                for key, value in node:
                    fields[key.text] = named_type(value, self.faults) or ANY
            elif not (isinstance(node, Scalar) and node.null):
                self.faults.fail(
                    "wrong-type",
                    "an event is declared by a map of its fields and their types",
                    node.where,
                    f"{name}: {{id: number}}, or {name}: {{}}",
                )
            self.events[name] = fields

    def _collect_raised(self) -> None:
        """Events that behaviours or actions of this mission raise are known everywhere in it."""
        for node in self.tree.nodes:
            if node.invocation:
                self.events.update(node.invocation.behavior.events)
        for spec in self.tree.specs.values():
            for action in _actions(spec):
                found = raised(action)
                if found is not None and found[0] not in self.events:
                    name, fields = found
                    known = self.raised.get(name, {})
                    self.raised[name] = {**known, **dict.fromkeys(fields, ANY)}

    # -- names of each state ----------------------------------------------------------------

    def _declare(self, node: Node, outer: Scope) -> None:
        """Give a state its scope, then those inside it theirs."""
        spec = self.tree.specs[node.index]
        scope = outer.inside(node.entered_slot)
        if node.parent is None:
            scope.states = {other.path: other.index for other in self.tree.nodes if other.path}
        self.scopes[node.index] = scope
        node.data = tuple(self._data(named, scope) for named in spec.data)
        if spec.do is not None:
            self._declare_behavior(node, spec.do, spec.as_, scope)
        for define in spec.define:
            with self.faults.collecting():
                scope.declare(
                    Define(define.name, define.arguments, define.body, scope), define.where
                )
        for child in node.children:
            self._declare(child, scope)

    def _data(self, named: Named, scope: Scope) -> Data:
        name, where = named.name.text, named.name.where
        type_: Type = ANY
        initial = Compiled(ANY, lambda s, e: None, "", where, constant=True)
        with self.faults.collecting():
            type_, initial = self._first_value(named, scope, initial)
        slot = self.slot()
        with self.faults.collecting():
            scope.declare(Binding(name, "data", type_, slot, where), where)
        return Data(name, slot, type_, initial)

    def _first_value(self, named: Named, scope: Scope, nothing: Compiled) -> tuple[Type, Compiled]:
        """The type of a variable and what it begins as."""
        node, context = named.node, self.context(scope)
        if not isinstance(node, MapNode):
            initial = read_value(node, ANY, context)
            return widened(initial.type), initial
        keys = {key.text for key, _ in node}
        if not keys or not keys <= {"type", "default"}:
            raise UserError(
                "wrong-type",
                "a map as first value of a data variable needs the long form",
                node.where,
                "{type: map, default: {…}}",
            )
        declared, default = node.get("type"), node.get("default")
        type_ = (named_type(declared, self.faults) if declared else None) or ANY
        return type_, read_value(default, type_, context) if default else nothing

    def _declare_behavior(self, node: Node, do: Scalar, as_: Scalar | None, scope: Scope) -> None:
        behavior = self.vocabulary.behaviors.get(do.text)
        name = as_ or do
        if behavior is None:
            hint = nearest(do.text, self.vocabulary.behaviors)
            self.faults.fail(
                "unknown-behaviour", f"there is no behaviour '{do.text}'", do.where, hint
            )
            scope.names.setdefault(name.text, Binding(name.text, "published", ANY))
            return
        slot = -1
        if behavior.publishes or behavior.on_trust:
            slot = self.slot()
            type_: Type = ANY if behavior.on_trust else MapOf(behavior.publishes)
            try:
                scope.declare(Binding(name.text, "published", type_, slot, name.where), name.where)
            except UserError as error:
                fault = error.faults[0]
                hint = fault.hint if as_ else "give what it publishes another name: `as: …`"
                self.faults.fail(fault.code, fault.message, fault.where, hint)
        elif as_:
            self.faults.fail(
                "no-values", f"'{behavior.name}' publishes nothing to be named", as_.where
            )
            scope.names.setdefault(name.text, Binding(name.text, "published", ANY))
        node.invocation = Invocation(behavior, {}, {}, slot)


def _actions(spec: StateSpec) -> Iterator[ActionSpec]:
    for block in (spec.entry, spec.exit, spec.throughout):
        yield from block
    for trigger in spec.triggers:
        for alternative in trigger.alternatives:
            yield from alternative.actions
