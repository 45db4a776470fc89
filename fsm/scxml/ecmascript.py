"""Expressions of SCXML documents: a small, pure subset of ECMAScript, or its like in Python.

Numbers, texts, lists, ``true false null undefined``; ``?:``, ``|| && !``, comparison (``===`` too),
``+ - * / % **``, indexing, ``Math.…``, ``In('state')`` and ``.length``. Python's ``and or not True
False None`` mean the same. A recursive descent parser (one function for each level of precedence)
makes closures over an instance's slots; the user's text is never run as code. Unlike
ECMAScript, arithmetic on what is no number fails, and so raises ``error.execution``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from fsm.expressions.compiled import Evaluator
from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.scxml.ecmascript_values import LEVELS, MATH, OPERATORS, item, member, truth
from fsm.values.functions import bounded, number, power
from vencejo.errors import UserError, Where, nearest

MAX_LENGTH = 1000
MAX_NESTING = 50

_TOKEN = re.compile(
    r"""\s*(?:
    (?P<number>(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?![\w$]))
  | (?P<text>"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')
  | (?P<name>[A-Za-z_$][\w$]*)
  | (?P<sign>===|!==|\*\*=|==|!=|<=|>=|&&|\|\||\*\*|\+\+|--|[-+*/%]=|[-+*/%<>!=?:.,;()\[\]{}])
    )""",
    re.VERBOSE,
)
_PYTHON = {"and": "&&", "or": "||", "not": "not", "is": "==="}
_WORDS: Mapping[str, Any] = {
    "true": True,
    "True": True,
    "false": False,
    "False": False,
    "null": None,
    "None": None,
    "undefined": None,
}
_ASSIGNED = re.compile(r"(?:^|[;\n])[^\S\n]*(?:(?:var|let)\s+)?([A-Za-z_]\w*)\s*=(?!=)")
"""Blanks before a word end with the line: a script of empty lines is not read again from each."""
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "b": "\b", "f": "\f", "0": "\0"}


@dataclass(frozen=True, slots=True)
class Names:
    """The names that the expressions of a document can use."""

    variables: Mapping[str, int]
    """Name → slot."""
    states: Mapping[str, int]
    """Id → index in document order."""
    event_slot: int


@dataclass(frozen=True, slots=True)
class Assignment:
    """One statement of a script."""

    name: str
    value: Evaluator


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    where: Where


def compile_value(text: str, where: Where, names: Names) -> Evaluator:
    """Compile an expression to a function of slots. Raises UserError at the wrong column."""
    parser = _Parser(text, where, names)
    function = parser.expression()
    parser.end()
    return lambda slots, event: bounded(function(slots, event))


def compile_condition(text: str, where: Where, names: Names) -> Evaluator:
    """Compile an expression to a condition, true or false by ECMAScript's rules."""
    function = compile_value(text, where, names)
    return lambda slots, event: truth(function(slots, event))


def compile_script(text: str, where: Where, names: Names) -> list[Assignment]:
    """Compile a script of assignments. Raises UserError."""
    return _Parser(text, where, names).script()


def assigned_names(text: str) -> list[str]:
    """The variables that a script assigns."""
    return _ASSIGNED.findall(text)


class _Parser:
    """Parses one text by recursive descent."""

    def __init__(self, text: str, where: Where, names: Names) -> None:
        self.names = names
        self.where = where
        self.depth = 0
        if len(text) > MAX_LENGTH:
            raise UserError("expression-too-long", f"more than {MAX_LENGTH} characters", where)
        self.tokens = self.split(text)
        self.at = 0

    def split(self, text: str) -> list[_Token]:
        found: list[_Token] = []
        position = 0
        while text[position:].strip():
            match = _TOKEN.match(text, position)
            kind = match.lastgroup if match else None
            if match is None or kind is None:
                position += len(text[position:]) - len(text[position:].lstrip())
                self.fail(self.place(text, position), f"'{text[position]}' cannot be read here")
            word = match[kind]
            sign = _PYTHON.get(word) if kind == "name" else None
            place = self.place(text, match.start(kind))
            found.append(_Token("sign" if sign else kind, sign or word, place))
            position = match.end()
        found.append(_Token("end", "the end", self.place(text, len(text))))
        return found

    def place(self, text: str, position: int) -> Where:
        line = text.count("\n", 0, position)
        if line == 0:
            return self.where.right(position)
        column = position - text.rindex("\n", 0, position)
        return Where(self.where.file, self.where.line + line, column)

    def fail(self, where: Where, message: str, hint: str | None = None) -> NoReturn:
        raise UserError("bad-expression", message, where, hint)

    @property
    def token(self) -> _Token:
        return self.tokens[self.at]

    def take(self) -> _Token:
        token = self.token
        self.at += token.kind != "end"
        return token

    def accept(self, *signs: str) -> str | None:
        """The next token, if it is one of these signs."""
        token = self.token
        if token.kind == "sign" and token.text in signs:
            self.at += 1
            return token.text
        return None

    def expect(self, sign: str) -> None:
        if not self.accept(sign):
            self.fail(self.token.where, f"'{sign}' is missing before {self.token.text}")

    def end(self) -> None:
        if self.token.kind != "end":
            hint = "`===` compares" if self.token.text == "=" else None
            self.fail(self.token.where, f"'{self.token.text}' does not belong here", hint)

    # -- scripts ----------------------------------------------------------------------------

    def script(self) -> list[Assignment]:
        found = []
        while self.token.kind != "end":
            if self.accept(";"):
                continue
            if self.token.text in ("var", "let"):
                self.take()
            found.append(self.statement())
        return found

    def statement(self) -> Assignment:
        name = self.take()
        slot = self.slot(name)
        sign = self.accept("=", "+=", "-=", "*=", "/=", "%=", "**=", "++", "--")
        if sign is None:
            hint = "a script holds assignments only: x = …; y += …"
            self.fail(self.token.where, "an assignment is needed here", hint)
        if sign in ("++", "--"):
            step = 1 if sign == "++" else -1
            return Assignment(name.text, lambda s, e: bounded(number(s[slot]) + step))
        value = self.expression()
        if sign == "=":
            return Assignment(name.text, lambda s, e: bounded(value(s, e)))
        compute = OPERATORS[sign[:-1]]
        return Assignment(name.text, lambda s, e: bounded(compute(s[slot], value(s, e))))

    def slot(self, name: _Token) -> int:
        if name.kind != "name" or name.text not in self.names.variables:
            hint = nearest(name.text, self.names.variables)
            raise UserError("unknown-name", f"there is no variable '{name.text}'", name.where, hint)
        return self.names.variables[name.text]

    # -- expressions, loosest first ---------------------------------------------------------

    def expression(self) -> Evaluator:
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise UserError("expression-too-deep", "this is nested too deeply", self.token.where)
        test = self.either()
        if self.accept("?"):
            first = self.expression()
            self.expect(":")
            second, condition = self.expression(), test
            test = lambda s, e: first(s, e) if truth(condition(s, e)) else second(s, e)  # noqa: E731
        self.depth -= 1
        return test

    def either(self) -> Evaluator:
        left = self.both()
        while self.accept("||"):
            left = _short(left, self.both(), until=True)
        return left

    def both(self) -> Evaluator:
        left = self.negation()
        while self.accept("&&"):
            left = _short(left, self.negation(), until=False)
        return left

    def negation(self) -> Evaluator:
        """Python's ``not`` takes the whole comparison after it, unlike ``!``."""
        if self.count("not") % 2:
            operand = self.binary(0)
            return lambda s, e: not truth(operand(s, e))
        return self.binary(0)

    def count(self, sign: str) -> int:
        """Take a sign as often as it is repeated here; the count."""
        found = 0
        while self.accept(sign):
            found += 1
        return found

    def binary(self, level: int) -> Evaluator:
        if level == len(LEVELS):
            return self.unary()
        left = self.binary(level + 1)
        while sign := self.accept(*LEVELS[level]):
            left = _both(LEVELS[level][sign], left, self.binary(level + 1))
        return left

    def unary(self) -> Evaluator:
        sign = self.accept("!", "-", "+")
        if sign is None:
            base = self.postfix()
            return _both(power, base, self.unary()) if self.accept("**") else base
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise UserError("expression-too-deep", "this is nested too deeply", self.token.where)
        operand = self.unary()
        self.depth -= 1
        if sign == "!":
            return lambda s, e: not truth(operand(s, e))
        factor = -1 if sign == "-" else 1
        return lambda s, e: factor * number(operand(s, e))

    def postfix(self) -> Evaluator:
        value = self.primary()
        while sign := self.accept(".", "["):
            if sign == ".":
                if self.token.kind != "name":
                    self.fail(self.token.where, f"'{self.token.text}' is no name of a field")
                value = _with(member, value, self.take().text)
            else:
                index = self.expression()
                self.expect("]")
                value = _both(item, value, index)
        return value

    def primary(self) -> Evaluator:
        token = self.take()
        if token.kind == "number":
            text = token.text
            whole = text.isdigit() or text[:2] in ("0x", "0X")
            return _constant(int(text, 0 if "x" in text.lower() else 10) if whole else float(text))
        if token.kind == "text":
            return _constant(re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), token.text[1:-1]))
        if token.kind == "name":
            return self.name(token)
        if token.text == "(":
            inner = self.expression()
            self.expect(")")
            return inner
        if token.text == "[":
            elements = self.elements("]")
            return lambda s, e: [element(s, e) for element in elements]
        what = "nothing follows" if token.kind == "end" else f"'{token.text}' cannot stand here"
        self.fail(token.where, what)

    def elements(self, closing: str) -> list[Evaluator]:
        found: list[Evaluator] = []
        while not self.accept(closing):
            if found:
                self.expect(",")
            found.append(self.expression())
        return found

    def name(self, token: _Token) -> Evaluator:
        name = token.text
        if name in _WORDS:
            return _constant(_WORDS[name])
        if name == "_event":
            slot = self.names.event_slot
            return lambda s, e: s[slot]
        if name == "In":
            return self.is_in(token)
        if name == "Math":
            return self.math()
        slot = self.slot(token)
        return lambda s, e: s[slot]

    def is_in(self, token: _Token) -> Evaluator:
        self.expect("(")
        state = self.take()
        self.expect(")")
        id_ = state.text[1:-1]
        if state.kind != "text" or id_ not in self.names.states:
            hint = nearest(id_, self.names.states)
            raise UserError("unknown-state", f"there is no state {state.text}", state.where, hint)
        index = self.names.states[id_]
        return lambda s, e: s[CONFIGURATION_SLOT] >> index & 1 == 1

    def math(self) -> Evaluator:
        self.expect(".")
        name = self.take()
        if name.text == "PI":
            return _constant(math.pi)
        if name.text not in MATH:
            hint = nearest(name.text, MATH)
            message = f"there is no function 'Math.{name.text}'"
            raise UserError("unknown-function", message, name.where, hint)
        least, most, function = MATH[name.text]
        self.expect("(")
        arguments = self.elements(")")
        if not least <= len(arguments) <= most:
            self.fail(name.where, f"Math.{name.text} does not take {len(arguments)} arguments")
        return lambda s, e: function(*(number(argument(s, e)) for argument in arguments))


def _constant(value: Any) -> Evaluator:
    return lambda s, e: value


def _with(compute: Callable[[Any, Any], Any], left: Evaluator, right: Any) -> Evaluator:
    return lambda s, e: compute(left(s, e), right)


def _both(compute: Callable[[Any, Any], Any], left: Evaluator, right: Evaluator) -> Evaluator:
    return lambda s, e: compute(left(s, e), right(s, e))


def _short(left: Evaluator, right: Evaluator, until: bool) -> Evaluator:
    """``||`` and ``&&``: the value of the first operand that decides, or of the last."""

    def value(slots: list[Any], event: Mapping[str, Any] | None) -> Any:
        first = left(slots, event)
        return first if truth(first) is until else right(slots, event)

    return value
