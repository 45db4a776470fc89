"""The ECMAScript data model: a small, pure part of the language, with its own values.

Numbers, texts, lists, maps, ``true false null undefined NaN Infinity``; ``?:``, ``|| && !``,
comparison, arithmetic, bitwise operators, ``typeof``, fields and elements, ``Math.…`` and
``In('state')``. What is read here means what it means in ECMAScript (ECMA-262); well-formed
ECMAScript beyond that is refused, and so is nothing taken for something else. A recursive descent
parser makes closures over an instance's slots; the user's text is never run as code.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from fsm.expressions.compiled import Evaluator
from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.scxml.datamodel import (
    Assignment,
    DataModel,
    Location,
    Names,
    declared_variable,
    undeclared,
)
from fsm.scxml.ecmascript_tokens import NOT_RUN, RESERVED, Token, fail, split, unescaped
from fsm.scxml.ecmascript_values import (
    LEVELS,
    MATH,
    OPERATORS,
    POWER,
    inverted,
    item,
    kept,
    kind,
    negative,
    number_of,
    store,
    text_of,
    truth,
)
from fsm.values.null import NULL
from vencejo.errors import UserError, Where, nearest

MAX_LENGTH = 1000
MAX_NESTING = 50

_WORDS: Mapping[str, Any] = {
    "true": True,
    "false": False,
    "null": NULL,
    "undefined": None,
    "NaN": math.nan,
    "Infinity": math.inf,
}
_ASSIGNED = re.compile(
    r"(?:^|[;\n])[^\S\n]*(?:(?:var|let|const)\s+)?((?:[^\W\d]|\$)[\w$]*)\s*=(?!=)"
)
"""Blanks before a word end with the line: a script of empty lines is not read again from each."""
_PRECEDENCE = {sign: level for level, signs in enumerate(LEVELS) for sign in signs}
_PREFIXES: Mapping[str, Callable[[Any], Any]] = {
    "!": lambda value: not truth(value),
    "-": negative,
    "+": number_of,
    "~": inverted,
}


def compile_value(text: str, where: Where, names: Names) -> Evaluator:
    """Compile an expression to a function of slots. Raises UserError at the wrong column."""
    function = _whole_text(text, where, names)
    return lambda slots, event: kept(function(slots, event))


def compile_condition(text: str, where: Where, names: Names) -> Evaluator:
    """Compile an expression to a condition, true or false by ECMAScript's rules."""
    function = _whole_text(text, where, names)
    return lambda slots, event: truth(function(slots, event))


def compile_location(text: str, where: Where, names: Names) -> Location:
    """Compile what stands on the left of an assignment. Raises UserError."""
    parser = _Parser(text, where, names)
    location = parser.location()
    parser.end()
    return location


def compile_script(text: str, where: Where, names: Names) -> list[Assignment]:
    """Compile a script of assignments. Raises UserError."""
    return _Parser(text, where, names).script()


def assigned_names(text: str) -> list[str]:
    """The variables that a script assigns."""
    return _ASSIGNED.findall(text)


def _whole_text(text: str, where: Where, names: Names) -> Evaluator:
    parser = _Parser(text, where, names)
    function = parser.expression()
    parser.end()
    return function


class _Parser:
    """Parses one text by recursive descent."""

    def __init__(self, text: str, where: Where, names: Names) -> None:
        self.names = names
        self.where = where
        self.depth = 0
        if len(text) > MAX_LENGTH:
            raise UserError("expression-too-long", f"more than {MAX_LENGTH} characters", where)
        self.tokens = split(text, where)
        self.at = 0

    def refuse(self, token: Token, message: str, hint: str | None = None) -> NoReturn:
        """Raise UserError for a token that cannot stand where it does."""
        if token.kind in ("name", "sign") and token.text in NOT_RUN:
            message = f"'{token.text}' is a part of ECMAScript that is not run here"
            raise UserError("not-supported", message, token.where, hint)
        fail(token.where, message, hint)

    @property
    def token(self) -> Token:
        return self.tokens[self.at]

    def take(self) -> Token:
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
            self.refuse(self.token, f"'{sign}' is missing before {self.token.text}")

    def end(self) -> None:
        token = self.token
        if token.kind == "end":
            return
        before = self.tokens[self.at - 1]
        assignable = before.kind == "name" or before.text == "]"
        if token.text == "=" and assignable and before.text not in _WORDS:
            message = "an assignment inside an expression is not run here"
            raise UserError("not-supported", message, token.where, "`==` compares")
        hint = {"=": "`==` compares", "and": "`&&`", "or": "`||`", "is": "`===`"}.get(token.text)
        self.refuse(token, f"'{token.text}' does not belong here", hint)

    def nest(self) -> None:
        """Count one more level of nesting, which the caller takes back."""
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise UserError("expression-too-deep", "this is nested too deeply", self.token.where)

    # -- scripts ----------------------------------------------------------------------------

    def script(self) -> list[Assignment]:
        found = []
        while self.token.kind != "end":
            if self.accept(";"):
                continue
            if self.token.text in ("var", "let", "const"):
                self.take()
            found.append(self.statement())
        return found

    def statement(self) -> Assignment:
        if self.token.kind != "name" or self.token.text in RESERVED | NOT_RUN:
            self.no_assignment()
        current = self.tokens[self.at]
        location = self.location()
        sign = self.accept("=", "++", "--", *(f"{operator}=" for operator in OPERATORS))
        if sign is None:
            self.no_assignment()
        if sign == "=":
            return Assignment(location, _kept(self.expression()))
        present = self.present(location, current)
        if sign in ("++", "--"):
            step = 1 if sign == "++" else -1
            return Assignment(location, lambda s, e: kept(number_of(present(s, e)) + step))
        return Assignment(location, _kept(_both(OPERATORS[sign[:-1]], present, self.expression())))

    def no_assignment(self) -> NoReturn:
        hint = "a script holds assignments only: x = …; y += …"
        raise UserError("not-supported", "an assignment is needed here", self.token.where, hint)

    def present(self, location: Location, first: Token) -> Evaluator:
        """The present value at a location, which began with the token ``first``."""
        value = self.variable(first)
        for key in location.keys:
            value = _both(item, value, key)
        return value

    def location(self) -> Location:
        """What can be assigned: a variable, with fields and elements behind it."""
        name = self.take()
        if name.kind != "name" or name.text in RESERVED or name.text in _WORDS:
            message = f"{name.text} is no variable"
            raise UserError("bad-location", message, name.where)
        slot = declared_variable(name.text, name.where, self.names)
        keys: list[Evaluator] = []
        while sign := self.accept(".", "["):
            keys.append(self.key(sign))
        return Location(name.text, slot, keys, item, store)

    # -- expressions, loosest first ---------------------------------------------------------

    def expression(self) -> Evaluator:
        self.nest()
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
        left = self.binary(0)
        while self.accept("&&"):
            left = _short(left, self.binary(0), until=False)
        return left

    def binary(self, loosest: int) -> Evaluator:
        """Operators of two sides that bind at least as tightly as those of a level."""
        left = self.unary()
        while (token := self.token).kind == "sign":
            level = _PRECEDENCE.get(token.text, -1)
            if level < loosest:
                break
            self.take()
            left = _both(OPERATORS[token.text], left, self.binary(level + 1))
        return left

    def unary(self, power: bool = True) -> Evaluator:
        """Signs before a value; ``power`` says whether `**` may follow it."""
        sign = self.accept(*_PREFIXES)
        if sign is not None:
            self.nest()
            operand, compute = self.unary(power=False), _PREFIXES[sign]
            self.depth -= 1
            return lambda s, e: compute(operand(s, e))
        if self.token.kind == "name" and self.token.text == "typeof":
            return self.type_of()
        base = self.postfix()
        place = self.token.where
        if not self.accept("**"):
            return base
        if not power:
            fail(place, "put the power, or what stands before it, in parentheses")
        return _both(POWER, base, self.unary())

    def type_of(self) -> Evaluator:
        self.take()
        name, after = self.token, self.tokens[min(self.at + 1, len(self.tokens) - 1)]
        if name.kind == "name" and not self.is_known(name.text) and after.text not in ".[(":
            self.take()
            return _constant("undefined")
        self.nest()
        operand = self.unary(power=False)
        self.depth -= 1
        return lambda s, e: kind(operand(s, e))

    def is_known(self, name: str) -> bool:
        return (
            name in self.names.variables
            or name in _WORDS
            or name in RESERVED | NOT_RUN
            or name in ("In", "Math")
        )

    def postfix(self) -> Evaluator:
        value = self.primary()
        while sign := self.accept(".", "["):
            value = _both(item, value, self.key(sign))
        if self.token.text == "(" and self.token.kind == "sign":
            message = "calls other than In('state') and Math.… are not run here"
            raise UserError("not-supported", message, self.token.where)
        return value

    def key(self, sign: str) -> Evaluator:
        """The key behind ``.`` or inside ``[]``."""
        if sign == ".":
            if self.token.kind != "name":
                self.refuse(self.token, f"'{self.token.text}' is no name of a field")
            return _constant(self.take().text)
        index = self.expression()
        self.expect("]")
        return index

    def primary(self) -> Evaluator:
        token = self.take()
        if token.kind == "number":
            return _constant(number_of(token.text))
        if token.kind == "text":
            return _constant(unescaped(token))
        if token.kind == "name":
            return self.name(token)
        if token.text == "(":
            inner = self.expression()
            self.expect(")")
            return inner
        if token.text == "[":
            elements = self.elements("]")
            return lambda s, e: [element(s, e) for element in elements]
        if token.text == "{":
            return self.map()
        if token.text == "/":
            raise UserError("not-supported", "patterns are not run here", token.where)
        what = "nothing follows" if token.kind == "end" else f"'{token.text}' cannot stand here"
        self.refuse(token, what)

    def elements(self, closing: str) -> list[Evaluator]:
        found: list[Evaluator] = []
        while not self.accept(closing):
            if found:
                self.expect(",")
                if self.accept(closing):
                    break
            found.append(self.expression())
        return found

    def map(self) -> Evaluator:
        fields: list[tuple[str, Evaluator]] = []
        while not self.accept("}"):
            if fields:
                self.expect(",")
                if self.accept("}"):
                    break
            key = self.take()
            if key.kind not in ("name", "text", "number"):
                self.refuse(key, f"'{key.text}' is no name of a field")
            if key.kind == "name" and self.token.text in (",", "}"):
                fields.append((key.text, self.name(key)))
                continue
            self.expect(":")
            text = unescaped(key) if key.kind == "text" else key.text
            name = text_of(number_of(text)) if key.kind == "number" else text
            fields.append((name, self.expression()))
        return lambda s, e: {name: value(s, e) for name, value in fields}

    def name(self, token: Token) -> Evaluator:
        name = token.text
        if name in _WORDS:
            return _constant(_WORDS[name])
        if name in NOT_RUN or name in RESERVED:
            self.refuse(token, f"'{name}' cannot stand here")
        if name == "In" and self.token.text == "(":
            return self.is_in()
        if name == "Math" and self.token.text == ".":
            return self.math()
        return self.variable(token)

    def variable(self, token: Token) -> Evaluator:
        slot = self.names.slot(token.text, token.where)
        return undeclared(token.text) if slot is None else _slot(slot)

    def is_in(self) -> Evaluator:
        self.expect("(")
        token, after = self.token, self.tokens[min(self.at + 1, len(self.tokens) - 1)]
        argument = self.expression()
        self.expect(")")
        if token.kind == "text" and after.text == ")":
            self.names.state(unescaped(token), token.where)
        states = self.names.states

        def active(slots: list[Any], event: Mapping[str, Any] | None) -> bool:
            index = states.get(text_of(argument(slots, event)))
            return index is not None and slots[CONFIGURATION_SLOT] >> index & 1 == 1

        return active

    def math(self) -> Evaluator:
        self.expect(".")
        name = self.take()
        if name.text == "PI":
            return _constant(math.pi)
        if name.text not in MATH:
            hint = nearest(name.text, MATH)
            message = f"there is no function 'Math.{name.text}' here"
            raise UserError("unknown-function", message, name.where, hint)
        least, most, function = MATH[name.text]
        self.expect("(")
        arguments = self.elements(")")
        if not least <= len(arguments) <= most:
            message = f"Math.{name.text} does not take {len(arguments)} arguments here"
            raise UserError("not-supported", message, name.where)
        return lambda s, e: function(*(argument(s, e) for argument in arguments))


def _constant(value: Any) -> Evaluator:
    return lambda s, e: value


def _slot(slot: int) -> Evaluator:
    return lambda s, e: s[slot]


def _kept(value: Evaluator) -> Evaluator:
    return lambda s, e: kept(value(s, e))


def _both(compute: Callable[[Any, Any], Any], left: Evaluator, right: Evaluator) -> Evaluator:
    return lambda s, e: compute(left(s, e), right(s, e))


def _short(left: Evaluator, right: Evaluator, until: bool) -> Evaluator:
    """``||`` and ``&&``: the value of the first operand that decides, or of the last."""

    def value(slots: list[Any], event: Mapping[str, Any] | None) -> Any:
        first = left(slots, event)
        return first if truth(first) is until else right(slots, event)

    return value


ECMASCRIPT = DataModel(
    compile_value,
    compile_condition,
    compile_location,
    compile_script,
    assigned_names,
    text_of,
    null=NULL,
)
