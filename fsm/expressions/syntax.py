"""The text of an expression: its limits, its units, and its syntax tree with places."""

from __future__ import annotations

import ast
import re
import warnings
from dataclasses import dataclass
from keyword import iskeyword

from vencejo.errors import Correction, UserError, Where, nearest
from vencejo.units import UNITS, UNSIGNED, Dimension, in_unit

MAX_CHARACTERS = 1000
MAX_NODES = 200

_UNIT_NAMES = "|".join(re.escape(unit) for unit in sorted(UNITS, key=len, reverse=True))
_QUANTITY = re.compile(rf"(?<![\w.])({UNSIGNED})[ ]*({_UNIT_NAMES})(?![\w^])")
_STRING = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"")
_PLACEHOLDER = 0x20000
"""The first of the letters (CJK extension B) that replace quantities while Python parses."""

_ADVISED = re.compile(r"\\|[0-9.][A-Za-z_]")
"""What Python's parser may warn of: escapes in texts, and numbers that touch a word (`5in x`)."""

_FORBIDDEN = re.compile(f"[\0\ud800-\udfff{chr(_PLACEHOLDER)}-\U0010ffff]")
_LINE_ENDS = str.maketrans("\n\r\f\v", "    ")


@dataclass(frozen=True, slots=True)
class Parsed:
    """An expression's tree, with the quantities that stand in it as names."""

    tree: ast.expr
    quantities: dict[str, tuple[float, Dimension]]
    source: str
    where: Where
    text: str

    @property
    def parts(self) -> int:
        """The number of expressions and comprehensions in it; slow, so it is seldom asked."""
        return sum(isinstance(node, (ast.expr, ast.comprehension)) for node in ast.walk(self.tree))

    def place(self, node: ast.AST) -> Where:
        """The place of a part of it in the file."""
        return self.where.right(self._column(getattr(node, "col_offset", 1)))

    def words(self, node: ast.expr) -> str:
        """A part of it as it was written."""
        if node.end_col_offset is None:
            return self.text.strip()
        begin, end = self._column(node.col_offset), self._column(node.end_col_offset)
        # Of a quantity, Python has seen one letter only.
        quantity = (
            _QUANTITY.match(self.text, end - 1) if self.source[end] in self.quantities else None
        )
        return self.text[begin : quantity.end() if quantity else end]

    def _column(self, offset: int) -> int:
        """The column in the text for an offset of Python's, which counts bytes."""
        return max(0, len(self.source.encode()[:offset].decode(errors="ignore")) - 1)


def parse(text: str, where: Where) -> Parsed:
    """Parse an expression. Raises UserError when it is none, or too large."""
    if len(text) > MAX_CHARACTERS:
        raise UserError(
            "expression-too-long",
            f"an expression has at most {MAX_CHARACTERS} characters",
            where,
            "give parts of it names in `define`",
        )
    if not text.strip():
        raise UserError("empty-expression", "an expression is missing here", where)
    letter = _FORBIDDEN.search(text)
    if letter:
        place = where.right(letter.start())
        raise UserError("bad-expression", "this letter is not allowed here", place)
    masked, quantities = _mask_quantities(text)
    word = masked.strip(" \t\n\r\f\v")
    if word in quantities or (word.isascii() and word.isidentifier() and not iskeyword(word)):
        # A name or a quantity by itself, as most values and durations are: that is known at once.
        column = 1 + masked.index(word)
        name = ast.Name(word, ast.Load(), lineno=1, col_offset=column)
        return Parsed(name, quantities, f"({masked})", where, text)
    # One line, in parentheses, so that Python neither minds line ends nor leading blanks.
    source = f"({masked})".translate(_LINE_ENDS)
    try:
        tree = _tree(source)
    except SyntaxError as error:
        column = max(0, min((error.offset or 2) - 2, len(text)))
        raise UserError(
            "bad-expression",
            f"'{text}' is no expression: {_plain(error)}",
            where.right(column),
            _hint(text),
        ) from None
    except (RecursionError, MemoryError, ValueError):
        raise too_deep(where) from None
    parsed = Parsed(tree, quantities, source, where, text)
    # Every part has a letter of its own, so that most need not be counted.
    if len(text) > MAX_NODES and parsed.parts > MAX_NODES:
        raise UserError(
            "expression-too-long",
            f"an expression has at most {MAX_NODES} parts; this one has {parsed.parts}",
            where,
            "give parts of it names in `define`",
        )
    return parsed


def _tree(source: str) -> ast.expr:
    """Python's syntax tree of an expression, without Python's own advice about it."""
    if not _ADVISED.search(source):
        # To silence warnings takes as long as to parse a short expression.
        return ast.parse(source, mode="eval").body
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ast.parse(source, mode="eval").body


def too_deep(where: Where) -> UserError:
    return UserError("bad-expression", "this expression is nested too deeply", where)


def _mask_quantities(text: str) -> tuple[str, dict[str, tuple[float, Dimension]]]:
    """The text with each quantity replaced by a name of equal length, and what they stand for."""
    found: dict[str, tuple[float, Dimension]] = {}

    def mask(match: re.Match[str]) -> str:
        name = chr(_PLACEHOLDER + len(found))
        found[name] = (in_unit(float(match[1]), match[2]), UNITS[match[2]][1])
        return name.ljust(len(match[0]))

    pieces, end = [], 0
    for string in _STRING.finditer(text):
        pieces += [_QUANTITY.sub(mask, text[end : string.start()]), string[0]]
        end = string.end()
    pieces.append(_QUANTITY.sub(mask, text[end:]))
    return "".join(pieces), found


def _hint(text: str) -> str | None:
    """A hint for syntax of other languages; None where nothing is recognized."""
    unit = re.search(r"(?<![\w.])\d[\d.]*[ ]*([A-Za-z][\w/]*)", text)
    if unit and unit[1] not in UNITS and unit[1] not in ("and", "or", "if", "else", "in", "not"):
        return nearest(unit[1], UNITS, otherwise=f"'{unit[1]}' is no unit")
    if "&&" in text or "||" in text or "!" in text.replace("!=", ""):
        hint = "write `and`, `or`, `not`"
        sign = re.search(r"\s*(&&|\|\|)\s*", text)
        meant = {"&&": " and ", "||": " or "}
        return Correction(sign[0], meant[sign[1]], hint) if sign else hint
    if re.search(r"(?<![=<>!:])=(?!=)", text):
        return "write `==` to compare"
    if re.search(r"\d\s*%\s*[\w(]", text):
        return "after a number `%` is per cent; the remainder is mod(a, b)"
    signs = {
        "a number has no leading zero": re.search(r"(?<![\w.])0\d", text),
        "names inside an expression are written without `$`": "$" in text,
    }
    return next((hint for hint, sign in signs.items() if sign), None)


def _plain(error: SyntaxError) -> str:
    """Python's message, in words for people who do not program."""
    message = error.msg.split(". ")[0]
    return {"invalid syntax": "it cannot be read from here on"}.get(message, message)
