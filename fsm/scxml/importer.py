"""Imports missions that :mod:`fsm.scxml.writer` exported as SCXML.

The document is turned into YAML nodes with the places of the document, which the reader of missions
then reads: all its rules and messages hold here too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from fsm.language.includes import mission_of
from fsm.language.spec import MissionSpec
from fsm.scxml.document import Element
from fsm.scxml.writer import DATAMODEL
from vencejo.errors import UserError, Where, nearest
from vencejo.nodes import Mapping, Scalar, Sequence, YamlNode, read_text

_STATES = ("state", "parallel", "final", "history")
_BLOCKS = {"onentry": "entry", "onexit": "exit", "v:throughout": "throughout"}
_NAMED = {"donedata": ("output", "param", "name"), "datamodel": ("data", "data", "id")}
"""Elements that stand for a map: its key, the elements inside, their attribute with the name."""
_TRIGGERS = {"event": "on", "v:when": "when", "v:after": "after"}
_ATTRIBUTES = {
    "transition": {"event", "cond", "target", "type"},
    "assign": {"location", "expr"},
    "raise": {"event"},
    "cancel": {"sendidexpr"},
    "log": {"expr"},
}
"""Beside ours; of a `send` every attribute is a key of the mission."""
_SEND = {"event": "event", "id": "id", "delayexpr": "delay"}

YamlEntry = tuple[Scalar, YamlNode]


def is_mission(root: Element) -> bool:
    """Whether a document is an exported mission, by its data model."""
    return root.get("datamodel") == DATAMODEL


def import_mission(root: Element, file: str, folder: Path | None = None) -> MissionSpec:
    """The mission of a document of the form that :func:`fsm.scxml.writer.write_scxml` writes.

    The files that it includes lie in ``folder``. Raises UserError with all mistakes of form.
    """
    if root.tag != "scxml":
        raise UserError("not-scxml", f"<{root.tag}> is no SCXML document", root.where)
    importer = _Importer(root)
    body = importer.state(root, "")
    name = root.get("name")
    if name is not None:
        body.entries.insert(0, (_key("mission", root), Scalar(name, root.place("name"))))
    return mission_of(body, file, name or "mission", folder)


class _Importer:
    """Turns elements into YAML nodes, and ids of targets into names that YAML looks up."""

    def __init__(self, root: Element) -> None:
        self.children: dict[str, set[str]] = {}
        for element in root.walk():
            if element.tag in (*_STATES, "scxml"):
                names = {_name(child, element) for child in element.all(*_STATES)}
                self.children[element.get("id") or ""] = names

    def state(self, element: Element, path: str) -> Mapping:
        entries = [*self.head(element, path)]
        for child in element.children:
            if child.tag not in (*_STATES, "transition"):
                entries.append(self.part(child))
        entries += self.history(element, path) if element.tag == "history" else ()
        entries += self.triggers(element, path) if element.tag != "history" else ()
        inner: list[YamlEntry] = []
        for child in element.all(*_STATES):
            name = Scalar(_name(child, element), child.place("id"))
            inner.append((name, self.state(child, child.attributes["id"])))
        if inner:
            entries.append((_key("states", element), Mapping(inner, element.where)))
        return Mapping(entries, element.where)

    def head(self, element: Element, path: str) -> Iterator[YamlEntry]:
        """The `type` and `initial` of a state."""
        if element.get("v:type") is not None:
            yield _key("type", element), _attribute(element, "v:type")
        elif element.tag in ("parallel", "final", "history"):
            yield _key("type", element), Scalar(element.tag, element.where)
        if element.get("initial") is not None:
            yield _key("initial", element), self.within(element, "initial", path)

    def part(self, child: Element) -> YamlEntry:
        """Read an element inside a state that stands for one of its keys. Raises UserError."""
        if child.tag in _BLOCKS:
            return _key(_BLOCKS[child.tag], child), self.actions(child.children)
        if child.tag in _NAMED:
            key, tag, name = _NAMED[child.tag]
            return _named(key, child, child.all(tag), name)
        if child.tag.startswith("v:"):
            return _key(child.tag[2:], child), _content(child)
        message = f"<{child.tag}> is not part of a mission"
        raise UserError("not-supported", message, child.where)

    def history(self, element: Element, path: str) -> Iterator[YamlEntry]:
        if element.get("type") == "deep":
            yield _key("deep", element), Scalar("true", element.place("type"))
        for transition in element.all("transition"):
            around = path.rpartition(".")[0]
            yield _key("target", transition), self.within(transition, "target", around)

    def within(self, element: Element, attribute: str, path: str) -> Scalar:
        """The id in an attribute, relative to the state of ``path``."""
        scalar = _attribute(element, attribute)
        prefix = f"{path}." if path else ""
        return replace(scalar, text=scalar.text.removeprefix(prefix))

    # -- transitions ------------------------------------------------------------------------

    def triggers(self, element: Element, path: str) -> Iterator[YamlEntry]:
        """The transitions of a state by kind; those of one trigger become its alternatives."""
        kinds: dict[str, list[tuple[Scalar, list[YamlNode]]]] = {}
        for transition in element.all("transition"):
            attribute = next((name for name in _TRIGGERS if transition.get(name)), None)
            kind = _TRIGGERS[attribute] if attribute else "always"
            key = _attribute(transition, attribute) if attribute else _key("always", transition)
            if key.text in (f"done.state.{path}", f"done.invoke.{path}"):
                key = replace(key, text="done")
            found = kinds.setdefault(kind, [])
            alternative = self.transition(transition, path)
            if found and found[-1][0].text == key.text:
                found[-1][1].append(alternative)
            else:
                found.append((key, [alternative]))
        for kind, triggers in kinds.items():
            if kind == "always":
                ((key, alternatives),) = triggers
                yield key, Sequence(alternatives, key.where)
                continue
            entries: list[YamlEntry] = []
            for key, alternatives in triggers:
                if any(key.text == other.text for other, _ in entries):
                    message = f"the alternatives of '{key.text}' must follow each other"
                    raise UserError("duplicate-key", message, key.where)
                entries.append((key, Sequence(alternatives, key.where)))
            yield _key(kind, element), Mapping(entries, element.where)

    def transition(self, element: Element, path: str) -> YamlNode:
        _refuse_foreign(element)
        entries: list[YamlEntry] = []
        ids = (element.get("target") or "").split()
        if ids:
            where = element.place("target")
            targets: list[YamlNode] = [Scalar(self.relative(path, id_), where) for id_ in ids]
            entries.append((_key("target", element), Sequence(targets, where)))
            inside = all(id_.startswith(f"{path}." if path else "") for id_ in ids)
            if path and inside and element.get("type") != "internal":
                entries.append((_key("reenter", element), Scalar("true", element.where)))
        if element.get("cond") is not None:
            entries.append((_key("guard", element), _attribute(element, "cond")))
        known = {*(name for name in _TRIGGERS), *(key.text for key, _ in entries)}
        for name in element.attributes:
            if name.startswith("v:") and name not in known and name[2:] not in known:
                entries.append((_key(name[2:], element), _value(element, name)))
        if element.children:
            entries.append((_key("actions", element), self.actions(element.children)))
        return Mapping(entries, element.where)

    def relative(self, source: str, target: str) -> str:
        """The name by which a YAML target in the state ``source`` means the state ``target``."""
        nearer: set[str] = set()
        place = source
        while True:
            prefix = f"{place}." if place else ""
            inside = target.removeprefix(prefix)
            first = inside.partition(".")[0]
            if target.startswith(prefix) and inside != "" and first not in nearer:
                return inside
            nearer |= self.children.get(place, set())
            if not place:
                return target
            place = place.rpartition(".")[0]

    # -- actions ----------------------------------------------------------------------------

    def actions(self, elements: Iterable[Element]) -> Sequence:
        blocks: list[YamlNode] = []
        where = Where("")
        for element in elements:
            where = element.where
            blocks.append(Mapping([_action(element)], where))
        return Sequence(blocks, where)


def _action(element: Element) -> YamlEntry:
    _refuse_foreign(element)
    read = _ACTIONS.get(element.tag)
    if read is not None:
        return read(element)
    if element.tag.startswith("v:"):
        return _key(element.tag[2:], element), _content(element)
    raise UserError("not-supported", f"<{element.tag}> is no action of a mission", element.where)


def _raise(element: Element) -> YamlEntry:
    event = _attribute(element, "event")
    if element.get("v:with") is None:
        return _key("raise", element), event
    return _key("raise", element), Mapping([(event, _value(element, "v:with"))], event.where)


def _send(element: Element) -> YamlEntry:
    entries: list[YamlEntry] = [
        (_key(_SEND.get(name, name.removeprefix("v:")), element), _value(element, name))
        for name in element.attributes
    ]
    return _key("send", element), Mapping(entries, element.where)


def _several(element: Element) -> YamlEntry:
    """A `set` or `append` of several variables at once."""
    return _named(element.tag[2:], element, element.all("assign"), "location")


_ACTIONS: dict[str, Callable[[Element], YamlEntry]] = {
    "assign": lambda element: _named("set", element, [element], "location"),
    "v:set": _several,
    "v:append": _several,
    "raise": _raise,
    "send": _send,
    "cancel": lambda element: (_key("cancel", element), _value(element, "sendidexpr")),
    "log": lambda element: (_key("log", element), _value(element, "expr")),
}
"""The readers of actions; any other action is an element of its own name in our namespace."""


def _refuse_foreign(element: Element) -> None:
    """Raise UserError for attributes and elements of other programs, which would be lost."""
    known = _ATTRIBUTES.get(element.tag, element.attributes)
    for name in element.attributes:
        if name not in known and not name.startswith(("v:", "{")):
            message = f"`{name}` of <{element.tag}> is not part of a mission"
            raise UserError("not-supported", message, element.place(name), nearest(name, known))
    inside = element.tag in ("transition", "v:set", "v:append")
    for child in element.children if not inside else ():
        message = f"<{child.tag}> in <{element.tag}> is not part of a mission"
        raise UserError("not-supported", message, child.where)


def _name(child: Element, parent: Element) -> str:
    """A state's own name; its id is its path."""
    around, id_ = parent.get("id"), child.get("id") or ""
    prefix = f"{around}." if around else ""
    name = id_.removeprefix(prefix)
    if not id_.startswith(prefix) or not name or "." in name:
        message = f"the id '{id_}' is not the state's path"
        raise UserError("wrong-id", message, child.place("id"), f"{prefix}name")
    return name


def _key(name: str, element: Element) -> Scalar:
    return Scalar(name, element.where)


def _attribute(element: Element, name: str) -> Scalar:
    text = element.get(name)
    if text is None:
        message = f"<{element.tag}> needs `{name}`"
        raise UserError("missing-attribute", message, element.where)
    return Scalar(text, element.place(name))


def _named(key: str, element: Element, parts: Iterable[Element], name: str) -> YamlEntry:
    """A map whose names and values are the attribute ``name`` and the `expr` of elements."""
    entries: list[YamlEntry] = [(_attribute(part, name), _value(part, "expr")) for part in parts]
    return _key(key, element), Mapping(entries, element.where)


def _value(element: Element, attribute: str) -> YamlNode:
    """The YAML value in an attribute."""
    scalar = _attribute(element, attribute)
    return _yaml(scalar.text, scalar.where)


def _content(element: Element) -> YamlNode:
    """The YAML value that is an element's text."""
    return _yaml(element.text, element.text_where or element.where)


_LEAD = "v: "


def _yaml(text: str, where: Where) -> YamlNode:
    """Read one YAML value, with its places in the document. Raises UserError."""
    try:
        node = read_text(_LEAD + text, where.file)
    except UserError as error:
        moved = [
            replace(f, where=_moved(f.where, where) if f.where else None) for f in error.faults
        ]
        raise UserError.of(moved) from None
    if len(node.entries) != 1:
        raise UserError("bad-yaml", "one value belongs here", where)
    return _shift(node.entries[0][1], where)


def _moved(place: Where, where: Where) -> Where:
    if place.line > 1:
        return Where(where.file, where.line + place.line - 1, place.column)
    return where.right(max(0, place.column - 1 - len(_LEAD)))


def _shift(node: YamlNode, where: Where) -> YamlNode:
    place = _moved(node.where, where)
    match node:
        case Scalar():
            return replace(node, where=place)
        case Sequence(items=items):
            return Sequence([_shift(item, where) for item in items], place)
        case Mapping(entries=entries):
            moved: list[YamlEntry] = []
            for key, value in entries:
                moved.append((replace(key, where=_moved(key.where, where)), _shift(value, where)))
            return Mapping(moved, place)
