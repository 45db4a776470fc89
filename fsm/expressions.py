"""Expressions: a safe subset of Python with units, parsed, typed and compiled on load.

The user's text is parsed to Python's syntax tree; each node is translated, if it is on the list
below, to a piece of code of *ours* together with its type. Only that generated code is compiled,
with nothing in reach but the functions of :mod:`fsm.functions`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from fsm import functions as fn
from fsm.scope import CONFIGURATION_SLOT, TIME_SLOT, Binding, Define, Scope
from fsm.types import (
    ANY,
    BARE,
    BOOL,
    AnyType,
    Bool,
    ListOf,
    MapOf,
    Number,
    PointType,
    Text,
    Type,
    fits,
    join,
)
from vencejo.errors import UserError, Where, nearest
from vencejo.units import ANGLE, LENGTH, RATIO, UNITS, Dimension, in_unit

MAX_CHARACTERS = 1000
MAX_NODES = 200
MAX_COST = 10_000
"""Nodes of an expression with those of all defines it uses, each time it uses them."""

Function = Callable[[list[Any], Mapping[str, Any] | None], Any]
"""A compiled value: of an instance's slots and of the fields of the event at hand."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """An expression or literal ready to be evaluated."""

    type: Type
    function: Function
    source: str
    where: Where
    constant: bool = False

    def __call__(self, slots: list[Any], event: Mapping[str, Any] | None = None) -> Any:
        """The value. Raises EvaluationError, ArithmeticError, TypeError or ValueError."""
        return self.function(slots, event)

    def value(self) -> Any:
        """The value of a constant."""
        return self.function([], None)


def constant(value: Any, type_: Type, where: Where, source: str = "") -> Compiled:
    return Compiled(type_, lambda slots, event: value, source, where, constant=True)


def compile_expression(
    text: str,
    where: Where,
    scope: Scope,
    wanted: Type = ANY,
    arguments: Mapping[str, Type] | None = None,
) -> Compiled:
    """Parse, type and compile an expression. Raises UserError at the very column that is wrong."""
    translator = _Translator(text, where, scope, dict(arguments or {}))
    code, type_ = translator.translate()
    if not fits(wanted, type_):
        raise UserError(
            "wrong-dimension"
            if isinstance(type_, Number) and isinstance(wanted, Number)
            else "wrong-type",
            f"'{text}' is {type_}, but {wanted} is needed here",
            where,
        )
    names = ", ".join(["s", "e", *(f"a_{name}" for name in translator.arguments)])
    # `code` is made of our own pieces only: see the module's docstring.
    function = eval(compile(f"lambda {names}: {code}", f"<{where}>", "eval"), translator.namespace)
    constant_value = isinstance(translator.tree, ast.Constant) or not translator.reads
    return Compiled(type_, function, text, where, constant=constant_value and not arguments)


_UNIT_NAMES = "|".join(re.escape(unit) for unit in sorted(UNITS, key=len, reverse=True))
_QUANTITY = re.compile(
    rf"(?<![\w.])((?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)[ ]*({_UNIT_NAMES})(?![\w^])"
)
_STRING = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"")
_PLACEHOLDER = 0x20000
"""First of a run of letters (CJK extension B) that stand for quantities while Python parses."""

_COMPARE = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}
_ARITHMETIC = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_WORDS: dict[str, tuple[str, Type]] = {
    "true": ("True", BOOL),
    "false": ("False", BOOL),
    "null": ("None", ANY),
    "none": ("None", ANY),
}
_INSTEAD = {
    ast.Mod: "mod(a, b); after a number `%` is always per cent",
    ast.FloorDiv: "floor(a / b)",
    ast.Lambda: "a `define` with arguments",
    ast.JoinedStr: "a text with ${…} in it",
    ast.Slice: "a comprehension",
    ast.Is: "==",
    ast.IsNot: "!=",
    ast.BitAnd: "and",
    ast.BitOr: "or",
    ast.Dict: "a map in YAML, or a data variable",
    ast.NamedExpr: "a `define`",
}


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


class _Translator:
    """Turns one expression into code and type."""

    def __init__(self, text: str, where: Where, scope: Scope, arguments: dict[str, Type]) -> None:
        self.text = text
        self.where = where
        self.scope = scope
        self.arguments = arguments
        self.locals: dict[str, Type] = {}
        self.namespace: dict[str, Any] = {"__builtins__": {}}
        self.reads = False
        self.cost = 0
        self.tree = self._parse()

    def _parse(self) -> ast.expr:
        if len(self.text) > MAX_CHARACTERS:
            raise UserError(
                "expression-too-long",
                f"an expression has at most {MAX_CHARACTERS} characters",
                self.where,
                "give parts of it names in `define`",
            )
        if not self.text.strip():
            raise UserError("empty-expression", "an expression is missing here", self.where)
        if any(ord(letter) >= _PLACEHOLDER for letter in self.text):
            raise UserError("bad-expression", "a letter here is not allowed", self.where)
        masked, self.quantities = _mask_quantities(self.text)
        # One line, in parentheses, so that Python neither minds line ends nor leading blanks.
        self.source = f"({masked})".replace("\n", " ")
        try:
            tree = ast.parse(self.source, mode="eval").body
        except SyntaxError as error:
            column = max(0, min((error.offset or 2) - 2, len(self.text)))
            raise UserError(
                "bad-expression",
                f"'{self.text}' is no expression: {_plain(error)}",
                self.where.right(column),
                self._syntax_hint(),
            ) from None
        except (RecursionError, MemoryError, ValueError):
            raise UserError(
                "bad-expression", "this expression is nested too deeply", self.where
            ) from None
        self.cost = sum(isinstance(node, (ast.expr, ast.comprehension)) for node in ast.walk(tree))
        if self.cost > MAX_NODES:
            raise UserError(
                "expression-too-long",
                f"an expression has at most {MAX_NODES} parts; this one has {self.cost}",
                self.where,
                "give parts of it names in `define`",
            )
        return tree

    def _syntax_hint(self) -> str | None:
        unit = re.search(r"(?<![\w.])\d[\d.]*[ ]*([A-Za-z][\w/]*)", self.text)
        if (
            unit
            and unit[1] not in UNITS
            and unit[1] not in ("and", "or", "if", "else", "in", "not")
        ):
            return nearest(unit[1], UNITS, otherwise=f"'{unit[1]}' is no unit")
        if "&&" in self.text or "||" in self.text or "!" in self.text.replace("!=", ""):
            return "write `and`, `or`, `not`"
        if re.search(r"(?<![=<>!])=(?!=)", self.text):
            return "write `==` to compare"
        return None

    def translate(self) -> tuple[str, Type]:
        try:
            return self._visit(self.tree)
        except RecursionError:
            raise UserError(
                "bad-expression", "this expression is nested too deeply", self.where
            ) from None

    def _place(self, node: ast.AST) -> Where:
        offset = getattr(node, "col_offset", 1)
        column = len(self.source.encode()[:offset].decode()) - 1
        return self.where.right(max(0, column))

    def _fail(self, node: ast.AST, code: str, message: str, hint: str | None = None) -> NoReturn:
        raise UserError(code, message, self._place(node), hint)

    def _use(self, name: str, thing: Any) -> str:
        self.namespace[name] = thing
        return name

    def _visit(self, node: ast.expr) -> tuple[str, Type]:
        match node:
            case ast.Constant(value=value):
                return self._constant(node, value)
            case ast.Name():
                return self._name(node)
            case ast.Attribute():
                return self._attribute(node)
            case ast.Subscript():
                return self._subscript(node)
            case ast.UnaryOp():
                return self._unary(node)
            case ast.BinOp():
                return self._binary(node)
            case ast.BoolOp(op=op, values=values):
                word = " and " if isinstance(op, ast.And) else " or "
                return "(" + word.join(self._truth(value) for value in values) + ")", BOOL
            case ast.Compare():
                return self._compare(node)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                condition = self._truth(test)
                (a, type_a), (b, type_b) = self._visit(body), self._visit(orelse)
                self._alike(node, type_a, type_b, "the two alternatives")
                return f"({a} if {condition} else {b})", join(type_a, type_b)
            case ast.List(elts=elements) | ast.Tuple(elts=elements):
                return self._list(elements)
            case ast.Call():
                return self._call(node)
            case ast.ListComp():
                return self._comprehension(node)
        hint = next(
            (f"use {cure}" for kind, cure in _INSTEAD.items() if isinstance(node, kind)), None
        )
        self._fail(node, "bad-expression", "this is not part of the expression language", hint)

    def _constant(self, node: ast.expr, value: Any) -> tuple[str, Type]:
        if isinstance(value, bool) or value is None:
            return repr(value), BOOL if value is not None else ANY
        if isinstance(value, (int, float)):
            if not abs(value) < 1e300:
                self._fail(node, "bad-expression", "this number is too large")
            return repr(value), BARE
        if isinstance(value, str):
            return repr(value), Text((value,))
        self._fail(node, "bad-expression", "this is not part of the expression language")

    def _name(self, node: ast.Name) -> tuple[str, Type]:
        name = node.id
        if name in self.quantities:
            value, dimension = self.quantities[name]
            return repr(value), Number(dimension)
        if name in self.locals:
            return f"v_{name}", self.locals[name]
        if name in self.arguments:
            return f"a_{name}", self.arguments[name]
        if name in _WORDS:
            return _WORDS[name]
        found = self.scope.find(name)
        if isinstance(found, Binding):
            self.reads = True
            return self._binding(found), found.type
        if isinstance(found, Define):
            if found.arguments:
                self._fail(
                    node,
                    "wrong-arguments",
                    f"'{name}' takes {len(found.arguments)} arguments",
                    f"write {name}({', '.join(found.arguments)})",
                )
            return self._define(node, found, [])
        self._unknown(node, name)

    def _unknown(self, node: ast.AST, name: str) -> NoReturn:
        known = {*self.scope.visible(), *self.locals, *self.arguments}
        hint = nearest(name, known)
        host = next(
            (
                host
                for host in known
                if isinstance(self.scope.find(host), Binding)
                and name in _fields(self.scope.find(host))
            ),
            None,
        )
        if host:
            hint = f"did you mean '{host}.{name}'?"
        elif name in fn.FUNCTIONS or name == "active":
            hint = f"'{name}' is a function: write {name}(…)"
        elif not known:
            hint = "nothing is declared here; a text needs no `$`, and quotes inside an expression"
        self._fail(node, "unknown-name", f"the name '{name}' is unknown here", hint)

    def _binding(self, found: Binding) -> str:
        if found.kind == "event":
            return "e"
        if found.kind == "entered":
            return f"(s[{TIME_SLOT}] - s[{self.scope.entered_slot}])"
        return f"s[{found.slot}]"

    def _define(
        self, node: ast.AST, define: Define, given: list[tuple[str, Type]]
    ) -> tuple[str, Type]:
        if define.busy:
            self._fail(node, "endless-define", f"'{define.name}' is defined by itself")
        define.busy = True
        try:
            types = dict(zip(define.arguments, (type_ for _, type_ in given), strict=True))
            inner = _Translator(define.body.text, define.body.where, define.scope, types)
            code, type_ = inner.translate()
        finally:
            define.busy = False
        self.cost += inner.cost
        self.reads = self.reads or inner.reads
        if self.cost > MAX_COST:
            self._fail(node, "expression-too-long", "with its defines this expression is too large")
        self.namespace.update(
            {key: value for key, value in inner.namespace.items() if key != "__builtins__"}
        )
        if not given:
            return f"({code})", type_
        names = ", ".join(f"a_{name}" for name in define.arguments)
        return f"(lambda {names}: {code})({', '.join(code for code, _ in given)})", type_

    def _attribute(self, node: ast.Attribute) -> tuple[str, Type]:
        code, type_ = self._visit(node.value)
        name = node.attr
        if name.startswith("_"):
            self._fail(node, "unknown-field", f"there is no field '{name}'")
        if isinstance(type_, PointType):
            if name not in ("x", "y", "z"):
                self._fail(node, "unknown-field", f"a point has no '{name}'", "it has x, y and z")
            return f"{code}.{name}", Number(LENGTH)
        if isinstance(type_, MapOf) and type_.fields is not None:
            if name not in type_.fields:
                source = ast.unparse(node.value)
                self._fail(
                    node,
                    "unknown-field",
                    f"'{source}' has no '{name}'",
                    nearest(name, type_.fields),
                )
            # A known record: the host's and the behaviours' are objects, an event is a dict.
            if code == "e":
                return f"e[{name!r}]", type_.fields[name]
            return f"{code}.{name}", type_.fields[name]
        if isinstance(type_, (MapOf, AnyType)):
            return f"{self._use('field', fn.field)}({code}, {name!r})", ANY
        self._fail(node, "unknown-field", f"{type_} has no fields")

    def _subscript(self, node: ast.Subscript) -> tuple[str, Type]:
        code, type_ = self._visit(node.value)
        if isinstance(node.slice, ast.Slice):
            self._fail(node, "bad-expression", "slices are not part of the expression language")
        index, index_type = self._visit(node.slice)
        if isinstance(type_, ListOf) and not isinstance(index_type, (Number, AnyType)):
            self._fail(node.slice, "wrong-type", f"a list is indexed by a number, not {index_type}")
        if not isinstance(type_, (ListOf, MapOf, AnyType)):
            self._fail(node, "wrong-type", f"{type_} has no elements")
        result = type_.item if isinstance(type_, ListOf) else ANY
        return f"{self._use('item', fn.item)}({code}, {index})", result

    def _number(self, node: ast.expr) -> tuple[str, Number]:
        code, type_ = self._visit(node)
        if isinstance(type_, Number):
            return code, Number(type_.dimension)
        if isinstance(type_, AnyType):
            return f"{self._use('number', fn.number)}({code})", BARE
        self._fail(node, "wrong-type", f"a number is needed here, not {type_}")

    def _truth(self, node: ast.expr) -> str:
        code, type_ = self._visit(node)
        if isinstance(type_, Bool):
            return code
        if isinstance(type_, AnyType):
            return f"{self._use('truth', fn.truth)}({code})"
        self._fail(
            node,
            "wrong-type",
            f"true or false is needed here, not {type_}",
            "compare it to something",
        )

    def _unary(self, node: ast.UnaryOp) -> tuple[str, Type]:
        if isinstance(node.op, ast.Not):
            return f"(not {self._truth(node.operand)})", BOOL
        if isinstance(node.op, ast.Invert):
            self._fail(node, "bad-expression", "`~` is not part of the language", "use `not`")
        code, type_ = self._number(node.operand)
        return f"({'-' if isinstance(node.op, ast.USub) else '+'}{code})", type_

    def _binary(self, node: ast.BinOp) -> tuple[str, Type]:
        if isinstance(node.op, ast.Pow):
            base, type_ = self._number(node.left)
            exponent, power_type = self._number(node.right)
            if power_type.dimension not in (None, RATIO):
                self._fail(node.right, "wrong-dimension", f"an exponent cannot be {power_type}")
            return f"{self._use('power', fn.power)}({base}, {exponent})", _raised(type_, node.right)
        symbol = _ARITHMETIC.get(type(node.op))
        if symbol is None:
            cure = _INSTEAD.get(type(node.op))
            self._fail(
                node,
                "bad-expression",
                "this operator is not part of the language",
                cure and f"use {cure}",
            )
        left, a = self._number(node.left)
        right, b = self._number(node.right)
        if symbol in "+-":
            self._alike(node, a, b, f"the two sides of `{symbol}`")
            return f"({left} {symbol} {right})", join(a, b)
        return f"({left} {symbol} {right})", _product(a, b, 1 if symbol == "*" else -1)

    def _alike(self, node: ast.AST, a: Type, b: Type, what: str) -> None:
        if isinstance(a, Number) and isinstance(b, Number) and not fits(a, b):
            self._fail(node, "wrong-dimension", f"{what} are {a} and {b}")

    def _compare(self, node: ast.Compare) -> tuple[str, Type]:
        operands = [node.left, *node.comparators]
        codes = [self._visit(operand) for operand in operands]
        pieces = []
        for index, op in enumerate(node.ops):
            (left, a), (right, b) = codes[index], codes[index + 1]
            if isinstance(op, (ast.In, ast.NotIn)):
                if not isinstance(b, (ListOf, MapOf, Text, AnyType)):
                    self._fail(operands[index + 1], "wrong-type", f"nothing is in {b}")
                test = f"{self._use('contains', fn.contains)}({left}, {right})"
                pieces.append(f"(not {test})" if isinstance(op, ast.NotIn) else test)
                continue
            symbol = _COMPARE.get(type(op))
            if symbol is None:
                cure = _INSTEAD.get(type(op))
                self._fail(
                    node, "bad-expression", "this comparison is unknown", cure and f"use {cure}"
                )
            if symbol not in ("==", "!="):
                left, right = (
                    self._ordered(operands[index], left, a),
                    self._ordered(operands[index + 1], right, b),
                )
            elif not (fits(a, b) or fits(b, a)):
                code = (
                    "wrong-dimension"
                    if isinstance(a, Number) and isinstance(b, Number)
                    else "wrong-type"
                )
                self._fail(node, code, f"{a} and {b} are never equal")
            elif isinstance(a, Text) and isinstance(b, Text):
                self._one_of(operands[index + 1], a, b)
                self._one_of(operands[index], b, a)
            self._alike(node, a, b, f"the two sides of `{symbol}`")
            pieces.append(f"({left} {symbol} {right})")
        return (pieces[0] if len(pieces) == 1 else f"({' and '.join(pieces)})"), BOOL

    def _one_of(self, node: ast.expr, known: Text, given: Text) -> None:
        """A literal that is none of the words its other side can be is a typing mistake."""
        literal = isinstance(node, ast.Constant)
        if literal and len(known.choices) > 1 and given.choices[0] not in known.choices:
            self._fail(
                node,
                "unknown-word",
                f"'{given.choices[0]}' is none of the words it can be",
                nearest(given.choices[0], known.choices),
            )

    def _ordered(self, node: ast.expr, code: str, type_: Type) -> str:
        if isinstance(type_, Number):
            return code
        if isinstance(type_, AnyType):
            return f"{self._use('number', fn.number)}({code})"
        self._fail(node, "wrong-type", f"only numbers are more or less, not {type_}")

    def _list(self, elements: list[ast.expr]) -> tuple[str, Type]:
        codes, joined = [], None
        for element in elements:
            code, type_ = self._visit(element)
            codes.append(code)
            joined = type_ if joined is None else join(joined, type_)
        return f"[{', '.join(codes)}]", ListOf(joined or ANY)

    def _call(self, node: ast.Call) -> tuple[str, Type]:
        if not isinstance(node.func, ast.Name):
            self._fail(node, "unknown-function", "only the functions of the language can be called")
        name = node.func.id
        if node.keywords:
            self._fail(
                node, "wrong-arguments", f"{name}() takes its arguments in order, without names"
            )
        if name == "active":
            return self._active(node)
        found = self.scope.find(name)
        if isinstance(found, Define):
            if len(node.args) != len(found.arguments):
                self._fail(
                    node,
                    "wrong-arguments",
                    f"'{name}' takes {len(found.arguments)} arguments, not {len(node.args)}",
                )
            return self._define(node, found, [self._visit(argument) for argument in node.args])
        function = fn.FUNCTIONS.get(name)
        if function is None:
            defines = [
                known
                for known in self.scope.visible()
                if isinstance(self.scope.find(known), Define)
            ]
            self._fail(
                node,
                "unknown-function",
                f"there is no function '{name}'",
                nearest(name, [*fn.FUNCTIONS, "active", *defines]),
            )
        if not function.least <= len(node.args) <= function.most:
            count = (
                str(function.least)
                if function.least == function.most
                else f"{function.least} to {function.most}"
            )
            self._fail(
                node, "wrong-arguments", f"{name}() takes {count} arguments, not {len(node.args)}"
            )
        arguments = [
            self._comprehension(argument)
            if isinstance(argument, ast.GeneratorExp)
            else self._visit(argument)
            for argument in node.args
        ]
        result = function.result([type_ for _, type_ in arguments])
        if isinstance(result, str):
            self._fail(node, "wrong-type", f"{name}() {result}")
        codes = [
            f"{self._use('number', fn.number)}({code})"
            if isinstance(type_, AnyType) and name in _TAKES_NUMBERS
            else code
            for code, type_ in arguments
        ]
        return f"{self._use(f'f_{name}', function.call)}({', '.join(codes)})", result

    def _active(self, node: ast.Call) -> tuple[str, Type]:
        match node.args:
            case [ast.Constant(value=str(path))]:
                pass
            case _:
                self._fail(node, "wrong-arguments", "active() takes the path of a state in quotes")
        states = self.scope.all_states()
        if path not in states:
            self._fail(node, "unknown-state", f"there is no state '{path}'", nearest(path, states))
        self.reads = True
        return f"(s[{CONFIGURATION_SLOT}] >> {states[path]} & 1 == 1)", BOOL

    def _comprehension(self, node: ast.ListComp | ast.GeneratorExp) -> tuple[str, Type]:
        budget = self._use("Budget", fn.Budget)
        outermost = not self.locals
        names: list[str] = []
        pieces = []
        for generator in node.generators:
            if not isinstance(generator.target, ast.Name) or generator.is_async:
                self._fail(node, "bad-expression", "a comprehension names one variable after `for`")
            name = generator.target.id
            if name in self.locals or name in self.arguments or self.scope.find(name) is not None:
                self._fail(
                    generator.target,
                    "name-taken",
                    f"the name '{name}' is visible here already",
                    "choose another",
                )
            code, type_ = self._visit(generator.iter)
            if not isinstance(type_, (ListOf, AnyType)):
                self._fail(generator.iter, "wrong-type", f"a list is needed here, not {type_}")
            self.locals[name] = type_.item if isinstance(type_, ListOf) else ANY
            names.append(name)
            conditions = "".join(f" if {self._truth(test)}" for test in generator.ifs)
            pieces.append(f" for v_{name} in b.loop({code}){conditions}")
        element, type_ = self._visit(node.elt)
        for name in names:
            del self.locals[name]
        code = f"[{element}{''.join(pieces)}]"
        return (f"(lambda b: {code})({budget}())" if outermost else code), ListOf(type_)


_TAKES_NUMBERS = frozenset(
    [
        "abs",
        "clamp",
        "sign",
        "round",
        "floor",
        "sqrt",
        "sin",
        "cos",
        "atan2",
        "hypot",
        "wrap",
        "mod",
        "point",
    ]
)


def _fields(found: Binding | Define | None) -> Mapping[str, Type]:
    if isinstance(found, Binding) and isinstance(found.type, MapOf):
        return found.type.fields or {}
    return {}


def _product(a: Number, b: Number, sign: int) -> Number:
    """Any product with a bare number is bare, and angles count as bare there."""
    bare = (None, ANGLE)
    if a.dimension is None or b.dimension is None:
        return BARE
    if sign > 0 and (a.dimension in bare or b.dimension in bare):
        return BARE
    if sign < 0 and b.dimension == ANGLE and a.dimension != ANGLE:
        return BARE
    return Number(a.dimension.times(b.dimension, sign))


def _raised(base: Number, exponent: ast.expr) -> Number:
    if base.dimension is None:
        return BARE
    if isinstance(exponent, ast.Constant) and exponent.value == 2:
        return Number(base.dimension.times(base.dimension))
    return BARE


def _plain(error: SyntaxError) -> str:
    """Python's complaint without what only a programmer understands."""
    message = error.msg.split(". ")[0]
    return {"invalid syntax": "it cannot be read from here on"}.get(message, message)
