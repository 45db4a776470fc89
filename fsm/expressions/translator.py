"""Translates the syntax tree of an expression to Python code of our own, and finds its type."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from fsm.expressions.scope import CONFIGURATION_SLOT, TIME_SLOT, Binding, Define, Scope, start
from fsm.expressions.syntax import parse, too_deep
from fsm.values import functions as fn
from fsm.values.types import (
    ANY,
    BARE,
    BOOL,
    MAX_NUMBER,
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
    join_all,
    product,
    raised,
)
from vencejo.errors import UserError, Where, nearest
from vencejo.units import LENGTH, RATIO

MAX_COST = 10_000
"""The most parts of an expression, those of all defines included, counted at each use."""

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

_FOREIGN = "this is not part of the expression language"

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


class Translator:
    """Translates one expression to code, and finds its type."""

    def __init__(
        self, text: str, where: Where, scope: Scope, arguments: Mapping[str, Type]
    ) -> None:
        self.scope = scope
        self.arguments = arguments
        self.locals: dict[str, Type] = {}
        self.namespace: dict[str, Any] = {"__builtins__": {}}
        self.reads: set[str] = set()
        """The kinds of the names that its value depends on; empty for a constant."""
        self.loops = False
        """True with comprehensions, whose steps are counted in ``b``."""
        scope.size.add_expression(where.file)
        self.parsed = parse(text, where)
        self.defined = 0
        """The number of parts of the defines it uses."""
        self._objects: set[str] = set()
        """Pieces of code whose value is an object of the host, read by attributes."""

    @property
    def cost(self) -> int:
        """The number of its parts, those of the defines it uses included."""
        return self.parsed.parts + self.defined

    def translate(self) -> tuple[str, Type]:
        """The code and the type of the whole expression. Raises UserError."""
        try:
            return self.visit(self.parsed.tree)
        except RecursionError:
            raise too_deep(self.parsed.where) from None

    def fail(self, node: ast.AST, code: str, message: str, hint: str | None = None) -> NoReturn:
        raise UserError(code, message, self.parsed.place(node), hint)

    def use(self, name: str, thing: Any) -> str:
        """Give the code a name for something that it calls; the name."""
        self.namespace[name] = thing
        return name

    def visit(self, node: ast.expr) -> tuple[str, Type]:
        """The code and the type of a part of the expression. Raises UserError."""
        self.scope.size.parts += 1
        visitor = _VISITORS.get(type(node))
        if visitor is None:
            cures = (f"use {cure}" for kind, cure in _INSTEAD.items() if isinstance(node, kind))
            self.fail(node, "bad-expression", _FOREIGN, next(cures, None))
        return visitor(self, node)

    def _constant(self, node: ast.Constant) -> tuple[str, Type]:
        value = node.value
        if isinstance(value, bool) or value is None:
            return repr(value), BOOL if value is not None else ANY
        if isinstance(value, (int, float)):
            if not abs(value) < MAX_NUMBER:
                self.fail(node, "bad-expression", "this number is too large")
            return repr(value), BARE
        if isinstance(value, str):
            return repr(value), Text((value,))
        self.fail(node, "bad-expression", _FOREIGN)

    def _name(self, node: ast.Name) -> tuple[str, Type]:
        name = node.id
        if name in self.parsed.quantities:
            value, dimension = self.parsed.quantities[name]
            if not abs(value) < MAX_NUMBER:
                self.fail(node, "bad-expression", "this number is too large")
            return repr(value), Number(dimension)
        if name in self.locals:
            return f"v_{name}", self.locals[name]
        if name in self.arguments:
            return f"a_{name}", self.arguments[name]
        if name in _WORDS:
            return _WORDS[name]
        found = self.scope.find(name)
        if isinstance(found, Binding):
            self.reads.add(found.kind)
            code = self._binding(found)
            if found.kind in ("host", "published"):
                self._objects.add(code)
            return code, found.type
        if isinstance(found, Define):
            if found.arguments:
                self.fail(
                    node,
                    "wrong-arguments",
                    f"'{name}' takes {len(found.arguments)} arguments",
                    f"write {name}({', '.join(found.arguments)})",
                )
            return self.define(node, found, [])
        self._unknown(node, name)

    def _unknown(self, node: ast.AST, name: str) -> NoReturn:
        known = {*self.scope.visible(), *self.locals, *self.arguments}
        hint = nearest(name, known)
        host = next(self.scope.with_field(name), None)
        if host:
            hint = f"did you mean '{host}.{name}'?"
        elif name in fn.FUNCTIONS or name == "active":
            hint = f"'{name}' is a function: write {name}(…)"
        elif not known:
            hint = "nothing is declared here; a text needs no `$`, and quotes inside an expression"
        self.fail(node, "unknown-name", f"the name '{name}' is unknown here", hint)

    def _binding(self, found: Binding) -> str:
        if found.kind == "event":
            return "e"
        if found.kind == "entered":
            return f"(s[{TIME_SLOT}] - s[{self.scope.entered_slot}])"
        return f"s[{found.slot}]"

    def define(
        self, node: ast.AST, define: Define, given: list[tuple[str, Type]]
    ) -> tuple[str, Type]:
        if define.busy:
            self.fail(node, "endless-define", f"'{define.name}' is defined by itself")
        define.busy = True
        try:
            types = dict(zip(define.arguments, (type_ for _, type_ in given), strict=True))
            inner = Translator(define.body.text, start(define.body), define.scope, types)
            code, type_ = inner.translate()
        finally:
            define.busy = False
        self.defined += inner.cost
        self.reads |= inner.reads
        self.loops = self.loops or inner.loops
        if self.cost > MAX_COST:
            self.fail(node, "expression-too-long", "with its defines this expression is too large")
        self.namespace.update(
            {key: value for key, value in inner.namespace.items() if key != "__builtins__"}
        )
        if not given:
            return f"({code})", type_
        names = ", ".join(f"a_{name}" for name in define.arguments)
        return f"(lambda {names}: {code})({', '.join(code for code, _ in given)})", type_

    def _attribute(self, node: ast.Attribute) -> tuple[str, Type]:
        code, type_ = self.visit(node.value)
        name = node.attr
        if name.startswith("_"):
            self.fail(node, "unknown-field", f"there is no field '{name}'")
        if isinstance(type_, PointType):
            if name not in ("x", "y", "z"):
                self.fail(node, "unknown-field", f"a point has no '{name}'", "it has x, y and z")
            return self._part(code, name, fn.field), Number(LENGTH)
        if isinstance(type_, MapOf) and type_.fields is not None:
            if name not in type_.fields:
                what = ast.unparse(node.value)
                hint = nearest(name, type_.fields)
                self.fail(node, "unknown-field", f"'{what}' has no '{name}'", hint)
            return self._part(code, name, fn.part), type_.fields[name]
        if isinstance(type_, (MapOf, AnyType)):
            return f"{self.use('field', fn.field)}({code}, {name!r})", ANY
        self.fail(node, "unknown-field", f"{type_} has no fields")

    def _part(self, code: str, name: str, function: Callable[[Any, str], Any]) -> str:
        """The code that reads a field which is declared."""
        if code in self._objects:
            self._objects.add(f"{code}.{name}")
            return f"{code}.{name}"
        return f"{self.use(function.__name__, function)}({code}, {name!r})"

    def _subscript(self, node: ast.Subscript) -> tuple[str, Type]:
        code, type_ = self.visit(node.value)
        if isinstance(node.slice, ast.Slice):
            self.fail(node, "bad-expression", "slices are not part of the expression language")
        index, index_type = self.visit(node.slice)
        if isinstance(type_, ListOf) and not isinstance(index_type, (Number, AnyType)):
            self.fail(node.slice, "wrong-type", f"a list is indexed by a number, not {index_type}")
        if not isinstance(type_, (ListOf, MapOf, AnyType)):
            self.fail(node, "wrong-type", f"{type_} has no elements")
        result = type_.item if isinstance(type_, ListOf) else ANY
        return f"{self.use('item', fn.item)}({code}, {index})", result

    def _number(self, node: ast.expr) -> tuple[str, Number]:
        code, type_ = self.visit(node)
        if isinstance(type_, Number):
            return code, Number(type_.dimension)
        if isinstance(type_, AnyType):
            return f"{self.use('number', fn.number)}({code})", BARE
        self.fail(node, "wrong-type", f"a number is needed here, not {type_}")

    def truth(self, node: ast.expr) -> str:
        """The code of a part that must be true or false."""
        code, type_ = self.visit(node)
        if isinstance(type_, Bool):
            return code
        if isinstance(type_, AnyType):
            return f"{self.use('truth', fn.truth)}({code})"
        self.fail(
            node,
            "wrong-type",
            f"true or false is needed here, not {type_}",
            "compare it to something",
        )

    def _unary(self, node: ast.UnaryOp) -> tuple[str, Type]:
        if isinstance(node.op, ast.Not):
            return f"(not {self.truth(node.operand)})", BOOL
        if isinstance(node.op, ast.Invert):
            self.fail(node, "bad-expression", "`~` is not part of the language", "use `not`")
        code, type_ = self._number(node.operand)
        return f"({'-' if isinstance(node.op, ast.USub) else '+'}{code})", type_

    def _binary(self, node: ast.BinOp) -> tuple[str, Type]:
        if isinstance(node.op, ast.Pow):
            base, type_ = self._number(node.left)
            exponent, power_type = self._number(node.right)
            if power_type.dimension not in (None, RATIO):
                self.fail(node.right, "wrong-dimension", f"an exponent cannot be {power_type}")
            squared = isinstance(node.right, ast.Constant) and node.right.value == 2
            return f"{self.use('power', fn.power)}({base}, {exponent})", raised(type_, squared)
        symbol = _ARITHMETIC.get(type(node.op))
        if symbol is None:
            cure = _INSTEAD.get(type(node.op))
            self.fail(
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
        return f"({left} {symbol} {right})", product(a, b, 1 if symbol == "*" else -1)

    def _logic(self, node: ast.BoolOp) -> tuple[str, Type]:
        word = " and " if isinstance(node.op, ast.And) else " or "
        return "(" + word.join(self.truth(value) for value in node.values) + ")", BOOL

    def _choice(self, node: ast.IfExp) -> tuple[str, Type]:
        condition = self.truth(node.test)
        (a, type_a), (b, type_b) = self.visit(node.body), self.visit(node.orelse)
        self._alike(node, type_a, type_b, "the two alternatives")
        return f"({a} if {condition} else {b})", join(type_a, type_b)

    def _alike(self, node: ast.AST, a: Type, b: Type, what: str) -> None:
        if isinstance(a, Number) and isinstance(b, Number) and not fits(a, b):
            self.fail(node, "wrong-dimension", f"{what} are {a} and {b}")

    def _compare(self, node: ast.Compare) -> tuple[str, Type]:
        operands = [node.left, *node.comparators]
        found = [self.visit(operand) for operand in operands]
        if isinstance(node.ops[0], (ast.In, ast.NotIn)) and len(node.ops) == 1:
            (element, _), (collection, type_) = found
            if not isinstance(type_, (ListOf, MapOf, Text, AnyType)):
                self.fail(operands[1], "wrong-type", f"nothing is in {type_}")
            test = f"{self.use('contains', fn.contains)}({element}, {collection})"
            return (f"(not {test})" if isinstance(node.ops[0], ast.NotIn) else test), BOOL
        ordered = [code for code, _ in found]
        symbols = []
        for index, op in enumerate(node.ops):
            symbol = _COMPARE.get(type(op))
            if symbol is None:
                cure = _INSTEAD.get(type(op), "`and` between two comparisons")
                self.fail(node, "bad-expression", "this comparison is unknown", f"use {cure}")
            symbols.append(symbol)
            self._comparable(node, symbol, operands[index : index + 2], found[index : index + 2])
            if symbol not in ("==", "!="):
                for side in (index, index + 1):
                    ordered[side] = self._ordered(operands[side], *found[side])
        # One chain, as in Python, so that what stands in the middle is evaluated once.
        rest = (f" {symbol} {code}" for symbol, code in zip(symbols, ordered[1:], strict=True))
        return f"({ordered[0]}{''.join(rest)})", BOOL

    def _comparable(
        self,
        node: ast.Compare,
        symbol: str,
        operands: list[ast.expr],
        found: list[tuple[str, Type]],
    ) -> None:
        (_, a), (_, b) = found
        if symbol in ("==", "!="):
            if not (fits(a, b) or fits(b, a)):
                numbers = isinstance(a, Number) and isinstance(b, Number)
                code = "wrong-dimension" if numbers else "wrong-type"
                self.fail(node, code, f"{a} and {b} are never equal")
            if isinstance(a, Text) and isinstance(b, Text):
                self._one_of(operands[1], a, b)
                self._one_of(operands[0], b, a)
        self._alike(node, a, b, f"the two sides of `{symbol}`")

    def _one_of(self, node: ast.expr, known: Text, given: Text) -> None:
        """Refuse a literal that is compared to a text which can never equal it."""
        literal = isinstance(node, ast.Constant)
        if literal and len(known.choices) > 1 and given.choices[0] not in known.choices:
            self.fail(
                node,
                "unknown-word",
                f"'{given.choices[0]}' is none of the words it can be",
                nearest(given.choices[0], known.choices),
            )

    def _ordered(self, node: ast.expr, code: str, type_: Type) -> str:
        if isinstance(type_, Number):
            return code
        if isinstance(type_, AnyType):
            return f"{self.use('number', fn.number)}({code})"
        self.fail(node, "wrong-type", f"only numbers are more or less, not {type_}")

    def _list(self, node: ast.List | ast.Tuple) -> tuple[str, Type]:
        found = [self.visit(element) for element in node.elts]
        return f"[{', '.join(code for code, _ in found)}]", ListOf(join_all([t for _, t in found]))

    # -- calls --------------------------------------------------------------------------------

    def _call(self, node: ast.Call) -> tuple[str, Type]:
        if not isinstance(node.func, ast.Name):
            self.fail(node, "unknown-function", "only the functions of the language can be called")
        name = node.func.id
        if node.keywords:
            self.fail(
                node, "wrong-arguments", f"{name}() takes its arguments in order, without names"
            )
        if name == "active":
            return self._active(node)
        found = self.scope.find(name)
        if isinstance(found, Define):
            if len(node.args) != len(found.arguments):
                self.fail(
                    node,
                    "wrong-arguments",
                    f"'{name}' takes {len(found.arguments)} arguments, not {len(node.args)}",
                )
            return self.define(node, found, [self.visit(argument) for argument in node.args])
        function = fn.FUNCTIONS.get(name)
        if function is None:
            defines = [
                known
                for known in self.scope.visible()
                if isinstance(self.scope.find(known), Define)
            ]
            self.fail(
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
            self.fail(
                node, "wrong-arguments", f"{name}() takes {count} arguments, not {len(node.args)}"
            )
        arguments = [
            self._comprehension(argument)
            if isinstance(argument, ast.GeneratorExp)
            else self.visit(argument)
            for argument in node.args
        ]
        result = function.result([type_ for _, type_ in arguments])
        if isinstance(result, str):
            self.fail(node, "wrong-type", f"{name}() {result}")
        codes = [
            f"{self.use('number', fn.number)}({code})"
            if isinstance(type_, AnyType) and name in _TAKES_NUMBERS
            else code
            for code, type_ in arguments
        ]
        return f"{self.use(f'f_{name}', function.call)}({', '.join(codes)})", result

    def _active(self, node: ast.Call) -> tuple[str, Type]:
        match node.args:
            case [ast.Constant(value=str(path))]:
                pass
            case _:
                self.fail(node, "wrong-arguments", "active() takes the path of a state in quotes")
        states = self.scope.all_states()
        if path not in states:
            self.fail(node, "unknown-state", f"there is no state '{path}'", nearest(path, states))
        self.reads.add("states")
        return f"(s[{CONFIGURATION_SLOT}] >> {states[path]} & 1 == 1)", BOOL

    def _comprehension(self, node: ast.ListComp | ast.GeneratorExp) -> tuple[str, Type]:
        self.loops = True
        names: list[str] = []
        pieces = []
        for generator in node.generators:
            if not isinstance(generator.target, ast.Name) or generator.is_async:
                self.fail(node, "bad-expression", "a comprehension names one variable after `for`")
            name = generator.target.id
            if name in self.locals or name in self.arguments or self.scope.find(name) is not None:
                self.fail(
                    generator.target,
                    "name-taken",
                    f"the name '{name}' is visible here already",
                    "choose another",
                )
            code, type_ = self.visit(generator.iter)
            if not isinstance(type_, (ListOf, AnyType)):
                self.fail(generator.iter, "wrong-type", f"a list is needed here, not {type_}")
            self.locals[name] = type_.item if isinstance(type_, ListOf) else ANY
            names.append(name)
            conditions = "".join(f" if {self.truth(test)}" for test in generator.ifs)
            pieces.append(f" for v_{name} in b.loop({code}){conditions}")
        element, type_ = self.visit(node.elt)
        for name in names:
            del self.locals[name]
        return f"[{element}{''.join(pieces)}]", ListOf(type_)


_VISITORS: Mapping[type[ast.expr], Callable[[Translator, Any], tuple[str, Type]]] = {
    ast.Constant: Translator._constant,
    ast.Name: Translator._name,
    ast.Attribute: Translator._attribute,
    ast.Subscript: Translator._subscript,
    ast.UnaryOp: Translator._unary,
    ast.BinOp: Translator._binary,
    ast.BoolOp: Translator._logic,
    ast.Compare: Translator._compare,
    ast.IfExp: Translator._choice,
    ast.List: Translator._list,
    ast.Tuple: Translator._list,
    ast.Call: Translator._call,
    ast.ListComp: Translator._comprehension,
}
"""The parts of Python that the language has; all others are refused."""
