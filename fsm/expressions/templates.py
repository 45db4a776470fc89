"""Texts with something inserted: ``height ${height:.1f}``, where ``$$`` is a dollar."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fsm.expressions.compiled import Evaluator
from fsm.values.functions import EvaluationError, as_text, shown
from vencejo.errors import UserError, Where

NAME = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*(?:\.[A-Za-z][A-Za-z0-9_]*)*)")
_FORMAT = re.compile(r"[+]?(?:\d{1,2})?(?:\.\d{1,2})?[dfeg%]?")


@dataclass(frozen=True)
class Inserted:
    """An expression inside a text, perhaps with a number format."""

    source: str
    format: str
    where: Where


def pieces(text: str, where: Where) -> Iterator[str | Inserted]:
    """The literal and the inserted parts of a text; ``$$`` is a dollar."""
    position = 0
    literal = ""
    while position < len(text):
        if text[position] != "$":
            literal += text[position]
            position += 1
            continue
        if text.startswith("$$", position):
            literal += "$"
            position += 2
            continue
        name = NAME.match(text, position)
        if name:
            inserted, end = Inserted(name[1], "", where.right(position + 1)), name.end()
        elif text.startswith("${", position):
            end = _closing(text, position + 2, where.right(position))
            source, format_ = _split_format(text[position + 2 : end])
            inserted, end = Inserted(source, format_, where.right(position + 2)), end + 1
        else:
            raise UserError(
                "lone-dollar",
                "a `$` stands before neither a name nor `{`",
                where.right(position),
                "write $$ for a dollar",
            )
        if literal:
            yield literal
            literal = ""
        yield inserted
        position = end
    if literal:
        yield literal


def _closing(text: str, start: int, where: Where) -> int:
    depth, quote = 0, ""
    for index in range(start, len(text)):
        letter = text[index]
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in "{[(":
            depth += 1
        elif letter in "}])":
            if depth == 0 and letter == "}":
                return index
            depth -= 1
    raise UserError("bad-expression", "`${` is not closed by `}`", where)


def _split_format(inside: str) -> tuple[str, str]:
    head, colon, tail = inside.rpartition(":")
    return (head, tail) if colon and _FORMAT.fullmatch(tail) and tail else (inside, "")


def formatted(function: Evaluator, format_: str) -> Evaluator:
    """A function that gives the value as text, in a number format if there is one."""

    def text(slots: list[Any], event: Mapping[str, Any] | None) -> str:
        value = function(slots, event)
        if not format_:
            return as_text(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise EvaluationError(f"{shown(value)} is no number to format")
        return format(int(value) if format_.endswith("d") else value, format_)

    return text
