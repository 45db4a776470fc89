"""Compiles a mission's spec against its host's vocabulary into a :class:`fsm.chart.graph.Graph`.

States come from :mod:`fsm.compiler.tree`, names from :mod:`fsm.compiler.declarations`; what
stands in each state is compiled here. Every fault is collected, so that one check shows them all.
What the finished structure must fulfil is tested in :mod:`fsm.checks.mission`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from difflib import get_close_matches
from itertools import combinations

from fsm.chart.graph import Action, After, Edge, Given, Graph, Guard, Invocation, Node, When
from fsm.checks.mission import check
from fsm.compiler import actions
from fsm.compiler.declarations import Declarations
from fsm.compiler.namespace import FAILED_FIELDS, Fields
from fsm.compiler.parameters import parse_parameters
from fsm.compiler.tree import Tree, domain_of
from fsm.compiler.unused import unused
from fsm.expressions.compiled import Compiled, compile_expression
from fsm.expressions.literals import read_value
from fsm.expressions.scope import FIRST_HOST_SLOT, Scope, start
from fsm.faults import Faults
from fsm.host import Parameter, Vocabulary
from fsm.language.spec import (
    ActionSpec,
    DefineSpec,
    MissionSpec,
    StateSpec,
    TransitionSpec,
    TriggerSpec,
)
from fsm.values.types import ANY, BOOL, MapOf, Number
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.nodes import Scalar
from vencejo.units import TIME

__all__ = ["compile_mission", "parse_parameters"]


def compile_mission(
    spec: MissionSpec, vocabulary: Vocabulary, found: Iterable[Fault] = ()
) -> Graph:
    """The graph of a mission. Raises UserError with every fault that would keep it from flying.

    ``found`` are the faults found in it before; they are reported with the others.
    """
    faults = Faults(found)
    tree = Tree(spec, FIRST_HOST_SLOT + len(vocabulary.names), faults)
    names = Declarations(vocabulary, tree, faults)
    own = names.of(tree.root)
    compiler = _Compiler(tree, names, faults)
    for node in tree.nodes:
        compiler.fill(node)
    graph = Graph(
        name=spec.name,
        description=spec.description,
        root=tree.root,
        nodes=tuple(tree.nodes),
        parameters=own.parameters,
        parameter_slots=own.parameter_slots,
        vocabulary=vocabulary,
        slots=names.slots,
        events=own.known_events,
        world=spec.world.text if spec.world else None,
        outer_first=spec.outer_first,
        by_path={node.path: node for node in tree.nodes},
        source=spec,
    )
    faults.extend(check(graph, compiler.flawed))
    # A define's mistake shows at each of its uses, always at the same place.
    ordered = sorted(dict.fromkeys(faults), key=lambda fault: fault.where or Where(""))
    ordered.sort(key=lambda fault: fault.severity)
    if ordered and ordered[0].severity == "error":
        raise UserError.of(ordered)
    return replace(graph, warnings=(*ordered, *unused(spec)))


class _Compiler:
    """Compiles what stands in each state."""

    def __init__(self, tree: Tree, names: Declarations, faults: Faults) -> None:
        self.tree = tree
        self.names = names
        self.faults = faults
        self.vocabulary = names.vocabulary
        self.own = names.of(tree.root)
        """The names of the graph whose states are being filled."""
        self.events = self.own.known_events
        self.flawed: set[Node] = set()
        """States with transitions or children that could not be compiled."""
        self.trusting = any(n.invocation and n.invocation.behavior.on_trust for n in tree.nodes)

    # -- what stands in each state ----------------------------------------------------------

    def fill(self, node: Node) -> None:
        spec, scope = self.tree.specs[node.index], self.names.scopes[node.index]
        if self.names.of(node) is not self.own:
            self.own = self.names.of(node)
            self.events = self.own.known_events
        node.entry = self.actions(spec.entry, scope)
        node.exit_actions = self.actions(spec.exit, scope)
        node.throughout = self.actions(spec.throughout, scope)
        if node.invocation:
            self.invocation(node, spec, scope)
        elif spec.do:
            # Unknown, and that is told; what it is given may be wrong too.
            self.given(spec.do.text, {}, spec, spec.do, scope, trusted=True)
        if spec.include:
            self.include(node, spec, spec.include, scope)
        for define in spec.define:
            with self.faults.collecting():
                self.define(define, scope)
        output = {}
        for named in spec.output:
            with self.faults.collecting():
                output[named.name.text] = read_value(named.node, ANY, self.own.context(scope))
        node.output = output
        on: list[tuple[str, tuple[Edge, ...]]] = []
        whens: list[When] = []
        afters: list[After] = []
        always: list[Edge] = []
        before = self.faults.errors
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
        if spec.flawed or self.faults.errors > before or self.tree.lacks(node):
            self.flawed.add(node)

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
            if name != "*" and not any(event.startswith(family) for event in self.own.events):
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
        if node.type == "parallel" and node.owner is node:
            found["done"] = [{}]
        for inner in self.tree.nodes[node.index : node.last + 1]:
            same = self.names.of(inner) is self.own
            if inner.invocation and inner.invocation.behavior.on_trust:
                return None
            if inner.invocation:
                outcomes = {**inner.invocation.behavior.outcomes, "failed": FAILED_FIELDS}
                for word, fields in outcomes.items():
                    # Of what an included graph goes through, only `failed` climbs out of it.
                    if word == "failed" or (same and (word != "done" or inner is node)):
                        found.setdefault(word, []).append(fields)
            elif self.tree.specs[inner.index].do is not None or self.tree.lacks(inner):
                return None
            if inner.type == "final" and inner.parent:
                owner, spec = inner.parent.owner, self.tree.specs[inner.index]
                if self.names.of(owner) is self.own and (inner.outcome != "done" or owner is node):
                    output = {named.name.text: ANY for named in spec.output}
                    found.setdefault(inner.outcome, []).append(output)
            if inner.type == "parallel" and inner.owner is node:
                found.setdefault("done", []).append({})
            if self.tree.specs[inner.index].include and same:
                found.setdefault("failed", []).append(FAILED_FIELDS)
        return {word: _common(fields) for word, fields in found.items()}

    def invocation(self, node: Node, spec: StateSpec, scope: Scope) -> None:
        invocation = node.invocation
        assert invocation is not None and spec.do is not None
        behavior = invocation.behavior
        values = self.given(
            behavior.name, behavior.parameters, spec, spec.do, scope, behavior.on_trust
        )
        for named in spec.live:
            parameter = behavior.parameters.get(named.name.text)
            if parameter is not None and not parameter.live:
                self.faults.fail(
                    "not-live",
                    f"'{parameter.name}' cannot change in flight",
                    named.name.where,
                    "write it under `with`",
                )
        node.invocation = Invocation(behavior, values["with"], values["live"], invocation.slot)

    def include(self, node: Node, spec: StateSpec, word: Scalar, scope: Scope) -> None:
        """The parameters of an included graph, from the state that includes it."""
        if not node.children:
            # It was not found, and that is told; what it is given may be wrong too.
            self.given(word.text, {}, spec, word, scope, trusted=True)
            return
        (root,) = node.children
        names = self.names.of(root)
        values = self.given(word.text, names.parameters, spec, word, scope)
        root.given = tuple(
            Given(
                name,
                names.parameter_slots[name],
                parameter.default,
                values["with"].get(name),
                values["live"].get(name),
            )
            for name, parameter in names.parameters.items()
        )
        included = self.tree.graphs[root.index]
        mission = self.tree.graphs[0]
        priority = included.node.get("priority") if included.node else None
        if priority is not None and included.outer_first != mission.outer_first:
            self.faults.fail(
                "mixed-priority",
                f"'{included.name}' asks for another `priority` than the mission that includes it",
                priority.where,
                "one priority holds for a whole mission",
            )

    def given(
        self,
        name: str,
        parameters: Mapping[str, Parameter],
        spec: StateSpec,
        place: Scalar,
        scope: Scope,
        trusted: bool = False,
    ) -> dict[str, dict[str, Compiled]]:
        """The parameters that stand under ``with`` and ``live``; required ones must be there."""
        context = self.own.context(scope)
        values: dict[str, dict[str, Compiled]] = {"with": {}, "live": {}}
        for key, entries in (("with", spec.with_), ("live", spec.live)):
            for named in entries:
                parameter = parameters.get(named.name.text)
                if trusted:
                    parameter = Parameter(named.name.text, ANY, live=True)
                if parameter is None:
                    self.faults.fail(
                        "unknown-parameter",
                        f"'{name}' has no parameter '{named.name.text}'",
                        named.name.where,
                        nearest(named.name.text, parameters),
                    )
                    continue
                with self.faults.collecting():
                    values[key][parameter.name] = read_value(named.node, parameter.type, context)
        given = {named.name.text for named in (*spec.with_, *spec.live)}
        misspelt = given - set(parameters)
        for parameter in parameters.values():
            # One whose name was misspelt is reported already.
            if (
                parameter.required
                and parameter.name not in given
                and not get_close_matches(parameter.name, misspelt)
            ):
                self.faults.fail(
                    "missing-parameter",
                    f"'{name}' needs the parameter '{parameter.name}' ({parameter.type})",
                    place.where,
                    f"with: {{{parameter.name}: …}}",
                )
        return values

    def actions(self, specs: tuple[ActionSpec, ...], scope: Scope) -> tuple[Action, ...]:
        if not specs:
            return ()
        found: list[Action] = []
        context, events = self.own.context(scope), self.own.events
        for spec in specs:
            with self.faults.collecting():
                action = actions.compile_action(spec, context, events, self.vocabulary)
                found.append(replace(action, node=spec.node))
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
        return edge

    def targets(self, node: Node, spec: TransitionSpec) -> tuple[Node, ...]:
        targets = tuple([self.tree.target(node, target) for target in spec.targets])
        if len(targets) < 2:
            return targets
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
