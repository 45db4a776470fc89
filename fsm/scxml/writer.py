"""Exports missions as SCXML, so that other tools can show them; nothing of the mission is lost.

States, transitions, history, entry and exit actions and data are written as SCXML's own elements.
Everything else is written in our namespace, each key of the mission as an element or attribute of
that name, which :mod:`fsm.scxml.importer` reads again. A state's id is its path. Values and
expressions stay as they are in YAML; ``datamodel="vencejo"`` says so.
"""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree as Xml

from fsm.compiler.tree import Tree
from fsm.faults import Faults
from fsm.language.spec import MissionSpec
from fsm.scxml.document import OURS, SCXML
from vencejo.errors import UserError, Where
from vencejo.markup import ILLEGAL
from vencejo.nodes import Mapping, Scalar, Sequence, YamlNode

DATAMODEL = "vencejo"
_SAFE = re.compile(r"(?:[^\s\-?:,\[\]{}#&*!|>'\"%@`]|-(?=\S))[^,\[\]{}\n]*")
_ESCAPED = re.compile("[\x7f-\xa0\u2028\u2029\ufeff]")
_BLOCKS = {"entry": "onentry", "exit": "onexit", "throughout": "v:throughout"}
_TRIGGERS = ("on", "when", "after", "always")
_STRUCTURE = frozenset({"states", "type", "initial", "data", *_BLOCKS, *_TRIGGERS})
_OF_TYPE = {"final": frozenset({"output"}), "history": frozenset({"deep", "target"})}


def write_scxml(spec: MissionSpec) -> str:
    """Export a mission that compiles as an SCXML document. Raises UserError."""
    faults = Faults()
    writer = _Writer(Tree(spec, faults))
    assert spec.node is not None, "the reader keeps the node of every mission"
    root = Xml.Element("scxml", {"xmlns": SCXML, "xmlns:v": OURS, "version": "1.0"})
    root.set("datamodel", DATAMODEL)
    root.set("name", spec.name)
    writer.state(root, spec.node, "", frozenset({"mission"}))
    Xml.indent(root)
    text = Xml.tostring(root, encoding="unicode")
    if ILLEGAL.search(text):
        message = "a control character in this mission cannot stand in XML"
        raise UserError("not-text", message, Where(spec.file))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def flow(node: YamlNode) -> str:
    """A value in one line of YAML."""
    match node:
        case Sequence(items=items):
            return f"[{', '.join(map(flow, items))}]"
        case Mapping(entries=entries):
            return f"{{{', '.join(f'{flow(key)}: {flow(value)}' for key, value in entries)}}}"
        case Scalar(text=text, plain=plain):
            if node.null:
                return "null"
            marks = ": " in text or " #" in text or text.endswith((":", " "))
            if plain and _SAFE.fullmatch(text) and not marks:
                return text
            quoted = json.dumps(text, ensure_ascii=False)
            return _ESCAPED.sub(lambda match: f"\\u{ord(match[0]):04x}", quoted)


class _Writer:
    """Writes states into elements; the tree resolves their targets."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.states = {state.path: state for state in tree.states}

    def state(self, element: Xml.Element, node: Mapping, path: str, done: frozenset[str]) -> None:
        """Write a state into its element; the keys in ``done`` stand there already."""
        type_ = _text(node.get("type"))
        self.head(element, node, path, type_)
        done |= _STRUCTURE | _OF_TYPE.get(type_, frozenset())
        for key, value in node:
            if key.text not in done:
                Xml.SubElement(element, f"v:{key.text}").text = flow(value)
        self.data(element, node)
        for name, tag in _BLOCKS.items():
            block = node.get(name)
            if block is not None:
                self.actions(Xml.SubElement(element, tag), block)
        if type_ == "final":
            self.output(element, node)
        if type_ == "history":
            self.history(element, node, path)
        for trigger in _TRIGGERS:
            self.triggers(element, node, path, trigger)
        for word, child in _entries(node.get("states")):
            body = child if isinstance(child, Mapping) else Mapping([], child.where)
            inner = f"{path}.{word.text}" if path else word.text
            tag = _text(body.get("type")) or "state"
            self.state(Xml.SubElement(element, tag, {"id": inner}), body, inner, frozenset())

    def head(self, element: Xml.Element, node: Mapping, path: str, type_: str) -> None:
        initial = _text(node.get("initial"))
        if initial:
            element.set("initial", f"{path}.{initial}" if path else initial)
        if not path and type_:
            element.set("v:type", type_)

    def data(self, element: Xml.Element, node: Mapping) -> None:
        data = _entries(node.get("data"))
        if data:
            model = Xml.SubElement(element, "datamodel")
            for variable, value in data:
                Xml.SubElement(model, "data", {"id": variable.text, "expr": flow(value)})

    def output(self, element: Xml.Element, node: Mapping) -> None:
        output = _entries(node.get("output"))
        if output:
            donedata = Xml.SubElement(element, "donedata")
            for name, value in output:
                Xml.SubElement(donedata, "param", {"name": name.text, "expr": flow(value)})

    def history(self, element: Xml.Element, node: Mapping, path: str) -> None:
        element.set("type", "deep" if _text(node.get("deep")) == "true" else "shallow")
        around = path.rpartition(".")[0]
        target = _text(node.get("target"))
        where = f"{around}.{target}" if around else target
        Xml.SubElement(element, "transition", {"target": where})

    # -- transitions ------------------------------------------------------------------------

    def triggers(self, element: Xml.Element, node: Mapping, path: str, kind: str) -> None:
        value = node.get(kind)
        found: list[tuple[Scalar | None, YamlNode]] = [*_entries(value)]
        if kind == "always" and value is not None:
            found = [(None, value)]
        compound = node.get("states") is not None
        for key, alternatives in found:
            for item in _items(alternatives):
                transition = Xml.SubElement(element, "transition")
                if key is not None and kind == "on":
                    transition.set("event", event_of(key.text, path, compound))
                elif key is not None:
                    transition.set(f"v:{kind}", key.text)
                self.transition(transition, item, path)

    def transition(self, element: Xml.Element, node: YamlNode, path: str) -> None:
        if not isinstance(node, Mapping):
            node = Mapping([(Scalar("target", node.where), node)], node.where)
        for key, value in node:
            match key.text:
                case "target":
                    self.targets(element, value, path, _text(node.get("reenter")) == "true")
                case "guard":
                    element.set("cond", _text(value))
                case "actions":
                    self.actions(element, value)
                case other:
                    element.set(f"v:{other}", flow(value))

    def targets(self, element: Xml.Element, node: YamlNode, path: str, reenter: bool) -> None:
        source = self.states[path]
        scalars = [item for item in _items(node) if isinstance(item, Scalar)]
        targets = [self.tree.target(source, scalar) for scalar in scalars]
        element.set("target", " ".join(target.path for target in targets))
        if targets and not reenter and all(source.contains(target) for target in targets):
            element.set("type", "internal")

    # -- actions ----------------------------------------------------------------------------

    def actions(self, element: Xml.Element, node: YamlNode) -> None:
        for block in _items(node):
            for kind, value in _entries(block):
                self.action(element, kind.text, value)

    def action(self, element: Xml.Element, kind: str, node: YamlNode) -> None:
        match kind, node:
            case "set" | "append", Mapping(entries=entries):
                # Several at once: their right sides all come first.
                alone = kind == "set" and len(entries) == 1
                inside = element if alone else Xml.SubElement(element, f"v:{kind}")
                for name, value in entries:
                    assign = {"location": name.text, "expr": flow(value)}
                    Xml.SubElement(inside, "assign", assign)
            case "raise", Scalar(text=event):
                Xml.SubElement(element, "raise", {"event": event})
            case "raise", Mapping(entries=[(event, fields)]):
                Xml.SubElement(element, "raise", {"event": event.text, "v:with": flow(fields)})
            case "send", Mapping(entries=entries):
                words = {"event": "event", "id": "id", "delay": "delayexpr"}
                given = {words.get(k.text, f"v:{k.text}"): flow(value) for k, value in entries}
                Xml.SubElement(element, "send", given)
            case "cancel", _:
                Xml.SubElement(element, "cancel", {"sendidexpr": flow(node)})
            case "log", _:
                Xml.SubElement(element, "log", {"expr": flow(node)})
            case _:
                Xml.SubElement(element, f"v:{kind}").text = flow(node)


def event_of(trigger: str, path: str, compound: bool) -> str:
    """SCXML's name for an outcome: ``done`` is an event there, named after its state."""
    if trigger == "done" and path:
        return f"done.{'state' if compound else 'invoke'}.{path}"
    return trigger


def _entries(node: YamlNode | None) -> list[tuple[Scalar, YamlNode]]:
    return node.entries if isinstance(node, Mapping) else []


def _items(node: YamlNode) -> list[YamlNode]:
    return node.items if isinstance(node, Sequence) else [node]


def _text(node: YamlNode | None) -> str:
    return node.text if isinstance(node, Scalar) else ""
