"""Splits a text of ECMAScript into words, numbers, texts and signs (ECMA-262, chapter 12)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NoReturn

from vencejo.errors import UserError, Where

_NOT_RUN = """
function class new this super async await yield delete void instanceof in let const var
=> ... ?? ?. ` , ++ -- += -= *= /= %= **= <<= >>= >>>= &= |= ^= &&= ||= ??=
"""
NOT_RUN = frozenset(_NOT_RUN.split())
"""Words and signs of ECMAScript that are not run here."""
_RESERVED = """
break case catch continue debugger default do else enum export extends finally for if import return
switch throw try typeof while with
"""
RESERVED = frozenset(_RESERVED.split())
"""Words of ECMAScript that begin no value."""

_TOKEN = re.compile(
    r"""\s*(?:
    (?P<number>(?:0[xX][0-9a-fA-F]+|0[oO][0-7]+|0[bB][01]+
        |(?:(?:0|[1-9]\d*)(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)(?![\w$]))
  | (?P<text>"(?:[^"\\\n]|\\[\s\S])*"|'(?:[^'\\\n]|\\[\s\S])*')
  | (?P<name>(?:[^\W\d]|\$)[\w$]*)
  | (?P<sign>===|!==|\*\*=|>>>=|<<=|>>=|&&=|\|\|=|\?\?=|\.\.\.|>>>|=>|==|!=|<=|>=|<<|>>|&&|\|\|
        |\?\?|\?\.(?!\d)|\*\*|\+\+|--|[-+*/%&|^]=|[-+*/%<>!=?:.,;()\[\]{}&|^~`])
    )""",
    re.VERBOSE,
)
_ESCAPE = re.compile(
    r"\\(?:u\{([0-9a-fA-F]{1,6})\}|u([0-9a-fA-F]{4})|x([0-9a-fA-F]{2})|(\r\n|[\s\S]))"
)
_LETTERS = {"n": "\n", "t": "\t", "r": "\r", "b": "\b", "f": "\f", "v": "\v", "0": "\0"}
_LETTERS |= dict.fromkeys(("\n", "\r", "\r\n", "\u2028", "\u2029"), "")
"""The letters that stand for others after a backslash; a line's end there is left out."""


@dataclass(frozen=True, slots=True)
class Token:
    """A word, number, text or sign; the last token of a text is of the kind ``end``."""

    kind: str
    text: str
    where: Where


def split(text: str, where: Where) -> list[Token]:
    """The tokens of a text that begins at a place. Raises UserError (``bad-expression``)."""
    found: list[Token] = []
    position = 0
    while text[position:].strip():
        match = _TOKEN.match(text, position)
        kind = match.lastgroup if match else None
        if match is None or kind is None:
            position += len(text[position:]) - len(text[position:].lstrip())
            fail(_place(text, position, where), f"'{text[position]}' cannot be read here")
        found.append(Token(kind, match[kind], _place(text, match.start(kind), where)))
        position = match.end()
    found.append(Token("end", "the end", _place(text, len(text), where)))
    return found


def _place(text: str, position: int, where: Where) -> Where:
    line = text.count("\n", 0, position)
    if line == 0:
        return where.right(position)
    column = position - text.rindex("\n", 0, position)
    return Where(where.file, where.line + line, column)


def unescaped(token: Token) -> str:
    """The text that a literal stands for. Raises UserError for an escape that is none."""
    text = token.text[1:-1]

    def letter(match: re.Match[str]) -> str:
        braced, four, two, plain = match.groups()
        code = braced or four or two
        if code:
            if int(code, 16) > 0x10FFFF:
                fail(token.where, f"there is no letter \\u{{{code}}}")
            return chr(int(code, 16))
        octal = plain == "0" and text[match.end() : match.end() + 1].isdigit()
        if octal or plain in "123456789":
            fail(token.where, f"'\\{plain}' is no escape: write \\x or \\u")
        if plain in "ux":
            fail(token.where, f"'\\{plain}' needs the number of a letter after it")
        return _LETTERS.get(plain, plain)

    found = _ESCAPE.sub(letter, text)
    # Two halves of a letter, each of them escaped, make one.
    found = found.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    if "\ufffd" in found and "\ufffd" not in text:
        fail(token.where, "half of a letter stands here alone")
    return found


def fail(where: Where, message: str, hint: str | None = None) -> NoReturn:
    """Raise UserError for what is no ECMAScript."""
    raise UserError("bad-expression", message, where, hint)
