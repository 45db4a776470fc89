"""Compiles SCXML documents of other programs to graphs.

The W3C's rules hold here, not those of the YAML language: transitions leave their state unless
``type="internal"``, an event is caught by any prefix of its tokens, data are those of the whole
document, and a finished state raises ``done.state.ID``. A state's path in the graph is its id.
What is not supported is reported: ``invoke`` and XML data. What a document gets wrong in an
expression is a warning, and raises ``error.execution`` when it is evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fsm.chart.draft import MAX_STATE_DEPTH, Draft, StateDraft, TransitionDraft, compatible
from fsm.chart.executable import Action, Data, EventFields, Runtime
from fsm.chart.graph import Graph, build_nodes
from fsm.checks.structure import (
    dead_alternatives,
    endless_always,
    endless_states,
    reachable,
    unreachable,
)
from fsm.expressions.compiled import Compiled, constant
from fsm.expressions.scope import FIRST_HOST_SLOT
from fsm.faults import Faults
from fsm.host import Vocabulary
from fsm.language.spec import StateType
from fsm.scxml.content import Content, needed
from fsm.scxml.datamodel import Names
from fsm.scxml.document import Element
from fsm.scxml.ecmascript import ECMASCRIPT
from fsm.scxml.grammar import STATES, belongs, grammar_faults
from fsm.scxml.null import NO_DATA
from fsm.scxml.python import PYTHON
from fsm.scxml.sending import IO_PROCESSORS, SESSION
from fsm.values.types import ANY
from vencejo.errors import Fault, UserError, Where, nearest

_ERRORS = ("error.execution", "error.communication", "error.livelock")
VOCABULARY = Vocabulary(reactions=dict.fromkeys(_ERRORS, "none"))
"""A host without names, which reacts to no event of a document."""

_MODELS = {"ecmascript": ECMASCRIPT, "python": PYTHON, "null": NO_DATA}
_NAME = re.compile(r"(?:[^\W\d]|\$)[\w$]*")


def descriptors_match(descriptors: str, event: str, _: Vocabulary = VOCABULARY) -> bool:
    """Whether one of these descriptors matches an event: ``foo`` and ``foo.*`` match ``foo.bar``.

    They are separated by blanks (W3C recommendation of 2015, section 3.12.1).
    """
    for descriptor in descriptors.split():
        prefix = descriptor.removesuffix("*").removesuffix(".")
        if not prefix or event == prefix or event.startswith(prefix + "."):
            return True
    return False


def load_document(root: Element, name: str, vocabulary: Vocabulary = VOCABULARY) -> Graph:
    """Compile a document. Raises UserError with every fault that was found.

    ``vocabulary`` is that of the host it will run on; the document does not see its names.
    """
    if root.tag != "scxml":
        hint = 'it begins with <scxml xmlns="http://www.w3.org/2005/07/scxml">'
        raise UserError("not-scxml", f"<{root.tag}> is no SCXML document", root.where, hint)
    faults = Faults(grammar_faults(root))
    if root.get("datamodel") not in (None, *_MODELS):
        # Its expressions cannot be judged.
        raise UserError.of(_in_order(faults))
    graph = _Loader(root, name, vocabulary, faults).graph()
    if faults.errors:
        raise UserError.of(_in_order(faults))
    return replace(graph, warnings=tuple(_in_order((*faults, *_odd(graph)))))


def _odd(graph: Graph) -> Iterator[Fault]:
    """Warnings of likely mistakes. SCXML allows them all, so that none is an error."""

    def covers(earlier: str, later: str) -> bool:
        names = (descriptor.removesuffix("*").removesuffix(".") for descriptor in later.split())
        return all(descriptors_match(earlier, name) for name in names)

    for fault in (
        *endless_states(graph, lambda region: False),
        *unreachable(graph, reachable(graph)),
        *dead_alternatives(graph.nodes, covers),
        *endless_always(graph),
    ):
        yield replace(fault, severity="warning")


def _in_order(faults: Iterable[Fault]) -> list[Fault]:
    return sorted(faults, key=lambda fault: fault.where or Where(""))


class _Loader:
    """Compiles one document."""

    def __init__(self, root: Element, name: str, vocabulary: Vocabulary, faults: Faults) -> None:
        self.root = root
        self.name = root.get("name") or Path(name).stem
        self.faults = faults
        self.vocabulary = vocabulary
        self.first_slot = FIRST_HOST_SLOT + len(vocabulary.names)
        self.system = {"_sessionid": SESSION, "_name": self.name, "_ioprocessors": IO_PROCESSORS}
        """The system variables but ``_event``, with their values."""
        self.states = Draft()
        self.elements: list[Element] = []
        """The element of each state, by its index."""
        self.by_id: dict[str, StateDraft] = {}
        self.model = _MODELS[root.get("datamodel") or "ecmascript"]
        self.late = root.get("binding") == "late"
        self.grow(root, None)

    def grow(self, element: Element, parent: StateDraft | None) -> None:
        """Add the state of an element, with all inside."""
        id_ = "" if parent is None else element.get("id") or f"state.{len(self.states)}"
        state = self.states.add(id_, id_, _type(element), element.where, parent)
        if state.depth > MAX_STATE_DEPTH:
            message = f"states nest at most {MAX_STATE_DEPTH} deep"
            raise UserError("too-deep", message, element.where)
        state.border = parent is None
        if element.tag == "history":
            with self.faults.collecting():
                state.deep = _kind(element, "shallow", "deep") == "deep"
        if id_ in self.by_id:
            message = f"the id '{id_}' stands twice, first at {self.by_id[id_].where}"
            self.faults.fail("duplicate-id", message, element.place("id"))
        self.by_id[id_] = state
        self.elements.append(element)
        for child in element.all(*STATES):
            if belongs(child, element):
                self.grow(child, state)

    def graph(self) -> Graph:
        event_slot = self.first_slot + len(self.states)
        counter = event_slot + 1
        variables = dict.fromkeys([*self.system, *self.declared()])
        slots = {name: counter + 1 + place for place, name in enumerate(variables)}
        first_flag = counter + 1 + len(variables)
        states = {state.path: state.index for state in self.states[1:]}
        names = Names({"_event": event_slot, **slots}, states, self.faults)
        self.content = Content(self.model, names, self.faults, counter)
        if len(self.states) == 1:
            self.faults.fail("no-states", "there is no state in here", self.root.where)
        else:
            self.link()
            self.states[0].data = tuple(self.data())
            for state, element in zip(self.states, self.elements, strict=True):
                self.fill(state, element)
                if self.late and state.parent is not None:
                    state.entry = (*self.bound(state, element, first_flag), *state.entry)
        nothing: Mapping[str, Any] = MappingProxyType({})
        return Graph(
            name=self.name,
            description="",
            nodes=build_nodes(self.states, self.first_slot, descriptors_match),
            parameters=nothing,
            parameter_slots=nothing,
            places=nothing,
            vocabulary=self.vocabulary,
            slots=first_flag + self.late * len(self.states),
            events=nothing,
            world=None,
            outer_first=False,
            event_slot=event_slot,
            document=self.root,
        )

    # -- data -------------------------------------------------------------------------------

    def declared(self) -> Iterator[str]:
        """The names of all variables; `foreach` and scripts may introduce their own."""
        names: Sequence[str | None]
        for element in self.root.walk():
            names = ()
            if element.tag == "data":
                names = [element.get("id")]
            elif element.tag == "foreach":
                names = [element.get("item"), element.get("index")]
            elif element.tag == "script":
                names = self.model.assigned_names(element.text)
            yield from (word for word in names if word and _NAME.fullmatch(word) and word[0] != "_")

    def data(self) -> Iterator[Data]:
        """The variables that have their first values from the start, and belong to the document."""
        names, where = self.content.names, self.root.where
        for name, value in self.system.items():
            # A copy: a document may change what it has assigned from here.
            copied = Compiled(ANY, partial(_copy, value), name, where)
            yield Data(name, names.variables[name], ANY, copied)
        counter = self.content.counter
        yield Data("_sent", counter, ANY, constant(0, ANY, where))
        first: dict[str, Where] = {}
        for state, element in zip(self.states, self.elements, strict=True):
            for each in _data_of(element):
                with self.faults.collecting():
                    name = self.named(each, first)
                    if not self.late or state.parent is None:
                        yield Data(name, names.variables[name], ANY, self.first_value(each))

    def named(self, element: Element, known: dict[str, Where]) -> str:
        """The name of a `<data>`, which becomes known. Raises UserError."""
        name, where = needed(element, "id"), element.place("id")
        if not _NAME.fullmatch(name) or name.startswith("_"):
            hint = "begin with a letter; '_' begins the system's own names"
            raise UserError("bad-name", f"'{name}' is no name of a variable", where, hint)
        if name in known:
            message = f"the id '{name}' stands twice, first at {known[name]}"
            raise UserError("duplicate-id", message, where)
        known[name] = where
        return name

    def first_value(self, element: Element) -> Compiled:
        """The value that a `<data>` gives. Raises UserError."""
        value = self.content.given(element)
        if value is None:
            return constant(None, ANY, element.where)
        text = element.get("expr") or element.text
        return Compiled(ANY, value, text, element.place("expr"))

    def bound(self, state: StateDraft, element: Element, first_flag: int) -> Iterator[Action]:
        """With late binding: gives a state's variables their values when it is first entered."""
        values: list[tuple[int, Compiled]] = []
        for each in _data_of(element):
            slot = self.content.names.variables.get(each.get("id") or "")
            if slot is not None:
                with self.faults.collecting():
                    values.append((slot, self.first_value(each)))
        flag = first_flag + state.index

        def run(instance: Runtime, event: EventFields) -> None:
            if instance.slots[flag] is None:
                instance.slots[flag] = True
                for slot, value in values:
                    instance.slots[slot] = instance.evaluate(value, event, None)

        if values:
            yield Action("data", element.where, run)

    # -- targets ----------------------------------------------------------------------------

    def link(self) -> None:
        """Resolve the initial states and the default targets of history states."""
        for state, element in zip(self.states, self.elements, strict=True):
            with self.faults.collecting():
                if state.type == "compound":
                    state.initial = self.initial(state, element)
                elif state.type == "history":
                    state.initial = self.default_targets(state, element)

    def initial(self, state: StateDraft, element: Element) -> tuple[StateDraft, ...]:
        transition = _transition_of(next(element.all("initial"), None))
        if element.get("initial") is not None:
            targets = self.targets(element, "initial")
        elif transition is not None:
            targets = self.targets(transition, "target")
        else:
            targets = tuple([c for c in state.children if c.type != "history"][:1])
        outside = next((target for target in targets if not state.contains(target)), None)
        if outside is not None or not targets:
            what = f"'{outside.path}' is not inside" if outside else "no initial state is in here"
            raise UserError("unknown-target", what, element.place("initial"))
        return targets

    def default_targets(self, history: StateDraft, element: Element) -> tuple[StateDraft, ...]:
        """The states that a history state stands for while it has no content. Raises UserError."""
        transition = _transition_of(element)
        assert history.parent is not None
        if transition is None or transition.get("target") is None:
            what = "a history state needs a <transition> for the first time"
            raise UserError("missing-transition", what, element.where)
        targets = self.targets(transition, "target")
        for target in targets:
            if not history.parent.contains(target) or target.type == "history":
                what = f"'{target.path}' is no state beside this history"
                raise UserError("unknown-target", what, transition.place("target"))
        return targets

    def targets(self, element: Element, attribute: str) -> tuple[StateDraft, ...]:
        ids = (element.get(attribute) or "").split()
        for id_ in ids:
            if not id_ or id_ not in self.by_id:
                what, where = f"there is no state '{id_}'", element.place(attribute)
                raise UserError(
                    "unknown-target", what, where, nearest(id_, filter(None, self.by_id))
                )
        targets = tuple([self.by_id[id_] for id_ in ids])
        # In document order, two incompatible targets have neighbours that are.
        for a, b in pairwise(sorted(targets, key=lambda target: target.index)):
            if not compatible(a, b):
                raise UserError(
                    "conflicting-targets",
                    f"'{a.path}' and '{b.path}' cannot be entered together",
                    element.place(attribute),
                    "several targets lie in different regions of one <parallel>",
                )
        return targets

    # -- the contents of each state ---------------------------------------------------------

    def fill(self, state: StateDraft, element: Element) -> None:
        """Compile everything that stands in a state into its draft."""
        content = self.content
        if state.parent is None:
            state.entry = content.actions(element.all("script"))
        else:
            state.entry = content.blocks(element.all("onentry"))
        state.exit_actions = content.blocks(element.all("onexit"))
        donedata = next(element.all("donedata"), None)
        if donedata is not None:
            with self.faults.collecting():
                state.output = [
                    (name, Compiled(ANY, function, name, donedata.where))
                    for name, function in content.fields(donedata).items()
                ]
        if state.type == "history":
            holder = _transition_of(element)
        else:
            holder = _transition_of(next(element.all("initial"), None))
            transitions = self.transitions(element)
            state.on = [(draft.trigger, [draft]) for draft in transitions if draft.kind == "on"]
            state.always = [draft for draft in transitions if draft.kind == "always"]
        state.default_actions = content.actions(holder.children) if holder else ()

    def transitions(self, element: Element) -> list[TransitionDraft]:
        found = []
        for transition in element.all("transition"):
            with self.faults.collecting():
                found.append(self.transition(transition))
        return found

    def transition(self, element: Element) -> TransitionDraft:
        always = element.get("event") is None
        return TransitionDraft(
            "always" if always else "on",
            "always" if always else needed(element, "event"),
            element.where,
            reenter=_kind(element, "external", "internal") == "external",
            guard=self.content.condition(element),
            actions=self.content.actions(element.children),
            targets=self.targets(element, "target"),
        )


def _type(element: Element) -> StateType:
    match element.tag:
        case "parallel" | "final" | "history":
            return element.tag
        case "scxml":
            return "compound"
    return "compound" if any(element.all("state", "parallel", "final")) else "atomic"


def _kind(element: Element, usual: str, other: str) -> str:
    """The ``type`` of an element, one of two words. Raises UserError."""
    word = element.get("type") or usual
    if word not in (usual, other):
        what = f"a <{element.tag}> is {usual} or {other}, not '{word}'"
        raise UserError("wrong-value", what, element.place("type"), nearest(word, [usual, other]))
    return word


def _transition_of(element: Element | None) -> Element | None:
    return next(element.all("transition"), None) if element else None


def _copy(value: Any, *_: object) -> Any:
    return deepcopy(value)


def _data_of(element: Element) -> Iterator[Element]:
    """The variables that stand in a state."""
    for model in element.all("datamodel"):
        yield from model.all("data")
