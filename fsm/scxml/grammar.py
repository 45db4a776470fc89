"""The elements and attributes of SCXML that are read; everything else is refused by its name.

Elements and attributes of other namespaces are passed over, as the W3C wants it. ``<invoke>`` is
not among these: a document runs alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from fsm.scxml.document import Element
from vencejo.errors import Fault, nearest

STATES = ("state", "parallel", "final", "history")
ACTIONS = ("assign", "cancel", "foreach", "if", "log", "raise", "script", "send")
DATA_MODELS = ("ecmascript", "python", "null")

_ATTRIBUTES: Mapping[str, str] = {
    "scxml": "binding datamodel initial name version",
    "state": "id initial",
    "parallel": "id",
    "final": "id",
    "history": "id type",
    "initial": "",
    "transition": "cond event target type",
    "onentry": "",
    "onexit": "",
    "datamodel": "",
    "data": "expr id src",
    "donedata": "",
    "content": "expr",
    "param": "expr location name",
    "script": "src",
    "assign": "expr location",
    "raise": "event",
    "log": "expr label",
    "if": "cond",
    "elseif": "cond",
    "else": "",
    "foreach": "array index item",
    "send": "delay delayexpr event eventexpr id idlocation namelist target targetexpr type "
    "typeexpr",
    "cancel": "sendid sendidexpr",
}
_CHILDREN: Mapping[str, str] = {
    "scxml": "state parallel final datamodel script transition",
    "state": "onentry onexit transition initial datamodel state parallel final history",
    "parallel": "onentry onexit transition datamodel state parallel history",
    "final": "onentry onexit donedata",
    "history": "transition",
    "initial": "transition",
    "datamodel": "data",
    "donedata": "content param",
    "send": "content param",
    "param": "",
    "script": "",
    "raise": "",
    "log": "",
    "elseif": "",
    "else": "",
    "cancel": "",
}
"""Elements inside others; those not named here hold actions, or a value."""
_FIXED: Mapping[str, tuple[str, ...]] = {
    "version": ("1.0",),
    "datamodel": DATA_MODELS,
    "binding": ("early", "late"),
}
"""The attributes of the root that have one of a few values."""

_HINTS = {"invoke": "a document runs alone: put the states of the other into a <state> here"}
"""Hints for elements that are missed here."""


def grammar_faults(root: Element) -> Iterator[Fault]:
    """What in a document is not read."""
    for name, values in _FIXED.items():
        value = root.get(name)
        if value is not None and value not in values:
            message = f'{name}="{value}" is not supported'
            hint = nearest(value, values, f"known: {', '.join(values)}")
            yield Fault("not-supported", message, root.place(name), hint)
    yield from _faults(root)


def belongs(child: Element, parent: Element) -> bool:
    """Whether an element may stand inside another, as far as that is a matter of its kind."""
    inside = _CHILDREN.get(parent.tag)
    return inside is None or child.tag in inside.split()


def _faults(element: Element) -> Iterator[Fault]:
    known = _ATTRIBUTES[element.tag].split()
    for name in element.attributes:
        if name not in known and not name.startswith(("{", "v:")):
            message = f"<{element.tag}> has no attribute '{name}'"
            hint = nearest(name, known, "remove it")
            yield Fault("unknown-attribute", message, element.place(name), hint)
    for child in element.children:
        if child.tag.startswith(("{", "v:")):
            continue
        if not belongs(child, element):
            message = f"<{child.tag}> in <{element.tag}> is not supported"
            hint = _HINTS.get(child.tag) or nearest(child.tag, _CHILDREN[element.tag].split())
            yield Fault("not-supported", message, child.where, hint)
        elif child.tag in _ATTRIBUTES and element.tag not in ("assign", "data", "content"):
            yield from _faults(child)
