"""Reads XML into elements with their places in the file; document types are refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from fsm.faults import Faults
from vencejo.errors import UserError, Where
from vencejo.nodes import MAX_BYTES, MAX_NODES

MAX_DEPTH = 100
"""64 states deep, and what stands inside the innermost."""

SCXML = "http://www.w3.org/2005/07/scxml"
OURS = "urn:vencejo:scxml:1"
"""The namespace of what SCXML lacks; its names begin with ``v:`` in :class:`Element`."""


@dataclass(slots=True)
class Element:
    """An XML element. SCXML's names have no prefix; those of our namespace begin with ``v:``."""

    tag: str
    attributes: dict[str, str]
    where: Where
    places: dict[str, Where] = field(default_factory=dict)
    """The place where the value of each attribute begins."""
    children: list[Element] = field(default_factory=list)
    text: str = ""
    """Its text without the white space around it."""
    text_where: Where | None = None
    file: Path | None = None
    """The file that its text comes from, by its `src`; None for the document itself."""

    def get(self, name: str) -> str | None:
        return self.attributes.get(name)

    def place(self, name: str) -> Where:
        """The place where an attribute's value begins; the element's for an unknown attribute."""
        return self.places.get(name, self.where)

    def all(self, *tags: str) -> Iterator[Element]:
        """The children with one of these tags."""
        return (child for child in self.children if child.tag in tags)

    def walk(self) -> Iterator[Element]:
        """This element and all inside it, in document order."""
        yield self
        for child in self.children:
            yield from child.walk()


def read_document(path: Path, shown_as: str | None = None) -> Element:
    """The root of an XML file. Raises UserError."""
    name = shown_as or str(path)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError("unreadable", f"cannot read '{name}': {reason}", Where(name)) from None
    root = parse_document(data, name)
    faults = Faults()
    for element in root.walk():
        if element.tag in ("data", "script") and element.get("src") is not None:
            with faults.collecting():
                _include(element, path.parent)
    faults.raise_any()
    return root


def sources(root: Element) -> list[Path]:
    """The files that the values and scripts of a document come from, each once."""
    files = (element.file for element in root.walk() if element.file is not None)
    return list(dict.fromkeys(files))


def _include(element: Element, folder: Path) -> None:
    """Read the text of an element from the file that its `src` names. Raises UserError."""
    source, where = element.attributes["src"], element.place("src")
    if element.text or element.children or element.get("expr") is not None:
        what = f"<{element.tag}> has a value beside its `src`"
        raise UserError("conflicting-values", what, where, "remove one")
    name = source.removeprefix("file:")
    path = folder / name
    if _SCHEME.match(name) or not path.resolve().is_relative_to(folder.resolve()):
        raise UserError(
            "not-supported",
            f"'{source}' is no file beside the document",
            where,
            "name a file in the document's own folder, or inside it",
        )
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError("unreadable", f"cannot read '{source}': {reason}", where) from None
    if len(data) > MAX_BYTES:
        raise UserError("too-large", f"'{source}' is larger than 1 MiB", where)
    try:
        element.text = data.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise UserError("not-text", f"'{source}' is no UTF-8 text", where) from None
    element.file, element.text_where = path, Where(name, 1, 1)


def parse_document(data: bytes | str, file: str) -> Element:
    """The root of an XML text. Raises UserError at the very line and column."""
    try:
        data = data.encode() if isinstance(data, str) else data
    except UnicodeEncodeError:
        raise UserError("not-text", "the text holds what is no letter", Where(file)) from None
    if len(data) > MAX_BYTES:
        raise UserError("too-large", "the file is larger than 1 MiB", Where(file))
    return _Parser(data, file).parse()


class _Parser:
    """Builds the tree from expat's events."""

    def __init__(self, data: bytes, file: str) -> None:
        self.data = data
        self.file = file
        self.open: list[Element] = []
        self.texts: list[list[str]] = []
        self.root: Element | None = None
        self.count = 0
        self.expat = expat.ParserCreate(namespace_separator=" ")
        # Unbuffered, so that a text is told of where it stands and not where it ends.
        self.expat.buffer_text = False
        self.expat.StartElementHandler = self.start
        self.expat.EndElementHandler = self.end
        self.expat.CharacterDataHandler = self.characters
        # Without a document type there are no entities that could grow or read files.
        self.expat.StartDoctypeDeclHandler = self.refuse

    def parse(self) -> Element:
        try:
            self.expat.Parse(self.data, True)
        except expat.ExpatError as error:
            where = Where(self.file, error.lineno, error.offset + 1)
            reason = expat.errors.messages[error.code]
            raise UserError("bad-xml", f"this is no XML: {reason}", where) from None
        except (ValueError, LookupError) as error:
            raise UserError("bad-xml", f"this is no XML: {error}", Where(self.file)) from None
        assert self.root is not None, "expat refuses a document without a root"
        return self.root

    def where(self) -> Where:
        line, column = self.expat.CurrentLineNumber, self.expat.CurrentColumnNumber
        return Where(self.file, line, column + 1)

    def refuse(self, *_: object) -> None:
        raise UserError(
            "document-type",
            "a document type is not accepted",
            self.where(),
            "remove `<!DOCTYPE …>`; no entity is needed in a state graph",
        )

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        where = self.where()
        self.count += 1 + len(attributes)
        if self.count > MAX_NODES:
            raise UserError("too-many-nodes", f"more than {MAX_NODES} values in one file", where)
        if len(self.open) >= MAX_DEPTH:
            raise UserError("too-deep", f"more than {MAX_DEPTH} elements nested", where)
        named = {_name(name): value for name, value in attributes.items()}
        element = Element(_name(tag), named, where)
        if named:
            self.locate(element)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)
        self.texts.append([])

    def locate(self, element: Element) -> None:
        """Find the places of the attributes: expat gives only that of the element."""
        begin = self.expat.CurrentByteIndex
        tag = _TAG.match(self.data, begin)
        for found in _ATTRIBUTE.finditer(tag[0]) if tag else ():
            before = self.data[begin : begin + found.end("open")]
            line = before.count(b"\n")
            last = before.rpartition(b"\n")[2].decode(errors="replace")
            first = element.where.column if line == 0 else 1
            place = Where(self.file, element.where.line + line, first + len(last))
            element.places[found["name"].decode(errors="replace")] = place

    def end(self, tag: str) -> None:
        self.open.pop().text = "".join(self.texts.pop()).strip()

    def characters(self, text: str) -> None:
        element = self.open[-1]
        if element.text_where is None and text.strip():
            blank = len(text) - len(text.lstrip())
            element.text_where = self.where().right(blank)
        self.texts[-1].append(text)


_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|/")
"""The beginning of an address, or of a path from the root of the file system."""
_TAG = re.compile(rb"<(?:[^>\"']|\"[^\"]*\"|'[^']*')*>")
_ATTRIBUTE = re.compile(rb"\s(?P<name>[^\s=\"'<>/]+)\s*=\s*(?P<open>[\"']).*?(?P=open)", re.DOTALL)
"""With its value, in which what looks like another attribute is none."""


def _name(name: str) -> str:
    """The short form of an expat name, which is ``namespace local``."""
    namespace, _, local = name.rpartition(" ")
    if namespace in ("", SCXML):
        return local
    return f"v:{local}" if namespace == OURS else f"{{{namespace}}}{local}"
