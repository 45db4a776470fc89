"""The Python data model: a small, pure part of Python, with its own values.

Numbers, texts, lists, maps, ``True False None``; ``and or not``, ``x if c else y``, comparison,
arithmetic, indexing, fields, a few functions and methods, ``In('state')``. Python's own parser
reads the text, so that what is no Python is known; the tree is compiled to closures over an
instance's slots, and the user's text is never run as code. Python beyond this part is refused.
The fields of an event, and of any other map, can be read as attributes too: ``_event.data.id``.
"""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable, Mapping
from textwrap import dedent, indent
from typing import Any, NoReturn

from fsm.expressions.compiled import Evaluator
from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.expressions.syntax import MAX_CHARACTERS, MAX_NODES
from fsm.scxml.datamodel import (
    Assignment,
    DataModel,
    Location,
    Names,
    declared_variable,
    undeclared,
)
from fsm.values.functions import MAX_RESULT, EvaluationError, bounded, power, shown
from vencejo.errors import UserError, Where, nearest

Binary = Callable[[Any, Any], Any]
_HALF_LETTER = re.compile("[\ud800-\udfff]")


def compile_value(text: str, where: Where, names: Names) -> Evaluator:
    """Compile an expression to a function of slots. Raises UserError."""
    function = _expression(text, where, names)
    return lambda slots, event: bounded(function(slots, event))


def compile_condition(text: str, where: Where, names: Names) -> Evaluator:
    """Compile an expression to a condition, true or false by Python's rules."""
    function = _expression(text, where, names)
    return lambda slots, event: bool(function(slots, event))


def compile_location(text: str, where: Where, names: Names) -> Location:
    """Compile what stands on the left of an assignment. Raises UserError."""
    compiler = _Compiler(_one_line(text), where, names)
    return compiler.location(compiler.tree("eval").body)


def compile_script(text: str, where: Where, names: Names) -> list[Assignment]:
    """Compile a script of assignments. Raises UserError."""
    compiler = _Compiler(_statements(text), where, names)
    return [each for node in compiler.tree("exec").body for each in compiler.statement(node)]


def assigned_names(text: str) -> list[str]:
    """The variables that a script assigns."""
    try:
        tree = ast.parse(_statements(text))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    targets = [
        target
        for statement in tree.body
        if isinstance(statement, ast.Assign)
        for target in statement.targets
    ]
    return [target.id for target in targets if isinstance(target, ast.Name)]


def _statements(text: str) -> str:
    """A script without the indentation of its document, which its first line has lost already."""
    first, _, rest = text.partition("\n")
    inside = first.rstrip().endswith(":")
    return f"{first.strip()}\n{indent(dedent(rest), ' ' * inside)}"


def _one_line(text: str) -> str:
    """An expression in one line: the lines of an attribute mean nothing."""
    return text.replace("\r", " ").replace("\n", " ")


def _expression(text: str, where: Where, names: Names) -> Evaluator:
    compiler = _Compiler(_one_line(text), where, names)
    return compiler.value(compiler.tree("eval").body)


class _Compiler:
    """Compiles one text."""

    def __init__(self, text: str, where: Where, names: Names) -> None:
        self.text = text.lstrip()
        self.where = where.right(len(text) - len(self.text))
        """The place of its first letter."""
        self.names = names

    def tree(self, mode: str) -> Any:
        """Python's tree of the text. Raises UserError when it is no Python, or too large."""
        if len(self.text) > MAX_CHARACTERS:
            message = f"more than {MAX_CHARACTERS} characters"
            raise UserError("expression-too-long", message, self.where)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                tree = ast.parse(self.text, mode=mode)
        except SyntaxError as error:
            message = f"this is no Python: {error.msg.split('. ')[0]}"
            place = self.at(error.lineno or 1, (error.offset or 1) - 1)
            raise UserError("bad-expression", message, place) from None
        except (ValueError, RecursionError, MemoryError):
            raise UserError("bad-expression", "this cannot be read", self.where) from None
        if sum(isinstance(node, ast.expr) for node in ast.walk(tree)) > MAX_NODES:
            raise UserError("expression-too-long", f"more than {MAX_NODES} parts", self.where)
        return tree

    def at(self, line: int, column: int) -> Where:
        if line == 1:
            return self.where.right(column)
        return Where(self.where.file, self.where.line + line - 1, column + 1)

    def place(self, node: ast.AST) -> Where:
        line, offset = getattr(node, "lineno", 1), getattr(node, "col_offset", 0)
        before = self.text.split("\n")[line - 1].encode()[:offset]
        return self.at(line, len(before.decode(errors="ignore")))

    def refuse(self, node: ast.AST, what: str | None = None, hint: str | None = None) -> NoReturn:
        """Raise UserError for Python that is not run here."""
        what = what or f"{type(node).__name__.lower()} is a part of Python that"
        raise UserError("not-supported", f"{what} is not run here", self.place(node), hint)

    # -- statements -------------------------------------------------------------------------

    def statement(self, node: ast.stmt) -> list[Assignment]:
        if isinstance(node, ast.Assign):
            value = _bounded(self.value(node.value))
            return [Assignment(self.location(target), value) for target in node.targets]
        if isinstance(node, ast.AugAssign):
            present = self.value(node.target)
            compute = self.operator(node.op)
            value = _bounded(_both(compute, present, self.value(node.value)))
            return [Assignment(self.location(node.target), value)]
        if isinstance(node, ast.Pass):
            return []
        hint = "a script holds assignments only: x = …; y += …"
        raise UserError("not-supported", "an assignment is needed here", self.place(node), hint)

    def location(self, node: ast.expr) -> Location:
        keys: list[Evaluator] = []
        while isinstance(node, (ast.Subscript, ast.Attribute)):
            keys.insert(0, self.key(node))
            node = node.value
        if not isinstance(node, ast.Name):
            raise UserError("bad-location", "this is no variable", self.place(node))
        slot = declared_variable(node.id, self.place(node), self.names)
        return Location(node.id, slot, keys, _item, _store)

    def key(self, node: ast.Subscript | ast.Attribute) -> Evaluator:
        if isinstance(node, ast.Attribute):
            return _constant(node.attr)
        if isinstance(node.slice, ast.Slice):
            self.refuse(node.slice)
        return self.value(node.slice)

    # -- expressions ------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Evaluator:
        compile_ = getattr(self, f"of_{type(node).__name__.lower()}", None)
        if compile_ is None:
            self.refuse(node)
        evaluator: Evaluator = compile_(node)
        return evaluator

    def of_constant(self, node: ast.Constant) -> Evaluator:
        if not isinstance(node.value, (bool, int, float, str)) and node.value is not None:
            self.refuse(node)
        if isinstance(node.value, str) and _HALF_LETTER.search(node.value):
            message = "half of a letter stands here alone"
            raise UserError("bad-expression", message, self.place(node))
        return _constant(node.value)

    def of_name(self, node: ast.Name) -> Evaluator:
        slot = self.names.slot(node.id, self.place(node))
        return undeclared(node.id) if slot is None else lambda s, e: s[slot]

    def of_list(self, node: ast.List) -> Evaluator:
        elements = [self.value(element) for element in node.elts]
        return lambda s, e: [element(s, e) for element in elements]

    def of_tuple(self, node: ast.Tuple) -> Evaluator:
        elements = [self.value(element) for element in node.elts]
        return lambda s, e: tuple(element(s, e) for element in elements)

    def of_dict(self, node: ast.Dict) -> Evaluator:
        pairs: list[tuple[Evaluator, Evaluator]] = []
        for key, value in zip(node.keys, node.values, strict=True):
            if key is None:
                self.refuse(value, "`**`")
            pairs.append((self.value(key), self.value(value)))
        return lambda s, e: {key(s, e): value(s, e) for key, value in pairs}

    def of_ifexp(self, node: ast.IfExp) -> Evaluator:
        test, first, second = self.value(node.test), self.value(node.body), self.value(node.orelse)
        return lambda s, e: first(s, e) if test(s, e) else second(s, e)

    def of_boolop(self, node: ast.BoolOp) -> Evaluator:
        until = isinstance(node.op, ast.Or)
        values = [self.value(value) for value in node.values]

        def decide(slots: list[Any], event: Mapping[str, Any] | None) -> Any:
            found = None
            for value in values:
                found = value(slots, event)
                if bool(found) is until:
                    break
            return found

        return decide

    def of_unaryop(self, node: ast.UnaryOp) -> Evaluator:
        compute, operand = _UNARY.get(type(node.op)), self.value(node.operand)
        if compute is None:
            self.refuse(node.op)
        return lambda s, e: compute(operand(s, e))

    def of_binop(self, node: ast.BinOp) -> Evaluator:
        return _both(self.operator(node.op), self.value(node.left), self.value(node.right))

    def operator(self, node: ast.operator) -> Binary:
        found = _BINARY.get(type(node))
        if found is None:
            self.refuse(node)
        return found

    def of_compare(self, node: ast.Compare) -> Evaluator:
        pairs: list[tuple[Binary, Evaluator]] = []
        for op, right in zip(node.ops, node.comparators, strict=True):
            if isinstance(op, (ast.Is, ast.IsNot)) and not _is_single(node.left, right):
                self.refuse(node, "`is` between values", "`==` compares")
            pairs.append((_COMPARISONS[type(op)], self.value(right)))
        first = self.value(node.left)

        def compare(slots: list[Any], event: Mapping[str, Any] | None) -> Any:
            left, found = first(slots, event), True
            for holds, value in pairs:
                right = value(slots, event)
                found = holds(left, right)
                if not found:
                    break
                left = right
            return found

        return compare

    def of_subscript(self, node: ast.Subscript) -> Evaluator:
        return _both(_item, self.value(node.value), self.key(node))

    def of_attribute(self, node: ast.Attribute) -> Evaluator:
        return _both(_field, self.value(node.value), self.key(node))

    def of_call(self, node: ast.Call) -> Evaluator:
        if node.keywords:
            self.refuse(node.keywords[0].value, "an argument with a name")
        arguments = [self.value(argument) for argument in node.args]
        if isinstance(node.func, ast.Attribute):
            return self.method(node.func, arguments)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == "In":
            return self.is_in(node, arguments)
        function = _FUNCTIONS.get(name)
        if function is None:
            hint = nearest(name, [*_FUNCTIONS, "In"])
            self.refuse(node, f"calling '{ast.unparse(node.func)}'", hint)
        return lambda s, e: function(*(argument(s, e) for argument in arguments))

    def method(self, node: ast.Attribute, arguments: list[Evaluator]) -> Evaluator:
        name, holder = node.attr, self.value(node.value)
        if not any(name in methods for methods in _METHODS.values()):
            known = sorted(set().union(*_METHODS.values()))
            self.refuse(node, f"the method '{name}'", nearest(name, known))

        def call(slots: list[Any], event: Mapping[str, Any] | None) -> Any:
            value = holder(slots, event)
            if name not in _METHODS.get(type(value), ()):
                raise EvaluationError(f"{shown(value)} has no method '{name}'")
            return getattr(value, name)(*(argument(slots, event) for argument in arguments))

        return call

    def is_in(self, node: ast.Call, arguments: list[Evaluator]) -> Evaluator:
        if len(arguments) != 1:
            self.refuse(node, f"In() of {len(arguments)} states")
        (argument,) = arguments
        given, states = node.args[0], self.names.states
        if isinstance(given, ast.Constant):
            self.names.state(str(given.value), self.place(given))

        def active(slots: list[Any], event: Mapping[str, Any] | None) -> bool:
            index = states.get(argument(slots, event))
            return index is not None and slots[CONFIGURATION_SLOT] >> index & 1 == 1

        return active


def _is_single(*sides: ast.expr) -> bool:
    """Whether one side of an `is` is a value of which there is only one."""
    return any(
        isinstance(side, ast.Constant) and (side.value is None or isinstance(side.value, bool))
        for side in sides
    )


def _constant(value: Any) -> Evaluator:
    return lambda s, e: value


def _bounded(value: Evaluator) -> Evaluator:
    return lambda s, e: bounded(value(s, e))


def _both(compute: Binary, left: Evaluator, right: Evaluator) -> Evaluator:
    return lambda s, e: compute(left(s, e), right(s, e))


# -- operators and functions ----------------------------------------------------------------


def _times(a: Any, b: Any) -> Any:
    for sequence, count in ((a, b), (b, a)):
        if isinstance(sequence, (str, list, tuple)) and isinstance(count, int):
            if len(sequence) * count > MAX_RESULT:
                raise EvaluationError("the result is larger than 1 MB")
            return sequence * count
    return bounded(a * b)


def _modulo(a: Any, b: Any) -> Any:
    if isinstance(a, str):
        raise EvaluationError("a text cannot be filled in by `%` here")
    return a % b


def _power(a: Any, b: Any) -> Any:
    """The power of two numbers. Raises OverflowError before a whole one takes too long."""
    found = power(a, b)
    return a**b if isinstance(a, int) and isinstance(b, int) and b >= 0 else found


def _plus(a: Any, b: Any) -> Any:
    return bounded(a + b)


def _round(value: Any) -> Any:
    """``round`` of one argument: a number of digits could ask for an endless power of ten."""
    return round(value)


_BINARY: Mapping[type[ast.operator], Binary] = {
    ast.Add: _plus,
    ast.Sub: operator.sub,
    ast.Mult: _times,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: _modulo,
    ast.Pow: _power,
}
_UNARY: Mapping[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_COMPARISONS: Mapping[type[ast.cmpop], Binary] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}
_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "abs": abs,
    "all": all,
    "any": any,
    "bool": bool,
    "float": float,
    "hasattr": lambda value, name: isinstance(value, dict) and name in value,
    "int": int,
    "len": len,
    "list": list,
    "max": max,
    "min": min,
    "round": _round,
    "str": str,
    "sum": sum,
}
_METHODS: Mapping[type, frozenset[str]] = {
    dict: frozenset({"get"}),
    list: frozenset({"count", "index"}),
    str: frozenset({"count", "endswith", "find", "index", "lower", "startswith", "strip", "upper"}),
}


def _item(value: Any, key: Any) -> Any:
    if isinstance(value, dict) and key in value:
        return value[key]
    if isinstance(value, (list, tuple, str)):
        return value[key]
    raise EvaluationError(f"{shown(value)} has no {key!r}")


def _field(value: Any, name: str) -> Any:
    if isinstance(value, dict) and name in value:
        return value[name]
    raise EvaluationError(f"{shown(value)} has no '{name}'")


def _store(value: Any, key: Any, new: Any) -> None:
    value[key] = new


PYTHON = DataModel(
    compile_value,
    compile_condition,
    compile_location,
    compile_script,
    assigned_names,
    str,
    null=None,
    processor="scxml",
)
