"""Compiles a mission's spec against its host's vocabulary into a :class:`fsm.graph.Graph`.

Names are resolved, values typed and targets found here; every fault is collected, so that one
check shows them all. What the finished structure must fulfil is tested in :mod:`fsm.checks`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import inf
from types import MappingProxyType
from typing import Any

from fsm import actions
from fsm.checks import check
from fsm.expressions import Compiled, compile_expression
from fsm.functions import EvaluationError
from fsm.graph import After, Data, Edge, Graph, Guard, Invocation, Node, When, entry_set
from fsm.literals import Context, read_value
from fsm.scope import FIRST_HOST_SLOT, TIME_SLOT, Binding, Define, Scope
from fsm.spec import ActionSpec, MissionSpec, Named, StateSpec, TransitionSpec, TriggerSpec
from fsm.types import ANY, BOOL, NAMED, TEXT, ListOf, MapOf, Number, Text, Type
from fsm.vocabulary import Behavior, Parameter, Vocabulary
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Node as YamlNode
from vencejo.nodes import Scalar, Sequence, read_text
from vencejo.units import TIME

PARAMETER_KEYS = frozenset({"type", "default", "min", "max", "choices", "help"})
FAILED_FIELDS: Mapping[str, Type] = MappingProxyType({"reason": TEXT})
ERROR_FIELDS: Mapping[str, Type] = MappingProxyType({"message": TEXT, "where": TEXT})
OWN_EVENTS: Mapping[str, Mapping[str, Type]] = MappingProxyType(
    {"error.execution": ERROR_FIELDS, "error.livelock": ERROR_FIELDS}
)


def compile_mission(spec: MissionSpec, vocabulary: Vocabulary) -> Graph:
    """The graph of a mission. Raises UserError with every fault that would keep it from flying."""
    return _Compiler(spec, vocabulary).compile()


def parse_parameters(graph: Graph, given: Mapping[str, str]) -> dict[str, Any]:
    """Values for a graph's parameters from texts (``-p cruise=6m``), with the defaults of others.

    Raises UserError for unknown names, values that do not fit, and required ones not given.
    """
    faults: list[Fault] = []
    values: dict[str, Any] = {}
    for name, text in given.items():
        place = Where(f"-p {name}")
        parameter = graph.parameters.get(name)
        if parameter is None:
            hint = nearest(name, graph.parameters, None if graph.parameters else "it has none")
            faults.append(
                Fault("unknown-parameter", f"{graph.name} has no parameter '{name}'", place, hint)
            )
            continue
        try:
            node = read_text(f"value: {text}", str(place)).entries[0][1]
            values[name] = read_value(node, parameter.type, Context()).value()
        except UserError as error:
            faults.extend(
                Fault(f.code, f"{name}={text}: {f.message}", place, f.hint) for f in error.faults
            )
        except EvaluationError as error:
            faults.append(Fault("wrong-type", f"{name}={text}: {error}", place))
    for name, parameter in graph.parameters.items():
        if parameter.required and name not in given:
            message = f"the parameter '{name}' has no default and must be given"
            faults.append(Fault("missing-parameter", message, None, f"-p {name}=…"))
        values.setdefault(name, parameter.default)
    if faults:
        raise UserError.of(faults)
    return values


class _Compiler:
    def __init__(self, spec: MissionSpec, vocabulary: Vocabulary) -> None:
        self.spec = spec
        self.vocabulary = vocabulary
        self.faults: list[Fault] = []
        self.slots = FIRST_HOST_SLOT + len(vocabulary.names)
        self.scopes: dict[int, Scope] = {}
        self.specs: dict[int, StateSpec] = {}
        self.nodes: list[Node] = []
        self.parameters: dict[str, Parameter] = {}
        self.parameter_slots: dict[str, int] = {}
        self.places: dict[str, Any] = {}
        self.events: dict[str, Mapping[str, Type]] = {**OWN_EVENTS, **vocabulary.events}

    # -- frame ------------------------------------------------------------------------------

    def compile(self) -> Graph:
        root_scope = self.host_scope()
        self.read_places()
        self.read_parameters(root_scope)
        self.read_events()
        root = self.grow(self.spec.root, None, "")
        paths = {node.path: node.index for node in self.nodes if node.path}
        self.link()
        self.declare(root, root_scope, paths)
        self.collect_raised()
        for node in self.nodes:
            with self.collecting():
                self.fill(node)
        graph = Graph(
            name=self.spec.name,
            description=self.spec.description,
            root=root,
            nodes=tuple(self.nodes),
            parameters=self.parameters,
            parameter_slots=self.parameter_slots,
            vocabulary=self.vocabulary,
            slots=self.slots,
            initial_slots={},
            events=self.events,
            world=self.spec.world.text if self.spec.world else None,
            outer_first=self.spec.outer_first,
            by_path={node.path: node for node in self.nodes},
        )
        if not any(fault.severity == "error" for fault in self.faults):
            self.faults.extend(check(graph))
        errors = [fault for fault in self.faults if fault.severity == "error"]
        if errors:
            raise UserError.of(sorted(errors, key=lambda fault: fault.where or Where("")))
        graph.warnings = tuple(self.faults)
        return graph

    @contextmanager
    def collecting(self) -> Iterator[None]:
        try:
            yield
        except UserError as error:
            self.faults.extend(error.faults)

    def fail(self, code: str, message: str, where: Where | None, hint: str | None = None) -> None:
        self.faults.append(Fault(code, message, where, hint))

    def slot(self) -> int:
        self.slots += 1
        return self.slots - 1

    def context(self, scope: Scope) -> Context:
        return Context(scope, self.places, self.vocabulary.places)

    # -- names of the whole mission ---------------------------------------------------------

    def host_scope(self) -> Scope:
        scope = Scope()
        scope.names["time"] = Binding("time", "host", Number(TIME), TIME_SLOT)
        for index, (name, type_) in enumerate(self.vocabulary.names.items()):
            scope.names[name] = Binding(name, "host", type_, FIRST_HOST_SLOT + index)
        return scope

    def read_places(self) -> None:
        for place in self.spec.places:
            with self.collecting():
                value = read_value(place.node, NAMED["point"], self.context(Scope()))
                self.places[place.name.text] = value.value()

    def read_events(self) -> None:
        for event in self.spec.events:
            if event.name.text in self.events:
                self.fail(
                    "name-taken", f"the event '{event.name.text}' exists already", event.name.where
                )
            fields: dict[str, Type] = {}
            for key, node in event.node.entries if isinstance(event.node, MapNode) else []:
                type_ = self.named_type(node)
                if type_ is not None:
                    fields[key.text] = type_
            self.events[event.name.text] = fields

    def named_type(self, node: YamlNode) -> Type | None:
        if isinstance(node, Scalar) and node.text in NAMED:
            return NAMED[node.text]
        text = node.text if isinstance(node, Scalar) else "this"
        self.fail("unknown-type", f"{text} is no type", node.where, nearest(text, NAMED))
        return None

    def read_parameters(self, scope: Scope) -> None:
        for named in self.spec.parameters:
            with self.collecting():
                parameter = self.parameter(named)
                slot = self.slot()
                where = named.name.where
                scope.declare(
                    Binding(parameter.name, "parameter", parameter.type, slot, where), where
                )
                self.parameters[parameter.name] = parameter
                self.parameter_slots[parameter.name] = slot

    def parameter(self, named: Named) -> Parameter:
        node, name = named.node, named.name.text
        long = isinstance(node, MapNode) and any(key.text in PARAMETER_KEYS for key, _ in node)
        if not (long and isinstance(node, MapNode)):
            compiled = self.constant(node, ANY)
            return Parameter(name, _widened(compiled.type), compiled.value())
        for key, _ in node:
            if key.text not in PARAMETER_KEYS:
                hint = nearest(key.text, PARAMETER_KEYS)
                self.fail("unknown-key", f"a parameter has no '{key.text}'", key.where, hint)
        type_: Type = ANY
        declared, default = node.get("type"), node.get("default")
        if declared is not None:
            type_ = self.named_type(declared) or ANY
        elif default is not None:
            type_ = _widened(self.constant(default, ANY).type)
        help_ = node.get("help")
        type_ = self.bounded(node, type_)
        value = None
        if default is not None:
            try:
                value = self.constant(default, type_).value()
            except UserError as error:
                if error.code == "out-of-range":
                    raise UserError(
                        "default-out-of-range",
                        f"the default of '{name}' lies outside its own bounds: {error.faults[0].message}",
                        default.where,
                    ) from None
                raise
        return Parameter(
            name,
            type_,
            value,
            required=default is None,
            help=help_.text if isinstance(help_, Scalar) else "",
        )

    def bounded(self, node: MapNode, type_: Type) -> Type:
        bounds: dict[str, float] = {}
        for key in ("min", "max"):
            bound = node.get(key)
            if bound is None:
                continue
            if not isinstance(type_, Number):
                self.fail("wrong-type", f"`{key}` needs a number, this is {type_}", bound.where)
                continue
            bounds[key] = float(self.constant(bound, Number(type_.dimension)).value())
        if isinstance(type_, Number):
            low, high = bounds.get("min", -inf), bounds.get("max", inf)
            if low > high:
                self.fail("wrong-bounds", "`min` is larger than `max`", node.where)
            type_ = Number(type_.dimension, low, high)
        choices = node.get("choices")
        if isinstance(choices, Sequence):
            words = tuple(item.text for item in choices.items if isinstance(item, Scalar))
            type_ = Text(words)
        elif choices is not None:
            self.fail("wrong-type", "`choices` is a list of texts", choices.where)
        return type_

    def constant(self, node: YamlNode, type_: Type) -> Compiled:
        compiled = read_value(node, type_, self.context(Scope()))
        if not compiled.constant:
            raise UserError("not-constant", "only a plain value may stand here", node.where)
        return compiled

    # -- the tree ---------------------------------------------------------------------------

    def grow(self, spec: StateSpec, parent: Node | None, path: str) -> Node:
        node = Node(spec.name, path, spec.type, len(self.nodes), spec.where)
        node.parent = parent
        node.ancestors = (parent, *parent.ancestors) if parent else ()
        node.description = spec.description
        node.deep = spec.deep
        node.outcome = spec.outcome
        node.entered_slot = self.slot()
        self.nodes.append(node)
        self.specs[node.index] = spec
        node.children = tuple(
            self.grow(child, node, f"{path}.{child.name}" if path else child.name)
            for child in spec.states
        )
        node.last = len(self.nodes) - 1
        return node

    def link(self) -> None:
        """Initial states and where history goes the first time."""
        for node in self.nodes:
            spec = self.specs[node.index]
            if node.type == "compound":
                node.initial = self.initial(node, spec)
            elif spec.initial:
                self.fail(
                    "misplaced-initial",
                    "only a state with `states` has an initial one",
                    spec.initial.where,
                )
            if node.type == "history":
                with self.collecting():
                    self.link_history(node, spec)

    def initial(self, node: Node, spec: StateSpec) -> tuple[Node, ...]:
        first = next((child for child in node.children if child.type != "history"), None)
        if first is None:
            self.fail("no-states", "only history states are in here", node.where)
            return ()
        if spec.initial is None:
            return (first,)
        found = self.inside(node, spec.initial.text)
        if found is None:
            names = [child.local_name for child in node.children]
            hint = nearest(spec.initial.text, names)
            self.fail(
                "unknown-target",
                f"there is no state '{spec.initial.text}' in here",
                spec.initial.where,
                hint,
            )
            return (first,)
        return (found,)

    def link_history(self, node: Node, spec: StateSpec) -> None:
        parent = node.parent
        assert parent is not None
        if spec.target is None:
            raise UserError(
                "missing-key", "a history state needs a `target` for the first time", node.where
            )
        found = self.inside(parent, spec.target.text)
        if found is None or found.type == "history":
            names = [child.local_name for child in parent.children if child.type != "history"]
            hint = nearest(spec.target.text, names)
            raise UserError(
                "unknown-target",
                f"there is no state '{spec.target.text}' here",
                spec.target.where,
                hint,
            )
        node.initial = (found,)

    def inside(self, node: Node, path: str) -> Node | None:
        found: Node | None = node
        for name in path.split("."):
            found = (
                next((c for c in found.children if c.local_name == name), None) if found else None
            )
        return found

    # -- names of each state ----------------------------------------------------------------

    def declare(self, node: Node, outer: Scope, paths: Mapping[str, int]) -> None:
        """Give a state its scope, then those inside it theirs."""
        spec = self.specs[node.index]
        scope = outer.inside(node.entered_slot)
        if node.parent is None:
            scope.states = paths
        self.scopes[node.index] = scope
        data = []
        for named in spec.data:
            with self.collecting():
                data.append(self.data(named, scope))
        node.data = tuple(data)
        if spec.do is not None:
            with self.collecting():
                self.declare_published(node, spec, scope)
        for define in spec.define:
            with self.collecting():
                scope.declare(
                    Define(define.name, define.arguments, define.body, scope), define.where
                )
        for child in node.children:
            self.declare(child, scope, paths)

    def data(self, named: Named, scope: Scope) -> Data:
        node, where = named.node, named.name.where
        type_: Type = ANY
        if isinstance(node, MapNode):
            keys = {key.text for key, _ in node}
            if not keys or not keys <= {"type", "default"}:
                raise UserError(
                    "wrong-type",
                    "a map as first value of a data variable needs the long form",
                    node.where,
                    "{type: map, default: {…}}",
                )
            declared, default = node.get("type"), node.get("default")
            type_ = (self.named_type(declared) if declared else None) or ANY
            initial = (
                read_value(default, type_, self.context(scope))
                if default
                else Compiled(type_, lambda s, e: None, "", node.where, constant=True)
            )
        else:
            initial = read_value(node, ANY, self.context(scope))
            type_ = _widened(initial.type)
        slot = self.slot()
        scope.declare(Binding(named.name.text, "data", type_, slot, where), where)
        return Data(named.name.text, slot, type_, initial)

    def behavior(self, spec: StateSpec) -> Behavior | None:
        return self.vocabulary.behaviors.get(spec.do.text) if spec.do else None

    def declare_published(self, node: Node, spec: StateSpec, scope: Scope) -> None:
        behavior = self.behavior(spec)
        assert spec.do is not None
        if behavior is None:
            raise UserError(
                "unknown-behaviour",
                f"there is no behaviour '{spec.do.text}'",
                spec.do.where,
                nearest(spec.do.text, self.vocabulary.behaviors),
            )
        slot = -1
        if behavior.publishes:
            name = spec.as_ or spec.do
            slot = self.slot()
            binding = Binding(name.text, "published", MapOf(behavior.publishes), slot, name.where)
            try:
                scope.declare(binding, name.where)
            except UserError as error:
                fault = error.faults[0]
                hint = fault.hint if spec.as_ else "give what it publishes another name: `as: …`"
                raise UserError(fault.code, fault.message, fault.where, hint) from None
        elif spec.as_:
            raise UserError(
                "no-values", f"'{behavior.name}' publishes nothing to be named", spec.as_.where
            )
        node.invocation = Invocation(behavior, {}, {}, slot)

    def collect_raised(self) -> None:
        """Events that behaviours or actions of this graph raise are known everywhere in it."""
        for node in self.nodes:
            if node.invocation:
                self.events.update(node.invocation.behavior.events)
        for spec in self.specs.values():
            for block in _blocks(spec):
                for action in block:
                    name = actions.raised(action)
                    if name:
                        self.events.setdefault(name, {})

    # -- what stands in each state ----------------------------------------------------------

    def fill(self, node: Node) -> None:
        spec, scope = self.specs[node.index], self.scopes[node.index]
        node.entry = self.actions(spec.entry, scope)
        node.exit_actions = self.actions(spec.exit, scope)
        node.throughout = self.actions(spec.throughout, scope)
        if node.invocation:
            self.invocation(node, spec, scope)
        for define in spec.define:
            if not define.arguments:
                with self.collecting():
                    compile_expression(define.body.text, _start(define.body), scope)
        output = {}
        for named in spec.output:
            with self.collecting():
                output[named.name.text] = read_value(named.node, ANY, self.context(scope))
        node.output = output
        on: list[tuple[str, tuple[Edge, ...]]] = []
        whens: list[When] = []
        afters: list[After] = []
        always: list[Edge] = []
        for trigger in spec.triggers:
            with self.collecting():
                match trigger.kind:
                    case "on":
                        event = self.event_scope(node, trigger, scope)
                        on.append((trigger.key.text, self.edges(node, trigger, event)))
                    case "when":
                        text, where = trigger.key.text, _start(trigger.key)
                        condition = compile_expression(text, where, scope, BOOL)
                        whens.append(When(condition, self.edges(node, trigger, scope)))
                    case "after":
                        text, where = trigger.key.text, _start(trigger.key)
                        duration = compile_expression(text, where, scope, Number(TIME))
                        afters.append(After(duration, self.edges(node, trigger, scope)))
                    case "always":
                        always.extend(self.edges(node, trigger, scope))
        node.on, node.whens = tuple(on), tuple(whens)
        node.afters, node.always = tuple(afters), tuple(always)

    def event_scope(self, node: Node, trigger: TriggerSpec, scope: Scope) -> Scope:
        name, where = trigger.key.text, trigger.key.where
        if name == "*" or name.endswith(".*"):
            family = name[:-1]
            if name != "*" and not any(event.startswith(family) for event in self.events):
                families = {event.split(".")[0] + ".*" for event in self.events}
                raise UserError(
                    "unknown-event",
                    f"no event begins with '{family}'",
                    where,
                    nearest(name, families),
                )
            return scope.with_event(MapOf())
        if "." in name:
            if name not in self.events:
                raise UserError(
                    "unknown-event",
                    f"there is no event '{name}'",
                    where,
                    nearest(name, self.events),
                )
            return scope.with_event(MapOf(self.events[name]))
        outcomes = self.outcomes(node)
        if name not in outcomes:
            event = next((e for e in self.events if e.replace(".", "_") == name), None)
            raise UserError(
                "unknown-outcome",
                f"nothing in this state ends with the outcome '{name}'",
                where,
                f"did you mean the event '{event}'?" if event else nearest(name, outcomes),
            )
        fields = outcomes[name]
        return scope.with_event(MapOf(fields))

    def outcomes(self, node: Node) -> dict[str, Mapping[str, Type] | None]:
        """Every outcome that can be offered to a state; None for fields not known before."""
        found: dict[str, Mapping[str, Type] | None] = {}
        if node.type == "parallel":
            found["done"] = {}
        for inner in self.nodes[node.index : node.last + 1]:
            if inner.invocation:
                found["failed"] = FAILED_FIELDS
                for word, fields in inner.invocation.behavior.outcomes.items():
                    if word != "done" or inner is node:
                        found[word] = fields
            if inner.type == "final" and (inner.outcome != "done" or inner.parent is node):
                found[inner.outcome] = None
        return found

    def invocation(self, node: Node, spec: StateSpec, scope: Scope) -> None:
        invocation = node.invocation
        assert invocation is not None and spec.do is not None
        behavior = invocation.behavior
        context = self.context(scope)
        values: dict[str, dict[str, Compiled]] = {"with": {}, "live": {}}
        for key, entries in (("with", spec.with_), ("live", spec.live)):
            for named in entries:
                parameter = behavior.parameters.get(named.name.text)
                if parameter is None:
                    self.fail(
                        "unknown-parameter",
                        f"'{behavior.name}' has no parameter '{named.name.text}'",
                        named.name.where,
                        nearest(named.name.text, behavior.parameters),
                    )
                    continue
                if key == "live" and not parameter.live:
                    hint = "write it under `with`"
                    self.fail(
                        "not-live",
                        f"'{parameter.name}' cannot change in flight",
                        named.name.where,
                        hint,
                    )
                with self.collecting():
                    values[key][parameter.name] = read_value(named.node, parameter.type, context)
        for parameter in behavior.parameters.values():
            given = any(n.name.text == parameter.name for n in (*spec.with_, *spec.live))
            if parameter.required and not given:
                self.fail(
                    "missing-parameter",
                    f"'{behavior.name}' needs the parameter '{parameter.name}' ({parameter.type})",
                    spec.do.where,
                    f"with: {{{parameter.name}: …}}",
                )
        node.invocation = Invocation(behavior, values["with"], values["live"], invocation.slot)

    def actions(self, specs: tuple[ActionSpec, ...], scope: Scope) -> tuple[Any, ...]:
        found = []
        for spec in specs:
            with self.collecting():
                found.append(actions.compile_action(spec, self.context(scope), self.events))
        return tuple(found)

    def edges(self, node: Node, trigger: TriggerSpec, scope: Scope) -> tuple[Edge, ...]:
        found = []
        for spec in trigger.alternatives:
            with self.collecting():
                found.append(self.edge(node, trigger, spec, scope))
        return tuple(found)

    def edge(self, node: Node, trigger: TriggerSpec, spec: TransitionSpec, scope: Scope) -> Edge:
        edge = Edge(node, trigger.kind, trigger.key.text, spec.where, spec.name)
        edge.reenter = spec.reenter
        if spec.guard:
            edge.guard = compile_expression(spec.guard.text, _start(spec.guard), scope, BOOL)
            edge.conditions.append(Guard(edge.guard))
        if spec.hold:
            edge.hold = compile_expression(spec.hold.text, _start(spec.hold), scope, Number(TIME))
        edge.actions = self.actions(spec.actions, scope)
        edge.targets = tuple(self.target(node, target) for target in spec.targets)
        if edge.targets:
            edge.dest = ", ".join(target.path for target in edge.targets)
            edge.domain = _domain(node, edge.targets, spec.reenter)
            if not _through_history(edge.domain, edge.targets):
                edge.entered = tuple(entry_set(edge.domain, edge.targets, lambda history: ()))
            else:
                edge.entered = None
        return edge

    def target(self, source: Node, scalar: Scalar) -> Node:
        """The state of a name: among the children, then the siblings, then outwards."""
        first, _, rest = scalar.text.partition(".")
        place: Node | None = source
        while place is not None:
            found = next((child for child in place.children if child.local_name == first), None)
            if found is not None:
                target = self.inside(found, rest) if rest else found
                if target is None:
                    raise UserError(
                        "unknown-target",
                        f"there is no state '{rest}' in '{found.path}'",
                        scalar.where,
                        nearest(rest, [child.local_name for child in found.children]),
                    )
                return target
            place = place.parent
        visible = {
            child.local_name for node in (source, *source.ancestors) for child in node.children
        }
        raise UserError(
            "unknown-target",
            f"there is no state '{scalar.text}' to go to",
            scalar.where,
            nearest(scalar.text, visible),
        )


def _start(scalar: Scalar) -> Where:
    """Where the text itself begins, past its quote."""
    return scalar.where.right(0 if scalar.plain else 1)


def _widened(type_: Type) -> Type:
    """The type of a variable from the type of its first value."""
    if isinstance(type_, Number):
        return Number(type_.dimension)
    if isinstance(type_, Text):
        return TEXT
    if isinstance(type_, ListOf):
        return ListOf(_widened(type_.item), type_.named)
    return type_


def _domain(source: Node, targets: tuple[Node, ...], reenter: bool) -> Node:
    """The state whose inside a transition leaves: SCXML's LCCA, or the source it stays within."""
    within = all(source.contains(target) for target in targets)
    if within and source.parent is None:
        return source
    if within and not reenter and source.type == "compound":
        return source
    for ancestor in source.ancestors:
        if ancestor.type == "compound" and all(ancestor.contains(target) for target in targets):
            return ancestor
    return source.ancestors[-1]


def _through_history(domain: Node, targets: tuple[Node, ...]) -> bool:
    """Whether history decides what is entered: then the entry set is found in flight."""
    found = entry_set(domain, targets, lambda history: ())
    touched = {*targets, *(initial for node in found for initial in node.initial)}
    return any(node.type == "history" for node in touched)


def _blocks(spec: StateSpec) -> Iterator[tuple[ActionSpec, ...]]:
    yield from (spec.entry, spec.exit, spec.throughout)
    for trigger in spec.triggers:
        for alternative in trigger.alternatives:
            yield alternative.actions
