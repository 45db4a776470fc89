"""Compiles a mission's spec against its host's vocabulary into a :class:`fsm.graph.Graph`.

States come from :mod:`fsm.tree`, names from :mod:`fsm.declarations`; what stands in each state is
compiled here. Every fault is collected, so that one check shows them all. What the finished
structure must fulfil is tested in :mod:`fsm.checks`.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from itertools import combinations

from fsm import actions
from fsm.checks import check
from fsm.declarations import FAILED_FIELDS, Declarations, Fields
from fsm.expressions import Compiled, compile_expression
from fsm.faults import Faults
from fsm.graph import Action, After, Edge, Graph, Guard, Invocation, Node, When, entry_set
from fsm.literals import read_value
from fsm.parameters import parse_parameters
from fsm.scope import FIRST_HOST_SLOT, Scope, start
from fsm.spec import ActionSpec, DefineSpec, MissionSpec, StateSpec, TransitionSpec, TriggerSpec
from fsm.tree import Tree, domain_of, through_history
from fsm.types import ANY, BOOL, MapOf, Number
from fsm.unused import unused
from fsm.vocabulary import Behavior, Parameter, Vocabulary
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.units import TIME

__all__ = ["compile_mission", "parse_parameters"]


def compile_mission(
    spec: MissionSpec, vocabulary: Vocabulary, found: Iterable[Fault] = ()
) -> Graph:
    """The graph of a mission. Raises UserError with every fault that would keep it from flying.

    ``found`` are the faults found in it before; they are reported with the others.
    """
    faults = Faults(found)
    tree = Tree(spec.root, FIRST_HOST_SLOT + len(vocabulary.names), faults)
    names = Declarations(spec, vocabulary, tree, faults)
    compiler = _Compiler(tree, names, faults)
    for node in tree.nodes:
        compiler.fill(node)
    graph = Graph(
        name=spec.name,
        description=spec.description,
        root=tree.root,
        nodes=tuple(tree.nodes),
        parameters=names.parameters,
        parameter_slots=names.parameter_slots,
        vocabulary=vocabulary,
        slots=names.slots,
        events={**names.raised, **names.events},
        world=spec.world.text if spec.world else None,
        outer_first=spec.outer_first,
        by_path={node.path: node for node in tree.nodes},
    )
    faults.extend(check(graph, whole=all(fault.severity == "warning" for fault in faults)))
    # A define's mistake shows at each of its uses, always at the same place.
    ordered = sorted(dict.fromkeys(faults), key=lambda fault: fault.where or Where(""))
    ordered.sort(key=lambda fault: fault.severity)
    if ordered and ordered[0].severity == "error":
        raise UserError.of(ordered)
    graph.warnings = (*ordered, *unused(spec))
    return graph


class _Compiler:
    """Compiles what stands in each state."""

    def __init__(self, tree: Tree, names: Declarations, faults: Faults) -> None:
        self.tree = tree
        self.names = names
        self.faults = faults
        self.vocabulary = names.vocabulary
        self.events = {**names.raised, **names.events}
        self.trusting = any(n.invocation and n.invocation.behavior.on_trust for n in tree.nodes)

    # -- what stands in each state ----------------------------------------------------------

    def fill(self, node: Node) -> None:
        spec, scope = self.tree.specs[node.index], self.names.scopes[node.index]
        node.entry = self.actions(spec.entry, scope)
        node.exit_actions = self.actions(spec.exit, scope)
        node.throughout = self.actions(spec.throughout, scope)
        if node.invocation:
            self.invocation(node, spec, scope)
        for define in spec.define:
            with self.faults.collecting():
                self.define(define, scope)
        output = {}
        for named in spec.output:
            with self.faults.collecting():
                output[named.name.text] = read_value(named.node, ANY, self.names.context(scope))
        node.output = output
        on: list[tuple[str, tuple[Edge, ...]]] = []
        whens: list[When] = []
        afters: list[After] = []
        always: list[Edge] = []
        for trigger in spec.triggers:
            with self.faults.collecting():
                match trigger.kind:
                    case "on":
                        event = self.event_scope(node, trigger, scope)
                        on.append((trigger.key.text, self.edges(node, trigger, event)))
                    case "when":
                        text, where = trigger.key.text, start(trigger.key)
                        condition = compile_expression(text, where, scope, BOOL)
                        whens.append(When(condition, self.edges(node, trigger, scope)))
                    case "after":
                        text, where = trigger.key.text, start(trigger.key)
                        duration = compile_expression(text, where, scope, Number(TIME))
                        afters.append(After(duration, self.edges(node, trigger, scope)))
                    case "always":
                        always.extend(self.edges(node, trigger, scope))
        node.on, node.whens = tuple(on), tuple(whens)
        node.afters, node.always = tuple(afters), tuple(always)

    def define(self, define: DefineSpec, scope: Scope) -> None:
        """A define is compiled once by itself, so that one nobody uses is checked too."""
        for argument in define.arguments:
            if scope.find(argument) is not None:
                raise UserError(
                    "name-taken",
                    f"the name '{argument}' is visible here already",
                    define.where,
                    "choose another for the argument",
                )
        arguments = dict.fromkeys(define.arguments, ANY)
        compile_expression(define.body.text, start(define.body), scope, arguments=arguments)

    def event_scope(self, node: Node, trigger: TriggerSpec, scope: Scope) -> Scope:
        name, where = trigger.key.text, trigger.key.where
        if name == "*" or name.endswith(".*"):
            family = name[:-1]
            if name != "*" and not any(event.startswith(family) for event in self.names.events):
                if self.trusting:
                    return scope.with_event(MapOf())
                families = {event.split(".")[0] + ".*" for event in self.events}
                raise UserError(
                    "unknown-event",
                    f"no event begins with '{family}'",
                    where,
                    nearest(name, families),
                )
            return scope.with_event(MapOf())
        if "." in name:
            if name not in self.events and self.trusting:
                return scope.with_event(MapOf())
            if name not in self.events:
                raise UserError(
                    "unknown-event",
                    f"there is no event '{name}'",
                    where,
                    nearest(name, self.events),
                )
            return scope.with_event(MapOf(self.events[name]))
        outcomes = self.outcomes(node)
        if outcomes is None:
            return scope.with_event(MapOf())
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

    def outcomes(self, node: Node) -> dict[str, Fields | None] | None:
        """Every outcome that can be offered to a state, with its fields where they are known.

        None when a behaviour inside is unknown: then any may be.
        """
        found: dict[str, list[Fields | None]] = {}
        if node.type == "parallel":
            found["done"] = [{}]
        for inner in self.tree.nodes[node.index : node.last + 1]:
            if inner.invocation and inner.invocation.behavior.on_trust:
                return None
            if inner.invocation:
                outcomes = {**inner.invocation.behavior.outcomes, "failed": FAILED_FIELDS}
                for word, fields in outcomes.items():
                    if word != "done" or inner is node:
                        found.setdefault(word, []).append(fields)
            elif self.tree.specs[inner.index].do is not None:
                return None
            if inner.type == "final" and (inner.outcome != "done" or inner.parent is node):
                found.setdefault(inner.outcome, []).append(None)
        return {word: _common(fields) for word, fields in found.items()}

    def invocation(self, node: Node, spec: StateSpec, scope: Scope) -> None:
        invocation = node.invocation
        assert invocation is not None and spec.do is not None
        behavior = invocation.behavior
        context = self.names.context(scope)
        values: dict[str, dict[str, Compiled]] = {"with": {}, "live": {}}
        for key, entries in (("with", spec.with_), ("live", spec.live)):
            for named in entries:
                parameter = behavior.parameters.get(named.name.text)
                if behavior.on_trust:
                    parameter = Parameter(named.name.text, ANY, live=True)
                if parameter is None:
                    self.faults.fail(
                        "unknown-parameter",
                        f"'{behavior.name}' has no parameter '{named.name.text}'",
                        named.name.where,
                        nearest(named.name.text, behavior.parameters),
                    )
                    continue
                if key == "live" and not parameter.live:
                    hint = "write it under `with`"
                    self.faults.fail(
                        "not-live",
                        f"'{parameter.name}' cannot change in flight",
                        named.name.where,
                        hint,
                    )
                with self.faults.collecting():
                    values[key][parameter.name] = read_value(named.node, parameter.type, context)
        self.required(behavior, spec)
        node.invocation = Invocation(behavior, values["with"], values["live"], invocation.slot)

    def required(self, behavior: Behavior, spec: StateSpec) -> None:
        assert spec.do is not None
        given = {named.name.text for named in (*spec.with_, *spec.live)}
        misspelt = given - set(behavior.parameters)
        for parameter in behavior.parameters.values():
            # One whose name was misspelt is reported already.
            if (
                parameter.required
                and parameter.name not in given
                and not get_close_matches(parameter.name, misspelt)
            ):
                self.faults.fail(
                    "missing-parameter",
                    f"'{behavior.name}' needs the parameter '{parameter.name}' ({parameter.type})",
                    spec.do.where,
                    f"with: {{{parameter.name}: …}}",
                )

    def actions(self, specs: tuple[ActionSpec, ...], scope: Scope) -> tuple[Action, ...]:
        found: list[Action] = []
        for spec in specs:
            with self.faults.collecting():
                found.append(
                    actions.compile_action(spec, self.names.context(scope), self.names.events)
                )
        return tuple(found)

    def edges(self, node: Node, trigger: TriggerSpec, scope: Scope) -> tuple[Edge, ...]:
        found = []
        for spec in trigger.alternatives:
            with self.faults.collecting():
                found.append(self.edge(node, trigger, spec, scope))
        return tuple(found)

    def edge(self, node: Node, trigger: TriggerSpec, spec: TransitionSpec, scope: Scope) -> Edge:
        edge = Edge(node, trigger.kind, trigger.key.text, spec.where, spec.name)
        edge.reenter = spec.reenter
        if spec.guard:
            edge.guard = compile_expression(spec.guard.text, start(spec.guard), scope, BOOL)
            edge.conditions.append(Guard(edge.guard))
        if spec.hold:
            edge.hold = compile_expression(spec.hold.text, start(spec.hold), scope, Number(TIME))
        edge.actions = self.actions(spec.actions, scope)
        edge.targets = self.targets(node, spec)
        if edge.targets:
            edge.dest = ", ".join(target.path for target in edge.targets)
            edge.domain = domain_of(node, edge.targets, spec.reenter)
            if not through_history(edge.domain, edge.targets):
                edge.entered = tuple(entry_set(edge.domain, edge.targets, lambda history: ()))
            else:
                edge.entered = None
        return edge

    def targets(self, node: Node, spec: TransitionSpec) -> tuple[Node, ...]:
        targets = tuple(self.tree.target(node, target) for target in spec.targets)
        for (one, a), (two, b) in combinations(zip(spec.targets, targets, strict=True), 2):
            common = next(place for place in (a, *a.ancestors) if place in (b, *b.ancestors))
            if common.type != "parallel" or common in (a, b):
                raise UserError(
                    "conflicting-targets",
                    f"'{one.text}' and '{two.text}' cannot be entered together",
                    two.where,
                    "several targets lie in different regions of one parallel state; "
                    "alternatives are a list of transitions",
                )
        return targets


def _common(known: list[Fields | None]) -> Fields | None:
    """The fields that an outcome has whoever ends with it."""
    fields = [entry for entry in known if entry is not None]
    if len(fields) < len(known):
        return None
    return {name: type_ for name, type_ in fields[0].items() if all(name in f for f in fields)}
