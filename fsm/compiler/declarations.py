"""The names that a mission declares: their scopes, their types and their slots.

A name that is declared wrongly stays known, with an unknown type: one mistake makes one fault.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fsm.chart.draft import StateDraft
from fsm.chart.executable import Data, Invocation
from fsm.compiler.actions import raised
from fsm.compiler.namespace import OWN_EVENTS, Namespace
from fsm.compiler.parameters import constant_value, named_type, read_parameter, widened
from fsm.compiler.tree import Tree
from fsm.expressions.compiled import Compiled
from fsm.expressions.literals import Context, read_value
from fsm.expressions.scope import (
    FIRST_HOST_SLOT,
    PERIOD_SLOT,
    TIME_SLOT,
    Binding,
    Define,
    Scope,
    Size,
)
from fsm.faults import Faults
from fsm.host import Parameter, Vocabulary
from fsm.language.spec import ActionSpec, MissionSpec, Named, StateSpec
from fsm.values.types import ANY, NAMED, MapOf, Number, Type
from vencejo.errors import UserError, Where, nearest
from vencejo.geometry import Point
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar
from vencejo.units import TIME


class Declarations:
    """The declarations of a mission and of the graphs that it includes."""

    def __init__(self, vocabulary: Vocabulary, tree: Tree, faults: Faults) -> None:
        self.vocabulary = vocabulary
        self.tree = tree
        self.faults = faults
        self.first_slot = FIRST_HOST_SLOT + len(vocabulary.names)
        """The first of the slots that hold the states' times of entry, in document order."""
        self.slots = self.first_slot + len(tree.states)
        self.scopes: list[Scope] = []
        """The scope of each state, by its index."""
        self.graphs: dict[int, Namespace] = {}
        """The namespace of each graph, by the index of its root."""
        self.host_fields: dict[str, Where] = {}
        """See Scope."""
        self._size = Size()
        self._names: list[Namespace] = []
        """The namespace of each state, by its index."""
        self._declare_graph(tree.root)
        for index in reversed(self.graphs):
            self._collect_raised(tree.states[index])

    def of(self, state: StateDraft) -> Namespace:
        """The namespace of the graph that a state belongs to."""
        return self._names[state.index]

    def slot(self) -> int:
        """Reserve the next free slot."""
        self.slots += 1
        return self.slots - 1

    # -- names of a whole graph -------------------------------------------------------------

    def _declare_graph(self, root: StateDraft) -> None:
        """Declare the names that all states of a graph see, then those of each state."""
        spec = self.tree.graphs[root.index]
        names = self.graphs[root.index] = Namespace(self.vocabulary)
        names.events.update({**OWN_EVENTS, **self.vocabulary.events})
        self._read_places(spec, names)
        scope = self._host_scope()
        scope.states = self._states(root)
        self._read_parameters(spec, names, scope)
        self._read_events(spec, names)
        self._declare(root, names, scope)

    def _states(self, root: StateDraft) -> dict[str, int]:
        """The states of a graph by the paths that ``active('…')`` uses in it."""
        around = root.owner.path + "." if root.owner.path else ""
        inside = self.tree.states[root.index + 1 : root.last + 1]
        return {state.path.removeprefix(around): state.index for state in inside}

    def _host_scope(self) -> Scope:
        scope = Scope(warnings=self.faults, size=self._size, host_fields=self.host_fields)
        scope.names["time"] = Binding("time", "host", Number(TIME), TIME_SLOT)
        scope.names["dt"] = Binding("dt", "host", Number(TIME), PERIOD_SLOT)
        for index, (name, type_) in enumerate(self.vocabulary.names.items()):
            scope.names[name] = Binding(name, "host", type_, FIRST_HOST_SLOT + index)
        return scope

    def _read_places(self, spec: MissionSpec, names: Namespace) -> None:
        for place in spec.places:
            value: Any = Point(0.0, 0.0, 0.0)
            with self.faults.collecting():
                context = names.context(Scope(warnings=self.faults))
                value = constant_value(place.node, NAMED["point"], context).value()
            names.places[place.name.text] = value

    def _read_parameters(self, spec: MissionSpec, names: Namespace, scope: Scope) -> None:
        for named in spec.parameters:
            name, where = named.name.text, named.name.where
            parameter = Parameter(name, ANY)
            with self.faults.collecting():
                context = names.context(Scope(warnings=self.faults))
                parameter = read_parameter(named, context, self.faults)
            slot = self.slot()
            with self.faults.collecting():
                scope.declare(Binding(name, "parameter", parameter.type, slot, where), where)
            names.parameters[name] = parameter
            names.parameter_slots[name] = slot

    def _read_events(self, spec: MissionSpec, names: Namespace) -> None:
        for event in spec.events:
            name, where, node = event.name.text, event.name.where, event.node
            if name in names.events:
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
            names.events[name] = fields

    def _collect_raised(self, root: StateDraft) -> None:
        """Make the events that behaviours and actions of a graph raise known in all of it."""
        names = self.graphs[root.index]
        for state in self.tree.states[root.index : root.last + 1]:
            if self.of(state) is not names:
                continue
            if state.invocation:
                names.events.update(state.invocation.behavior.events)
            for action in _actions(self.tree.specs[state.index]):
                found = raised(action)
                if found is not None and found[0] not in names.events:
                    name, fields = found
                    known = names.raised.get(name, {})
                    names.raised[name] = {**known, **dict.fromkeys(fields, ANY)}
        if root.parent is not None:
            names.climb_to(self.of(root.parent))

    # -- names of each state ----------------------------------------------------------------

    def _declare(self, state: StateDraft, names: Namespace, outer: Scope) -> None:
        """Declare the names of a state, then those of the states inside it."""
        spec = self.tree.specs[state.index]
        scope = outer.inside(self.first_slot + state.index)
        self.scopes.append(scope)
        self._names.append(names)
        state.data = tuple([self._data(named, scope, names) for named in spec.data])
        if spec.do is not None:
            self._declare_behavior(state, spec.do, spec.as_, scope)
        for define in spec.define:
            with self.faults.collecting():
                scope.declare(
                    Define(define.name, define.arguments, define.body, scope), define.where
                )
        for child in state.children:
            if child.border:
                self._declare_graph(child)
            else:
                self._declare(child, names, scope)

    def _data(self, named: Named, scope: Scope, names: Namespace) -> Data:
        name, where = named.name.text, named.name.where
        type_: Type = ANY
        initial = Compiled(ANY, lambda s, e: None, "", where, constant=True)
        with self.faults.collecting():
            type_, initial = self._first_value(named, names.context(scope), initial)
        slot = self.slot()
        with self.faults.collecting():
            scope.declare(Binding(name, "data", type_, slot, where), where)
        return Data(name, slot, type_, initial)

    def _first_value(
        self, named: Named, context: Context, nothing: Compiled
    ) -> tuple[Type, Compiled]:
        """The type of a variable and its first value."""
        node = named.node
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

    def _declare_behavior(
        self, state: StateDraft, do: Scalar, as_: Scalar | None, scope: Scope
    ) -> None:
        """Give a state its behaviour, and a name to the values that it publishes."""
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
        state.invocation = Invocation(behavior, {}, {}, slot)


def _actions(spec: StateSpec) -> Iterator[ActionSpec]:
    for block in (spec.entry, spec.exit, spec.throughout):
        yield from block
    for trigger in spec.triggers:
        for alternative in trigger.alternatives:
            yield from alternative.actions
