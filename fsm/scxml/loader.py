"""SCXML documents of others, compiled to the same graph that missions become.

The W3C's rules hold here, not those of the YAML language: transitions leave their state unless
``type="internal"``, an event is caught by any prefix of its tokens, data are those of the whole
document, and a finished state raises ``done.state.ID``. A state's path in the graph is its id.
Not supported, and reported: ``invoke``, late binding, data and scripts in other files.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from fsm.chart.graph import Data, Edge, Graph, Guard, Node
from fsm.checks.structure import dead_alternatives, endless_always, endless_states, unreachable
from fsm.compiler.tree import domain_of
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
"""A document names nothing of the host, and the host reacts to nothing in it."""

MAX_STATE_DEPTH = 64
_STATES = ("state", "parallel", "final", "history")
_KNOWN = {
    "scxml": {"state", "parallel", "final", "datamodel", "script", "transition"},
    "state": {"onentry", "onexit", "transition", "initial", "datamodel", *_STATES},
    "parallel": {"onentry", "onexit", "transition", "datamodel", "state", "parallel", "history"},
    "final": {"onentry", "onexit", "donedata"},
    "history": {"transition"},
}


class ScxmlNode(Node):
    """A state whose events are matched as SCXML matches them."""

    def edges_for(self, event: str, vocabulary: Vocabulary) -> tuple[Edge, ...]:
        """The transitions this event may take here, in document order."""
        found = (edges for pattern, edges in self.on if catches(pattern, event))
        return tuple(edge for edges in found for edge in edges)


def catches(descriptors: str, event: str) -> bool:
    """Whether one of these descriptors names the event: ``foo`` and ``foo.*`` name ``foo.bar``."""
    for descriptor in descriptors.split():
        prefix = descriptor.removesuffix("*").removesuffix(".")
        if not prefix or event == prefix or event.startswith(prefix + "."):
            return True
    return False


def load_document(root: Element, name: str, vocabulary: Vocabulary = VOCABULARY) -> Graph:
    """The graph of a document. Raises UserError with every fault that was found.

    ``vocabulary`` is that of the host it will run on, whose names the document does not see.
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
    """What looks like a mistake. SCXML allows all of it, so that nothing here is an error."""

    def covers(earlier: str, later: str) -> bool:
        names = (descriptor.removesuffix("*").removesuffix(".") for descriptor in later.split())
        return all(catches(earlier, name) for name in names)

    for fault in (
        *endless_states(graph, lambda region: False),
        *unreachable(graph),
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
        self.nodes: list[Node] = []
        self.elements: list[Element] = []
        self.by_id: dict[str, Node] = {}
        if root.get("binding") == "late":
            faults.fail("not-supported", "late binding is not supported", root.place("binding"))
        self.grow(root, None, 0)

    def grow(self, element: Element, parent: Node | None, depth: int) -> Node:
        if depth > MAX_STATE_DEPTH:
            message = f"states nest at most {MAX_STATE_DEPTH} deep"
            raise UserError("too-deep", message, element.where)
        index = len(self.nodes)
        id_ = "" if parent is None else element.get("id") or f"state.{index}"
        node = ScxmlNode(id_, id_, _type(element), index, element.where)
        node.parent = parent
        node.border = parent is None
        node.ancestors = (parent, *parent.ancestors) if parent else ()
        if element.tag == "history":
            with self.faults.collecting():
                node.deep = _kind(element, "shallow", "deep") == "deep"
        node.entered_slot = self.first_slot + index
        if id_ in self.by_id:
            message = f"the id '{id_}' stands twice, first at {self.by_id[id_].where}"
            self.faults.fail("duplicate-id", message, element.place("id"))
        self.by_id[id_] = node
        self.nodes.append(node)
        self.elements.append(element)
        for child in element.children:
            known = child.tag in _KNOWN[element.tag] or child.tag.startswith(("{", "v:"))
            if not known:
                what = f"<{child.tag}> in <{element.tag}> is not supported"
                hint = nearest(child.tag, _KNOWN[element.tag])
                self.faults.fail("not-supported", what, child.where, hint)
        node.children = tuple(
            self.grow(child, node, depth + 1)
            for child in element.all(*_STATES)
            if child.tag in _KNOWN[element.tag]
        )
        node.last = len(self.nodes) - 1
        return node

    def graph(self) -> Graph:
        root = self.nodes[0]
        event_slot = self.first_slot + len(self.nodes)
        counter = event_slot + 1
        variables = dict.fromkeys(["_sessionid", "_name", *self.declared()])
        slots = {name: counter + 1 + place for place, name in enumerate(variables)}
        states = {node.path: node.index for node in self.nodes[1:]}
        names = Names(slots, states, event_slot)
        self.content = Content(names, self.faults, counter)
        if not root.children:
            self.faults.fail("no-states", "there is no state in here", self.root.where)
        else:
            self.link()
            root.data = tuple(self.data(names))
            for node, element in zip(self.nodes, self.elements, strict=True):
                self.fill(node, element)
        return Graph(
            name=self.name,
            description="",
            root=root,
            nodes=tuple(self.nodes),
            parameters={},
            parameter_slots={},
            vocabulary=self.vocabulary,
            slots=counter + 1 + len(variables),
            events={},
            world=None,
            outer_first=False,
            by_path=dict(self.by_id),
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

    # -- where states lead ------------------------------------------------------------------

    def link(self) -> None:
        for node, element in zip(self.nodes, self.elements, strict=True):
            with self.faults.collecting():
                if node.type == "compound":
                    node.initial = self.initial(node, element)
                elif node.type == "history":
                    node.initial = self.first_time(node, element)

    def initial(self, node: Node, element: Element) -> tuple[Node, ...]:
        transition = _transition_of(next(element.all("initial"), None))
        if element.get("initial") is not None:
            targets = self.targets(element, "initial")
        elif transition is not None:
            targets = self.targets(transition, "target")
        else:
            targets = tuple(child for child in node.children if child.type != "history")[:1]
        outside = next((target for target in targets if not node.contains(target)), None)
        if outside is not None or not targets:
            what = f"'{outside.path}' is not inside" if outside else "no initial state is in here"
            raise UserError("unknown-target", what, element.place("initial"))
        return targets

    def first_time(self, node: Node, element: Element) -> tuple[Node, ...]:
        transition = _transition_of(element)
        assert node.parent is not None
        if transition is None or transition.get("target") is None:
            what = "a history state needs a <transition> for the first time"
            raise UserError("missing-transition", what, element.where)
        targets = self.targets(transition, "target")
        for target in targets:
            if not node.parent.contains(target) or target.type == "history":
                what = f"'{target.path}' is no state beside this history"
                raise UserError("unknown-target", what, transition.place("target"))
        return targets

    def targets(self, element: Element, attribute: str) -> tuple[Node, ...]:
        ids = (element.get(attribute) or "").split()
        for id_ in ids:
            if not id_ or id_ not in self.by_id:
                what, where = f"there is no state '{id_}'", element.place(attribute)
                raise UserError(
                    "unknown-target", what, where, nearest(id_, filter(None, self.by_id))
                )
        targets = tuple(self.by_id[id_] for id_ in ids)
        # In document order, two that clash have neighbours that do.
        for a, b in pairwise(sorted(targets, key=lambda target: target.index)):
            common = next(place for place in (a, *a.ancestors) if place in (b, *b.ancestors))
            if common.type != "parallel" or common in (a, b):
                raise UserError(
                    "conflicting-targets",
                    f"'{a.path}' and '{b.path}' cannot be entered together",
                    element.place(attribute),
                    "several targets lie in different regions of one <parallel>",
                )
        return targets

    # -- what stands in each state ----------------------------------------------------------

    def fill(self, node: Node, element: Element) -> None:
        content = self.content
        node.entry = content.blocks(element.all("onentry"))
        if node.parent is None:
            node.entry = content.actions(element.all("script"))
        node.exit_actions = content.blocks(element.all("onexit"))
        donedata = next(element.all("donedata"), None)
        if donedata is not None:
            with self.faults.collecting():
                node.output = {
                    name: Compiled(ANY, function, name, donedata.where)
                    for name, function in content.fields(donedata).items()
                }
        if node.type == "history":
            holder = _transition_of(element)
        else:
            holder = _transition_of(next(element.all("initial"), None))
        node.default_actions = content.actions(holder.children) if holder else ()
        on: list[tuple[str, tuple[Edge, ...]]] = []
        always: list[Edge] = []
        for transition in element.all("transition") if node.type != "history" else ():
            with self.faults.collecting():
                edge = self.edge(node, transition)
                if edge.kind == "on":
                    on.append((edge.trigger, (edge,)))
                else:
                    always.append(edge)
        node.on, node.always = tuple(on), tuple(always)

    def edge(self, node: Node, element: Element) -> Edge:
        event = element.get("event")
        if event is None:
            edge = Edge(node, "always", "always", element.where)
        else:
            edge = Edge(node, "on", needed(element, "event"), element.where)
        edge.reenter = _kind(element, "external", "internal") == "external"
        edge.guard = self.content.condition(element)
        if edge.guard is not None:
            edge.conditions.append(Guard(edge.guard))
        edge.actions = self.content.actions(element.children)
        edge.targets = self.targets(element, "target")
        if edge.targets:
            edge.dest = ", ".join(target.path for target in edge.targets)
            edge.domain = domain_of(node, edge.targets, edge.reenter)
        return edge


def _type(element: Element) -> StateType:
    match element.tag:
        case "parallel" | "final" | "history":
            return element.tag
        case "scxml":
            return "compound"
    return "compound" if any(element.all("state", "parallel", "final")) else "atomic"


def _kind(element: Element, usual: str, other: str) -> str:
    """Its ``type``, which is one of two words. Raises UserError."""
    word = element.get("type") or usual
    if word not in (usual, other):
        what = f"a <{element.tag}> is {usual} or {other}, not '{word}'"
        raise UserError("wrong-value", what, element.place("type"), nearest(word, [usual, other]))
    return word


def _transition_of(element: Element | None) -> Element | None:
    return next(element.all("transition"), None) if element else None
