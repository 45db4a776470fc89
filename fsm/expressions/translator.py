"""Translates the syntax tree of an expression to Python code of our own, and finds its type."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import Any, NoReturn

from fsm.expressions.constants import literal, value_of, warn_of_angle
from fsm.expressions.scope import CONFIGURATION_SLOT, TIME_SLOT, Binding, Define, Scope, start
from fsm.expressions.syntax import parse, too_deep
from fsm.values import functions as fn
from fsm.values.types import (
    ANY,
    BARE,
    BOOL,
    MAX_NUMBER,
    NONE,
    TEXT,
    AnyType,
    Bool,
    ListOf,
    MapOf,
    Mixed,
    Number,
    PointType,
    Text,
    Type,
    alike,
    fits,
    join,
    join_all,
    product,
    raised,
)
from vencejo.errors import Correction, UserError, Where, nearest
from vencejo.units import ANGLE, LENGTH, RATIO

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
    "null": ("None", NONE),
    "none": ("None", NONE),
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
        "range",
    ]
)
_LITERALS = frozenset([ast.Constant, ast.UnaryOp])
"""The parts that a number without a unit may be, perhaps with its sign."""
_TAKES_ANGLES = frozenset(["sin", "cos", "wrap"])


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
        self._varying: list[str] = []
        """The names read so far whose values are known in flight only."""
        self._conditions: list[tuple[ast.expr, str]] = []
        """The conditions in it that are constant, with their code."""

    @property
    def cost(self) -> int:
        """The number of its parts, those of the defines it uses included."""
        return self.parsed.parts + self.defined

    @property
    def varying(self) -> list[str]:
        """The names that it reads, without the arguments that it is given."""
        return [name for name in self._varying if name not in self.arguments]

    def translate(self, condition: bool = False) -> tuple[str, Type]:
        """The code and the type of the whole expression. Raises UserError.

        Warns of the conditions in it that are constant; with ``condition`` it is one as a whole.
        """
        tree = self.parsed.tree
        try:
            code, type_ = self.visit(tree)
        except RecursionError:
            raise too_deep(self.parsed.where) from None
        if condition and not self._varying and isinstance(type_, Bool):
            self._note_condition(tree, code, 0)
        for node, part in self._conditions:
            value = self._known(node, part, len(self._varying))
            if value is not None:
                self.scope.warn(
                    "constant-condition",
                    f"'{self.parsed.words(node)}' is always {'true' if value else 'false'}",
                    self.parsed.place(node),
                    "compare something that changes in flight, or leave it out",
                )
        return code, type_

    def _note_condition(self, node: ast.expr, code: str, told: int) -> None:
        """Note a condition that is constant; ``told`` of them were known before it.

        The name of a define is left alone: its own place is told, and `debug: false` is meant so.
        """
        named = isinstance(node, ast.Name) and node.id not in _WORDS
        if not named:
            self._conditions[told:] = [(node, code)]

    @cached_property
    def _budget(self) -> fn.Budget:
        """The steps of loops that its constant parts may take."""
        return fn.Budget()

    def _known(self, node: ast.expr, code: str, varying: int = 0) -> Any:
        """The value of a part if it is constant: no name has been read since ``varying`` were.

        None for others, and where it would take too many steps. One without a value is refused.
        """
        if len(self._varying) > varying:
            return None
        try:
            return value_of(code, self.namespace, self._budget)
        except fn.FAILURES as error:
            if self._budget.left < 0:
                return None
            message = f"this has no value: {fn.plain(error)}"
            self.fail(node, "no-value", message, "correct the constant")
        except (SyntaxError, RecursionError, MemoryError):
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
            return repr(value), BOOL if value is not None else NONE
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
            self._varying.append(name)
            return f"v_{name}", self.locals[name]
        if name in self.arguments:
            self._varying.append(name)
            return f"a_{name}", self.arguments[name]
        if name in _WORDS:
            return _WORDS[name]
        found = self.scope.find(name)
        if isinstance(found, Binding):
            self._varying.append(name)
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
        hint = self._meant(name) if self.scope.size.add_unknown() else None
        self.fail(node, "unknown-name", f"the name '{name}' is unknown here", hint)

    def _meant(self, name: str) -> str | None:
        """A hint at what an unknown name was to be."""
        known = {*self.scope.visible(), *self.locals, *self.arguments}
        host = next(self.scope.with_field(name), None)
        if host:
            return Correction(name, f"{host}.{name}")
        if name in fn.FUNCTIONS or name == "active":
            return f"'{name}' is a function: write {name}(…)"
        if not known:
            return "nothing is declared here; a text needs no `$`, and quotes inside an expression"
        return nearest(name, known)

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
        self._varying += inner.varying
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
        declared = isinstance(type_, MapOf) and name in (type_.fields or ())
        if name == "source" and self._is_event(node.value) and not declared:
            return f"{self.use('source', fn.source)}({code})", TEXT
        if isinstance(type_, PointType):
            if name not in ("x", "y", "z"):
                self.fail(node, "unknown-field", f"a point has no '{name}'", "it has x, y and z")
            return self._part(code, name, fn.field), Number(LENGTH)
        if isinstance(type_, MapOf) and type_.fields is not None:
            if name not in type_.fields:
                what = ast.unparse(node.value)
                hint = nearest(name, type_.fields)
                self.fail(node, "unknown-field", f"'{what}' has no '{name}'", hint)
            if isinstance(node.value, ast.Name) and self._is_of_host(node.value.id):
                place = self.parsed.place(node)
                self.scope.host_fields.setdefault(f"{node.value.id}.{name}", place)
            return self._part(code, name, fn.part), type_.fields[name]
        if isinstance(type_, (MapOf, AnyType)):
            return f"{self.use('field', fn.field)}({code}, {name!r})", ANY
        self.fail(node, "unknown-field", f"{type_} has no fields")

    def _is_of_host(self, name: str) -> bool:
        """Whether a name is the host's, and nothing nearer has it."""
        found = self.scope.find(name)
        own = name in self.locals or name in self.arguments
        return not own and isinstance(found, Binding) and found.kind == "host"

    def _is_event(self, node: ast.expr) -> bool:
        """Whether it is ``event`` itself."""
        if not isinstance(node, ast.Name) or node.id != "event":
            return False
        found = self.scope.find("event")
        return isinstance(found, Binding) and found.kind == "event"

    def _part(self, code: str, name: str, function: Callable[[Any, str], Any]) -> str:
        """The code that reads a field which is declared."""
        if code in self._objects:
            self._objects.add(f"{code}.{name}")
            return f"{code}.{name}"
        return f"{self.use(function.__name__, function)}({code}, {name!r})"

    def _subscript(self, node: ast.Subscript) -> tuple[str, Type]:
        varying = len(self._varying)
        code, type_ = self.visit(node.value)
        if isinstance(node.slice, ast.Slice):
            self.fail(node, "bad-expression", "slices are not part of the expression language")
        index, index_type = self.visit(node.slice)
        result = self._element(node, type_, index_type)
        code = f"{self.use('item', fn.item)}({code}, {index})"
        self._known(node, code, varying)
        return code, result

    def _element(self, node: ast.Subscript, type_: Type, index: Type) -> Type:
        """The type of an element of a list or map."""
        if isinstance(type_, ListOf):
            if not isinstance(index, (Number, AnyType)):
                self.fail(node.slice, "wrong-type", f"a list is indexed by a number, not {index}")
            if not fits(Number(RATIO), index):
                message = f"a list is indexed by a plain number, not {index}"
                self.fail(node.slice, "wrong-dimension", message)
            position = literal(node.slice)
            if position is not None and position != int(position):
                self.fail(node.slice, "wrong-type", "a list is indexed by a whole number")
            return type_.item
        if not isinstance(type_, (MapOf, AnyType)):
            self.fail(node, "wrong-type", f"{type_} has no elements")
        if not isinstance(type_, MapOf):
            return ANY
        if not isinstance(index, (Text, AnyType)):
            self.fail(node.slice, "wrong-type", f"a map is indexed by a text, not {index}")
        name = node.slice.value if isinstance(node.slice, ast.Constant) else None
        if type_.fields is None or not isinstance(name, str):
            return ANY
        if name not in type_.fields:
            hint = nearest(name, type_.fields)
            self.fail(node.slice, "unknown-field", f"this map has no '{name}'", hint)
        return type_.fields[name]

    def _number(self, node: ast.expr) -> tuple[str, Number]:
        code, type_ = self.visit(node)
        if isinstance(type_, Number):
            return code, Number(type_.dimension)
        if isinstance(type_, AnyType):
            return f"{self.use('number', fn.number)}({code})", BARE
        self.fail(node, "wrong-type", f"a number is needed here, not {type_}")

    def truth(self, node: ast.expr) -> str:
        """The code of a part that must be true or false."""
        varying, told = len(self._varying), len(self._conditions)
        code, type_ = self.visit(node)
        if isinstance(type_, Bool):
            if len(self._varying) == varying:
                self._note_condition(node, code, told)
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
        varying = len(self._varying)
        code, type_ = self._power(node) if isinstance(node.op, ast.Pow) else self._sum(node)
        if len(self._varying) == varying:
            self._known(node, code, varying)
        return code, type_

    def _power(self, node: ast.BinOp) -> tuple[str, Type]:
        base, type_ = self._number(node.left)
        varying = len(self._varying)
        exponent, power_type = self._number(node.right)
        if power_type.dimension not in (None, RATIO):
            self.fail(node.right, "wrong-dimension", f"an exponent cannot be {power_type}")
        result = raised(type_, self._known(node.right, exponent, varying))
        if result is None:
            self.fail(node, "wrong-dimension", f"{type_} has no such power")
        return f"{self.use('power', fn.power)}({base}, {exponent})", result

    def _sum(self, node: ast.BinOp) -> tuple[str, Type]:
        """A sum or a product."""
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
        varying = len(self._varying)
        right, b = self._number(node.right)
        if symbol == "/" and self._known(node.right, right, varying) == 0:
            message = "this has no value: a division by zero"
            self.fail(node, "no-value", message, "correct the constant")
        if symbol in "+-":
            self._alike(node, a, b, f"the two sides of `{symbol}`")
            if type(node.left) in _LITERALS or type(node.right) in _LITERALS:
                self._angles([node.left, node.right], [a, b])
            return f"({left} {symbol} {right})", join(a, b)
        return f"({left} {symbol} {right})", product(a, b, 1 if symbol == "*" else -1)

    def _angles(self, nodes: list[ast.expr], types: Iterable[Type]) -> None:
        """Warn of bare numbers above a full turn beside angles and turn rates."""
        for place in types:
            if isinstance(place, Number) and place.dimension and place.dimension.angle:
                break
        else:
            return
        for node in nodes:
            number = literal(node)
            if number is not None:
                words, where = self.parsed.words(node), self.parsed.place(node)
                warn_of_angle(self.scope, number, words, place, where)

    def _logic(self, node: ast.BoolOp) -> tuple[str, Type]:
        word = " and " if isinstance(node.op, ast.And) else " or "
        return "(" + word.join(self.truth(value) for value in node.values) + ")", BOOL

    def _choice(self, node: ast.IfExp) -> tuple[str, Type]:
        condition = self.truth(node.test)
        (a, type_a), (b, type_b) = self.visit(node.body), self.visit(node.orelse)
        self._alike(node, type_a, type_b, "the two alternatives")
        self._angles([node.body, node.orelse], [type_a, type_b])
        return f"({a} if {condition} else {b})", join(type_a, type_b)

    def _alike(self, node: ast.AST, a: Type, b: Type, what: str) -> None:
        if isinstance(a, Number) and isinstance(b, Number) and not (fits(a, b) or fits(b, a)):
            self.fail(node, "wrong-dimension", f"{what} are {a} and {b}")

    def _compare(self, node: ast.Compare) -> tuple[str, Type]:
        operands = [node.left, *node.comparators]
        found = [self.visit(operand) for operand in operands]
        if isinstance(node.ops[0], (ast.In, ast.NotIn)) and len(node.ops) == 1:
            return self._contained(node, found), BOOL
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
        chain = ordered[0]
        for symbol, code in zip(symbols, ordered[1:], strict=True):
            chain += f" {symbol} {code}"
        return f"({chain})", BOOL

    def _contained(self, node: ast.Compare, found: list[tuple[str, Type]]) -> str:
        """The code of `a in b`; the element must be able to equal what is in there."""
        (element, type_), (code, collection) = found
        place = node.comparators[0]
        match collection:
            case ListOf(item=item):
                literals = place.elts if isinstance(place, (ast.List, ast.Tuple)) else []
                for each in literals:
                    pair = [node.left, each], [found[0], self.visit(each)]
                    self._comparable(node, "==", *pair)
                if not literals:
                    self._equal(node, type_, item)
            case MapOf():
                self._equal(node, type_, Text())
            case Text():
                if not isinstance(type_, (Text, AnyType)):
                    self.fail(node.left, "wrong-type", f"{type_} is never in a text")
            case AnyType():
                pass
            case _:
                self.fail(place, "wrong-type", f"nothing is in {collection}")
        test = f"{self.use('contains', fn.contains)}({element}, {code})"
        return f"(not {test})" if isinstance(node.ops[0], ast.NotIn) else test

    def _equal(self, node: ast.Compare, a: Type, b: Type) -> None:
        """Refuse to compare values whose types are never equal."""
        options = b.options if isinstance(b, Mixed) else (b,)
        if not any(alike(a, option) for option in options):
            numbers = isinstance(a, Number) and all(isinstance(each, Number) for each in options)
            code = "wrong-dimension" if numbers else "wrong-type"
            self.fail(node, code, f"{a} and {b} are never equal")

    def _comparable(
        self,
        node: ast.Compare,
        symbol: str,
        operands: list[ast.expr],
        found: list[tuple[str, Type]],
    ) -> None:
        (_, a), (_, b) = found
        if symbol in ("==", "!="):
            self._equal(node, a, b)
            if isinstance(a, Text) and isinstance(b, Text):
                self._one_of(operands[1], a, b)
                self._one_of(operands[0], b, a)
        self._alike(node, a, b, f"the two sides of `{symbol}`")
        if type(operands[0]) in _LITERALS or type(operands[1]) in _LITERALS:
            self._angles(operands, [a, b])

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
            varying = len(self._varying)
            given = [self.visit(argument) for argument in node.args]
            code, type_ = self.define(node, found, given)
            self._known(node, code, varying)
            return code, type_
        return self._function(node, name)

    def _function(self, node: ast.Call, name: str) -> tuple[str, Type]:
        """A call of one of the language's own functions."""
        function = fn.FUNCTIONS.get(name)
        if function is None:
            names = self.scope.visible()
            defines = [known for known in names if isinstance(self.scope.find(known), Define)]
            hint = nearest(name, [*fn.FUNCTIONS, "active", *defines])
            self.fail(node, "unknown-function", f"there is no function '{name}'", hint)
        least, most, given = function.least, function.most, len(node.args)
        if not least <= given <= most:
            count = str(least) if least == most else f"{least} to {most}"
            message = f"{name}() takes {count} arguments, not {given}"
            self.fail(node, "wrong-arguments", message)
        varying = len(self._varying)
        arguments = [
            self._comprehension(argument)
            if isinstance(argument, ast.GeneratorExp)
            else self.visit(argument)
            for argument in node.args
        ]
        types = [type_ for _, type_ in arguments]
        result = function.result(types)
        if isinstance(result, fn.Misfit):
            self.fail(node, result.code, f"{name}() {result.message}", result.hint)
        self._angles(node.args, [Number(ANGLE)] if name in _TAKES_ANGLES else types)
        codes = [
            f"{self.use('number', fn.number)}({code})"
            if isinstance(type_, AnyType) and name in _TAKES_NUMBERS
            else code
            for code, type_ in arguments
        ]
        if function.counted:
            self.loops = True
            codes = ["b", *codes]
        code = f"{self.use(f'f_{name}', function.call)}({', '.join(codes)})"
        self._known(node, code, varying)
        return code, result

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
        self._varying.append(path)
        return f"(s[{CONFIGURATION_SLOT}] >> {states[path]} & 1 == 1)", BOOL

    def _comprehension(self, node: ast.ListComp | ast.GeneratorExp) -> tuple[str, Type]:
        self.loops = True
        varying = len(self._varying)
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
        self._varying[varying:] = [n for n in self._varying[varying:] if n not in names]
        code = f"[{element}{''.join(pieces)}]"
        self._known(node, code, varying)
        return code, ListOf(type_)


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
