"""Compiles a mission's spec against its host's vocabulary into a :class:`fsm.chart.graph.Graph`.

The states are drafted by :mod:`fsm.compiler.tree` and their names declared by
:mod:`fsm.compiler.declarations`; their actions, transitions and values are compiled here. Every
fault is collected, so that one check shows them all. The rules for the finished structure stand in
:mod:`fsm.checks.mission`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from difflib import get_close_matches
from itertools import combinations
from types import MappingProxyType

from fsm.chart.draft import StateDraft, TransitionDraft, compatible
from fsm.chart.executable import Action, Given, Message
from fsm.chart.graph import Graph, build_nodes
from fsm.checks.flying import check_way
from fsm.checks.mission import check
from fsm.compiler.actions import Environment, compile_action
from fsm.compiler.declarations import Declarations
from fsm.compiler.namespace import FAILED_FIELDS, Fields
from fsm.compiler.parameters import parse_parameters
from fsm.compiler.tree import Tree
from fsm.compiler.unused import unused
from fsm.expressions.compiled import Compiled, compile_expression, require_value
from fsm.expressions.literals import read_value
from fsm.expressions.scope import Scope, start
from fsm.faults import Faults
from fsm.host import Parameter, Vocabulary, matches
from fsm.language.spec import (
    ActionSpec,
    DefineSpec,
    MissionSpec,
    StateSpec,
    TransitionSpec,
    TriggerSpec,
)
from fsm.values.types import ANY, BOOL, MapOf, Number, Type
from vencejo.errors import Correction, Fault, UserError, Where, certain, nearest
from vencejo.nodes import Scalar
from vencejo.units import TIME

__all__ = ["compile_mission", "parse_parameters"]

DURATION = Number(TIME, min=0.0)


def compile_mission(
    spec: MissionSpec, vocabulary: Vocabulary, found: Iterable[Fault] = ()
) -> Graph:
    """Compile a mission. Raises UserError with every fault that would keep it from flying.

    ``found`` are faults that were found in it before; they are reported with the others.
    """
    faults = Faults(found)
    tree = Tree(spec, faults)
    names = Declarations(vocabulary, tree, faults)
    own = names.of(tree.root)
    compiler = _Compiler(tree, names, faults)
    for state in tree.states:
        compiler.fill(state)
    graph = Graph(
        name=spec.name,
        description=spec.description,
        nodes=build_nodes(tree.states, names.first_slot, pattern_matches),
        parameters=MappingProxyType(own.parameters),
        parameter_slots=MappingProxyType(own.parameter_slots),
        vocabulary=vocabulary,
        slots=names.slots,
        events=MappingProxyType(own.known_events),
        world=spec.world.text if spec.world else None,
        places=MappingProxyType(own.places),
        outer_first=spec.outer_first,
        source=spec,
        messages=tuple(compiler.messages),
        host_fields=MappingProxyType(names.host_fields),
    )
    faults.extend(check(graph, {graph.nodes[state.index] for state in compiler.flawed}))
    # A define's mistake shows at each of its uses, always at the same place.
    ordered = sorted(dict.fromkeys(faults), key=lambda fault: fault.where or Where(""))
    ordered.sort(key=lambda fault: fault.severity)
    if ordered and ordered[0].severity == "error":
        raise UserError.of(ordered)
    return replace(graph, warnings=(*ordered, *check_way(graph), *unused(spec)))


def pattern_matches(pattern: str, event: str, vocabulary: Vocabulary) -> bool:
    """Whether a pattern under ``on`` matches an event or outcome.

    ``*`` matches neither ``error.…`` nor the host's urgent events.
    """
    if "*" not in pattern:
        return pattern == event
    if pattern == "*":
        return not event.startswith("error.") and not vocabulary.is_urgent(event)
    return matches(pattern, event)


class _Compiler:
    """Compiles the contents of each state into its draft."""

    def __init__(self, tree: Tree, names: Declarations, faults: Faults) -> None:
        self.tree = tree
        self.names = names
        self.faults = faults
        self.vocabulary = names.vocabulary
        self.own = names.of(tree.root)
        """The namespace of the graph whose states are being filled."""
        self.events = self.own.known_events
        self.known_outcomes: dict[int, dict[str, Fields | None] | None] = {}
        """What :meth:`outcomes` said of each state that was asked about."""
        self.messages: list[Message] = []
        """The events that the actions compiled so far raise, send and cancel."""
        self.flawed: set[StateDraft] = set()
        """States with transitions or children that could not be compiled."""
        self.trusting = any(s.invocation and s.invocation.behavior.on_trust for s in tree.states)

    # -- the contents of each state ---------------------------------------------------------

    def fill(self, state: StateDraft) -> None:
        """Compile everything that stands in a state into its draft."""
        spec, scope = self.tree.specs[state.index], self.names.scopes[state.index]
        if self.names.of(state) is not self.own:
            self.own = self.names.of(state)
            self.events = self.own.known_events
        state.entry = self.actions(spec.entry, scope)
        state.exit_actions = self.actions(spec.exit, scope)
        state.throughout = self.actions(spec.throughout, scope)
        if spec.do:
            self.invocation(state, spec, spec.do, scope)
        if spec.include:
            self.include(state, spec, spec.include, scope)
        for define in spec.define:
            with self.faults.collecting():
                self.define(define, scope)
        state.output = self.output(spec, scope)
        known = len(self.faults)
        self.triggers(state, spec, scope)
        failed = any(fault.severity == "error" for fault in self.faults[known:])
        if spec.flawed or failed or self.tree.lacks(state):
            self.flawed.add(state)

    def output(self, spec: StateSpec, scope: Scope) -> list[tuple[str, Compiled]]:
        found = []
        for named in spec.output:
            with self.faults.collecting():
                value = read_value(named.node, ANY, self.own.context(scope))
                found.append((named.name.text, value))
        return found

    def triggers(self, state: StateDraft, spec: StateSpec, scope: Scope) -> None:
        """Compile the transitions of a state, by kind of trigger."""
        on, whens, afters, always = [], [], [], []
        for trigger in spec.triggers:
            key = trigger.key
            with self.faults.collecting():
                match trigger.kind:
                    case "on":
                        event = self.event_scope(state, trigger, scope)
                        on.append((key.text, self.alternatives(state, trigger, event)))
                    case "when":
                        condition = expression(key, scope, BOOL)
                        whens.append((condition, self.alternatives(state, trigger, scope)))
                    case "after":
                        duration = expression(key, scope, DURATION)
                        afters.append((duration, self.alternatives(state, trigger, scope)))
                    case "always":
                        always.extend(self.alternatives(state, trigger, scope))
        state.on, state.whens, state.afters, state.always = on, whens, afters, always

    def define(self, define: DefineSpec, scope: Scope) -> None:
        """Compile a define by itself, so that an unused one is checked too. Raises UserError."""
        for argument in define.arguments:
            if scope.find(argument) is not None:
                raise UserError(
                    "name-taken",
                    f"the name '{argument}' is visible here already",
                    define.where,
                    "choose another for the argument",
                )
        arguments = dict.fromkeys(define.arguments, ANY)
        body = define.body
        # `debug: false` is a switch, and meant so.
        computed = body.text.strip() not in ("true", "false")
        compile_expression(body.text, start(body), scope, arguments=arguments, condition=computed)

    def event_scope(self, state: StateDraft, trigger: TriggerSpec, scope: Scope) -> Scope:
        """The scope of an ``on`` transition, in which ``event`` has the fields of the trigger.

        Raises UserError for an event or outcome that cannot occur here.
        """
        fields = self.event_fields(state, trigger.key)
        if any(each.guard or each.actions for each in trigger.alternatives):
            return scope.with_event(MapOf(fields))
        return scope  # Most transitions have no expression that could ask for it.

    def event_fields(self, state: StateDraft, key: Scalar) -> Fields | None:
        """The fields of the event or outcome that a trigger names; None when they are not known.

        Raises UserError for one that cannot occur here.
        """
        name = key.text
        if name == "*":
            return None
        if name.endswith(".*"):
            self.require_family(key)
            return None
        if "." not in name:
            return self.outcome_fields(state, key)
        if name not in self.events and not self.trusting:
            message = f"there is no event '{name}'"
            raise UserError("unknown-event", message, key.where, nearest(name, self.events))
        return self.events.get(name)

    def require_family(self, key: Scalar) -> None:
        """Raise UserError unless some event matches a pattern such as ``battery.*``."""
        family = key.text[:-1]
        if not self.trusting and not any(event.startswith(family) for event in self.events):
            families = {event.split(".")[0] + ".*" for event in self.events}
            message = f"no event begins with '{family}'"
            raise UserError("unknown-event", message, key.where, nearest(key.text, families))

    def outcome_fields(self, state: StateDraft, key: Scalar) -> Fields | None:
        """The fields of an outcome, as :meth:`event_fields` gives them."""
        if state.index not in self.known_outcomes:
            self.known_outcomes[state.index] = self.outcomes(state)
        outcomes, name = self.known_outcomes[state.index], key.text
        if outcomes is None:
            return None
        if name not in outcomes:
            event = next((e for e in self.events if e.replace(".", "_") == name), None)
            raise UserError(
                "unknown-outcome",
                f"nothing in this state ends with the outcome '{name}'",
                key.where,
                Correction(name, event, f"did you mean the event '{event}'?")
                if event
                else _outcome_hint(name, outcomes),
            )
        return outcomes[name]

    def outcomes(self, state: StateDraft) -> dict[str, Fields | None] | None:
        """Every outcome that can be offered to a state, with its fields where they are known.

        None when a behaviour inside is unknown: then any may be.
        """
        found: dict[str, list[Fields | None]] = {}
        for inner in self.tree.states[state.index : state.last + 1]:
            if self.in_doubt(inner):
                return None
            for word, fields in self.offered(inner, state):
                found.setdefault(word, []).append(fields)
        return {word: _common(fields) for word, fields in found.items()}

    def in_doubt(self, state: StateDraft) -> bool:
        """Whether the outcomes of a state's behaviour, states or included graph are unknown."""
        if state.invocation is not None:
            return state.invocation.behavior.on_trust
        unread = state.type in ("compound", "parallel") and not state.children
        return self.tree.specs[state.index].do is not None or unread

    def offered(self, inner: StateDraft, state: StateDraft) -> Iterator[tuple[str, Fields | None]]:
        """The outcomes, with their fields, that ``inner`` offers to ``state``.

        ``inner`` is ``state`` itself or lies inside it.
        """
        spec = self.tree.specs[inner.index]
        same = self.names.of(inner) is self.own
        if inner.invocation:
            for word, fields in inner.invocation.behavior.outcomes.items():
                # Of what an included graph goes through, only `failed` climbs out of it.
                if same and word != "failed" and (word != "done" or inner is state):
                    yield word, fields
        if inner.invocation or (spec.include and same):
            yield "failed", FAILED_FIELDS
        if inner.type == "parallel" and inner.owner is state:
            yield "done", {}
        if inner.type == "final" and inner.parent:
            owner = inner.parent.owner
            if self.names.of(owner) is self.own and (inner.outcome != "done" or owner is state):
                yield inner.outcome, {named.name.text: ANY for named in spec.output}

    def invocation(self, state: StateDraft, spec: StateSpec, do: Scalar, scope: Scope) -> None:
        """Compile the parameters that a state gives to its behaviour."""
        invocation = state.invocation
        if invocation is None:
            # An unknown behaviour is reported already; its parameters are still compiled.
            self.given(do.text, {}, spec, do, scope, trusted=True)
            return
        behavior = invocation.behavior
        values = self.given(behavior.name, behavior.parameters, spec, do, scope, behavior.on_trust)
        for named in spec.live:
            parameter = behavior.parameters.get(named.name.text)
            if parameter is not None and not parameter.live:
                self.faults.fail(
                    "not-live",
                    f"'{parameter.name}' cannot change in flight",
                    named.name.where,
                    "write it under `with`",
                )
        with_, live = MappingProxyType(values["with"]), MappingProxyType(values["live"])
        state.invocation = replace(invocation, with_=with_, live=live)

    def include(self, state: StateDraft, spec: StateSpec, word: Scalar, scope: Scope) -> None:
        """Compile the parameters that a state gives to the graph that it includes."""
        if not state.children:
            # A missing graph is reported already; its parameters are still compiled.
            self.given(word.text, {}, spec, word, scope, trusted=True)
            return
        (root,) = state.children
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
        """Compile the parameters under ``with`` and ``live``, and report required ones that lack.

        ``name`` is that of the behaviour or graph, ``place`` where it is named; one that is
        ``trusted`` may be given any parameter.
        """
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
                    value = read_value(named.node, parameter.type, context)
                    values[key][parameter.name] = value
                    if parameter.required:
                        require_value(value)
        for twice in sorted(values["with"].keys() & values["live"].keys()):
            self.faults.warn(
                "given-twice",
                f"'{twice}' stands under `live` and under `with`",
                values["with"][twice].where,
                "leave this one out: the value under `live` is the one that counts",
            )
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
        context, functions = self.own.context(scope), self.vocabulary.functions
        environment = Environment(context, self.own.events, functions)
        for spec in specs:
            with self.faults.collecting():
                action = compile_action(spec, environment)
                found.append(action)
                if action.message is not None:
                    self.messages.append(action.message)
        return tuple(found)

    def alternatives(
        self, state: StateDraft, trigger: TriggerSpec, scope: Scope
    ) -> list[TransitionDraft]:
        found = []
        for spec in trigger.alternatives:
            with self.faults.collecting():
                found.append(self.transition(state, trigger, spec, scope))
        return found

    def transition(
        self, state: StateDraft, trigger: TriggerSpec, spec: TransitionSpec, scope: Scope
    ) -> TransitionDraft:
        return TransitionDraft(
            trigger.kind,
            trigger.key.text,
            spec.where,
            reenter=spec.reenter,
            guard=expression(spec.guard, scope, BOOL) if spec.guard else None,
            hold=expression(spec.hold, scope, DURATION) if spec.hold else None,
            actions=self.actions(spec.actions, scope),
            targets=self.targets(state, spec),
            name=spec.name,
        )

    def targets(self, source: StateDraft, spec: TransitionSpec) -> tuple[StateDraft, ...]:
        targets = tuple([self.tree.target(source, target) for target in spec.targets])
        if len(targets) > 1:
            for (one, a), (two, b) in combinations(zip(spec.targets, targets, strict=True), 2):
                if not compatible(a, b):
                    raise UserError(
                        "conflicting-targets",
                        f"'{one.text}' and '{two.text}' cannot be entered together",
                        two.where,
                        "several targets lie in different regions of one parallel state; "
                        "alternatives are a list of transitions",
                    )
        return targets


def expression(scalar: Scalar, scope: Scope, wanted: Type) -> Compiled:
    """Compile a condition or duration, written without ``$``. Raises UserError."""
    condition = wanted is BOOL
    return compile_expression(scalar.text, start(scalar), scope, wanted, condition=condition)


def _outcome_hint(name: str, outcomes: Iterable[str]) -> str:
    """All outcomes that there are, and the one that was meant where that is sure."""
    words = sorted(outcomes)
    if not words:
        return "there are no outcomes here"
    listed = f"the outcomes here are: {', '.join(words[:12])}{', …' if len(words) > 12 else ''}"
    meant = certain(name, words)
    if meant is None:
        return listed
    return Correction(name, meant, f"did you mean '{meant}'? {listed}")


def _common(known: list[Fields | None]) -> Fields | None:
    """The fields that an outcome has whichever state ends with it; None when some are unknown."""
    fields = [entry for entry in known if entry is not None]
    if len(fields) < len(known):
        return None
    return {name: type_ for name, type_ in fields[0].items() if all(name in f for f in fields)}
