"""Compiles SCXML documents of other programs to graphs.

The W3C's rules hold here, not those of the YAML language: transitions leave their state unless
``type="internal"``, an event is caught by any prefix of its tokens, data are those of the whole
document, and a finished state raises ``done.state.ID``. A state's path in the graph is its id.
Not supported, and reported: ``invoke``, late binding, data and scripts in other files.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fsm.chart.draft import MAX_STATE_DEPTH, Draft, StateDraft, TransitionDraft, compatible
from fsm.chart.executable import Data
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
from fsm.scxml.document import Element
from fsm.scxml.ecmascript import Names, assigned_names, compile_value
from fsm.values.types import ANY
from vencejo.errors import Fault, UserError, Where, nearest

VOCABULARY = Vocabulary(reactions={"error.execution": "none", "error.livelock": "none"})
"""A host without names, which reacts to no event of a document."""

_STATES = ("state", "parallel", "final", "history")
_KNOWN = {
    "scxml": {"state", "parallel", "final", "datamodel", "script", "transition"},
    "state": {"onentry", "onexit", "transition", "initial", "datamodel", *_STATES},
    "parallel": {"onentry", "onexit", "transition", "datamodel", "state", "parallel", "history"},
    "final": {"onentry", "onexit", "donedata"},
    "history": {"transition"},
}


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
    faults = Faults()
    graph = _Loader(root, name, vocabulary, faults).graph()
    if faults:
        raise UserError.of(_in_order(faults))
    return replace(graph, warnings=tuple(_in_order(_odd(graph))))


def _odd(graph: Graph) -> Iterator[Fault]:
    """Warnings of likely mistakes. SCXML allows them all, so that none is an error."""

    def covers(earlier: str, later: str) -> bool:
        names = (descriptor.removesuffix("*").removesuffix(".") for descriptor in later.split())
        return all(descriptors_match(earlier, name) for name in names)

    for fault in (
        *endless_states(graph, lambda region: False),
        *unreachable(graph, reachable(graph)),
        *dead_alternatives(graph, covers),
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
        self.states = Draft()
        self.elements: list[Element] = []
        """The element of each state, by its index."""
        self.by_id: dict[str, StateDraft] = {}
        if root.get("binding") == "late":
            faults.fail("not-supported", "late binding is not supported", root.place("binding"))
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
        known = _KNOWN[element.tag]
        for child in element.children:
            if child.tag not in known and not child.tag.startswith(("{", "v:")):
                what = f"<{child.tag}> in <{element.tag}> is not supported"
                self.faults.fail("not-supported", what, child.where, nearest(child.tag, known))
        for child in element.all(*_STATES):
            if child.tag in known:
                self.grow(child, state)

    def graph(self) -> Graph:
        event_slot = self.first_slot + len(self.states)
        counter = event_slot + 1
        variables = dict.fromkeys(["_sessionid", "_name", *self.declared()])
        slots = {name: counter + 1 + place for place, name in enumerate(variables)}
        states = {state.path: state.index for state in self.states[1:]}
        names = Names(slots, states, event_slot)
        self.content = Content(names, self.faults, counter)
        if len(self.states) == 1:
            self.faults.fail("no-states", "there is no state in here", self.root.where)
        else:
            self.link()
            self.states[0].data = tuple(self.data(names))
            for state, element in zip(self.states, self.elements, strict=True):
                self.fill(state, element)
        nothing: Mapping[str, Any] = MappingProxyType({})
        return Graph(
            name=self.name,
            description="",
            nodes=build_nodes(self.states, self.first_slot, descriptors_match),
            parameters=nothing,
            parameter_slots=nothing,
            places=nothing,
            vocabulary=self.vocabulary,
            slots=counter + 1 + len(variables),
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
                names = assigned_names(element.text)
            yield from (word for word in names if word and not word.startswith("_"))

    def data(self, names: Names) -> Iterator[Data]:
        """All variables, which belong to the document as a whole, with their first values."""
        where = self.root.where
        own = {"_sessionid": "1", "_name": self.name}
        for name, value in own.items():
            yield Data(name, names.variables[name], ANY, constant(value, ANY, where))
        counter = self.content.counter
        yield Data("_sent", counter, ANY, constant(0, ANY, where))
        for element in self.root.walk():
            if element.tag != "data":
                continue
            with self.faults.collecting():
                name = needed(element, "id")
                if element.get("src") is not None:
                    what = "data from other files are not supported"
                    raise UserError("not-supported", what, element.place("src"))
                text, where = element.get("expr"), element.place("expr")
                if text is None and element.text_where is not None:
                    text, where = element.text, element.text_where
                first = constant(None, ANY, element.where)
                if text is not None:
                    first = Compiled(ANY, compile_value(text, where, names), text, where)
                yield Data(name, names.variables[name], ANY, first)

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
