"""YAML nodes with the line and column of every value and key.

A file becomes a tree of :class:`Scalar`, :class:`Sequence` and :class:`Mapping`, built from
libyaml's events in one pass without recursion. Nothing is converted here: a scalar keeps its text
and whether it was quoted, so that each reader can type it by the place it fills (YAML 1.2: only
``true``, ``false``, ``null`` and decimal numbers are special). Anchors and ``<<`` are expanded;
repeated keys, explicit tags and keys that are no plain text are refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from vencejo.errors import UserError, Where
from vencejo.yaml_errors import control_character, place_in, syntax_error

MAX_BYTES = 1 << 20
MAX_NODES = 10_000
MAX_DEPTH = 200
"""Nested collections: 64 nested states need two each, and their contents some more."""

_PARSER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True)
class Scalar:
    """A scalar's text as written; ``plain`` when it has no quotes."""

    text: str
    where: Where
    plain: bool = True

    @property
    def null(self) -> bool:
        return self.plain and self.text in ("", "~", "null")


@dataclass(frozen=True, slots=True)
class Sequence:
    """A list."""

    items: list[YamlNode]
    where: Where


@dataclass(frozen=True, slots=True)
class Mapping:
    """A map in the order of the file, its keys as written."""

    entries: list[tuple[Scalar, YamlNode]]
    where: Where

    def get(self, key: str) -> YamlNode | None:
        for name, value in self.entries:
            if name.text == key:
                return value
        return None

    def __iter__(self) -> Iterator[tuple[Scalar, YamlNode]]:
        return iter(self.entries)


YamlNode = Scalar | Sequence | Mapping


def count(node: YamlNode) -> int:
    """The number of values in a node, itself and all keys included."""
    if isinstance(node, Mapping):
        return 1 + sum(1 + count(value) for _, value in node)
    if isinstance(node, Sequence):
        return 1 + sum(map(count, node.items))
    return 1


def kind(node: YamlNode) -> str:
    """Describe a node for an error message: ``a map``, ``a list``, ``nothing`` or its text."""
    if isinstance(node, Mapping):
        return "a map"
    if isinstance(node, Sequence):
        return "a list"
    return "nothing" if node.null else f"'{node.text}'"


def read_file(path: Path, shown_as: str | None = None) -> Mapping:
    """The map that a YAML file consists of; ``shown_as`` replaces the path in errors.

    Raises UserError for a file that cannot be read or is no YAML map.
    """
    name = shown_as or str(path)
    return read_text(read_plain(path, name, ".yaml"), name)


def read_plain(path: Path, name: str, ending: str) -> str:
    """The text of a file, which ``name`` stands for in errors; its like end in ``ending``.

    Raises UserError for a file that cannot be read, is no UTF-8 text or larger than 1 MiB.
    """
    place = Where(name)
    try:
        with path.open("rb") as file:
            # A device or pipe may have no end.
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise UserError("too-large", "the file is larger than 1 MiB", place)
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _not_utf8(data, error.start, name) from None
    except (FileNotFoundError, ValueError):
        raise UserError("no-such-file", f"there is no file '{name}'", place) from None
    except IsADirectoryError:
        hint = f"name a {ending} file inside it"
        raise UserError("not-a-file", f"'{name}' is a folder", place, hint) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError("unreadable", f"cannot read '{name}': {reason}", place) from None


def read_text(text: str, file: str) -> Mapping:
    """The map that a YAML text consists of; ``file`` is its name in errors.

    Raises UserError (see :func:`read_file`).
    """
    try:
        size = len(text.encode())
    except UnicodeEncodeError as error:
        message = f"the text holds what is no letter (position {error.start})"
        hint = "remove half of a surrogate pair"
        raise UserError("not-text", message, place_in(text, error.start, file), hint) from None
    if size > MAX_BYTES:
        raise UserError("too-large", "the text is larger than 1 MiB", Where(file))
    root = _Builder(file, text).build()
    if root is None:
        raise UserError("empty-file", "the file is empty", Where(file, 1, 1))
    if not isinstance(root, Mapping):
        raise UserError(
            "not-a-map", f"the file must be a map of keys and values, not {kind(root)}", root.where
        )
    return root


def _not_utf8(data: bytes, position: int, file: str) -> UserError:
    """The error of a file in another encoding than UTF-8, at its first byte that shows it."""
    before = data[:position].decode("utf-8-sig", "replace")
    place = place_in(before, len(before), file)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        other = "UTF-32" if data.startswith(b"\xff\xfe\0\0") else "UTF-16"
        return UserError("not-text", f"the file is {other}, not UTF-8", place, "save it as UTF-8")
    # Windows' own letters stand where Latin-1 has control characters.
    byte = data[position : position + 1]
    encoding, code = ("Windows-1252", "cp1252") if byte < b"\xa0" else ("Latin-1", "latin-1")
    letter = byte.decode(code, "replace")
    hint = f"save it as UTF-8; in {encoding} this would be '{letter}'"
    return UserError("not-text", "the file is no UTF-8 text from here on", place, hint)


@dataclass(slots=True)
class _Open:
    """A collection whose end has not been read yet."""

    node: Sequence | Mapping
    anchor: str | None
    first_node: int
    key: Scalar | None = None
    seen: dict[str, Where] = field(default_factory=dict)
    merged: list[tuple[Scalar, YamlNode]] = field(default_factory=list)


class _Builder:
    """Turns the events of one document into nodes."""

    def __init__(self, file: str, text: str) -> None:
        self.file = file
        self.text = text
        self.count = 0
        self.open: list[_Open] = []
        self.anchors: dict[str, tuple[YamlNode, int]] = {}
        self.root: YamlNode | None = None

    def build(self) -> YamlNode | None:
        try:
            for event in yaml.parse(self.text, Loader=_PARSER):
                self._take(event)
        except yaml.MarkedYAMLError as error:
            raise syntax_error(error, self.file, self.text) from None
        except yaml.YAMLError as error:
            # The reader's own: a character that may stand nowhere.
            raise control_character(self.text, self.file) or UserError(
                "bad-yaml", f"this is no YAML: {error}", Where(self.file, 1, 1)
            ) from None
        return self.root

    def _place(self, event: yaml.Event) -> Where:
        mark = event.start_mark
        assert mark is not None, "the parser marks every event"
        return Where(self.file, mark.line + 1, mark.column + 1)

    def _take(self, event: yaml.Event) -> None:
        if isinstance(event, yaml.ScalarEvent):
            where = self._place(event)
            self._refuse_tag(event, where)
            self._count(1, where)
            self._add(Scalar(event.value, where, plain=event.implicit[0]), event.anchor, 1)
        elif isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            where = self._place(event)
            self._refuse_tag(event, where)
            self._count(1, where)
            if len(self.open) >= MAX_DEPTH:
                raise UserError("too-deep", f"more than {MAX_DEPTH} levels of nesting", where)
            is_map = isinstance(event, yaml.MappingStartEvent)
            opened = Mapping([], where) if is_map else Sequence([], where)
            self.open.append(_Open(opened, event.anchor, self.count))
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            closed = self.open.pop()
            if isinstance(closed.node, Mapping):
                closed.node.entries.extend(
                    entry for entry in closed.merged if entry[0].text not in closed.seen
                )
            self._add(closed.node, closed.anchor, self.count - closed.first_node + 1)
        elif isinstance(event, yaml.AliasEvent):
            where = self._place(event)
            if event.anchor not in self.anchors:
                raise UserError(
                    "unknown-anchor",
                    f"'*{event.anchor}' names no anchor above it",
                    where,
                    'an event that takes all is written "*", with quotes',
                )
            node, size = self.anchors[event.anchor]
            self._count(size, where)
            self._add(node, None, size)
        elif isinstance(event, yaml.DocumentStartEvent) and self.root is not None:
            raise UserError(
                "two-documents",
                "a file holds one document; '---' starts a second",
                self._place(event),
            )

    def _count(self, nodes: int, where: Where) -> None:
        self.count += nodes
        if self.count > MAX_NODES:
            raise UserError("too-many-nodes", f"more than {MAX_NODES} values in one file", where)

    def _refuse_tag(self, event: yaml.NodeEvent, where: Where) -> None:
        tag = getattr(event, "tag", None)
        if tag is not None:
            shown = tag.replace("tag:yaml.org,2002:", "!!")
            raise UserError(
                "custom-tag",
                f"the tag '{shown}' is not part of the language",
                where,
                "remove it; a text that begins with '!' needs quotes, and a negation is `not`",
            )

    def _add(self, node: YamlNode, anchor: str | None, size: int) -> None:
        if anchor is not None:
            self.anchors[anchor] = (node, size)
        if not self.open:
            self.root = node
            return
        parent = self.open[-1]
        if isinstance(parent.node, Sequence):
            parent.node.items.append(node)
        elif parent.key is None:
            parent.key = self._key(node, parent)
        else:
            key, parent.key = parent.key, None
            if key.plain and key.text == "<<":
                parent.merged.extend(_merged(node))
            else:
                parent.node.entries.append((key, node))

    def _key(self, node: YamlNode, parent: _Open) -> Scalar:
        if not isinstance(node, Scalar):
            raise UserError(
                "bad-key",
                f"a key must be a text, not {kind(node)}",
                node.where,
                'a text with `{`, `[` or `${` in it must stand in quotes: "${…}"',
            )
        if not (node.plain and node.text == "<<"):
            if node.text in parent.seen:
                raise UserError(
                    "duplicate-key",
                    f"'{node.text}' stands twice in one map; first at {parent.seen[node.text]}",
                    node.where,
                    "join the two, or rename one",
                )
            parent.seen[node.text] = node.where
        return node


def _merged(node: YamlNode) -> list[tuple[Scalar, YamlNode]]:
    """The entries that ``<<`` merges; of several maps the earlier one takes precedence."""
    sources = node.items if isinstance(node, Sequence) else [node]
    entries: list[tuple[Scalar, YamlNode]] = []
    names: set[str] = set()
    for source in sources:
        if not isinstance(source, Mapping):
            raise UserError("bad-merge", f"`<<` takes a map, not {kind(source)}", source.where)
        for key, value in source.entries:
            if key.text not in names:
                names.add(key.text)
                entries.append((key, value))
    return entries
