"""Calls in expressions: functions, defines with arguments, ``active`` and comprehensions."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from fsm import functions as fn
from fsm.scope import CONFIGURATION_SLOT, Define
from fsm.types import ANY, BOOL, AnyType, ListOf, Type
from vencejo.errors import nearest

if TYPE_CHECKING:
    from fsm.translator import Translator

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


def call(t: Translator, node: ast.Call) -> tuple[str, Type]:
    if not isinstance(node.func, ast.Name):
        t.fail(node, "unknown-function", "only the functions of the language can be called")
    name = node.func.id
    if node.keywords:
        t.fail(node, "wrong-arguments", f"{name}() takes its arguments in order, without names")
    if name == "active":
        return _active(t, node)
    found = t.scope.find(name)
    if isinstance(found, Define):
        if len(node.args) != len(found.arguments):
            t.fail(
                node,
                "wrong-arguments",
                f"'{name}' takes {len(found.arguments)} arguments, not {len(node.args)}",
            )
        return t.define(node, found, [t.visit(argument) for argument in node.args])
    function = fn.FUNCTIONS.get(name)
    if function is None:
        defines = [known for known in t.scope.visible() if isinstance(t.scope.find(known), Define)]
        t.fail(
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
        t.fail(node, "wrong-arguments", f"{name}() takes {count} arguments, not {len(node.args)}")
    arguments = [
        comprehension(t, argument) if isinstance(argument, ast.GeneratorExp) else t.visit(argument)
        for argument in node.args
    ]
    result = function.result([type_ for _, type_ in arguments])
    if isinstance(result, str):
        t.fail(node, "wrong-type", f"{name}() {result}")
    codes = [
        f"{t.use('number', fn.number)}({code})"
        if isinstance(type_, AnyType) and name in _TAKES_NUMBERS
        else code
        for code, type_ in arguments
    ]
    return f"{t.use(f'f_{name}', function.call)}({', '.join(codes)})", result


def _active(t: Translator, node: ast.Call) -> tuple[str, Type]:
    match node.args:
        case [ast.Constant(value=str(path))]:
            pass
        case _:
            t.fail(node, "wrong-arguments", "active() takes the path of a state in quotes")
    states = t.scope.all_states()
    if path not in states:
        t.fail(node, "unknown-state", f"there is no state '{path}'", nearest(path, states))
    t.reads.add("states")
    return f"(s[{CONFIGURATION_SLOT}] >> {states[path]} & 1 == 1)", BOOL


def comprehension(t: Translator, node: ast.ListComp | ast.GeneratorExp) -> tuple[str, Type]:
    t.loops = True
    names: list[str] = []
    pieces = []
    for generator in node.generators:
        if not isinstance(generator.target, ast.Name) or generator.is_async:
            t.fail(node, "bad-expression", "a comprehension names one variable after `for`")
        name = generator.target.id
        if name in t.locals or name in t.arguments or t.scope.find(name) is not None:
            t.fail(
                generator.target,
                "name-taken",
                f"the name '{name}' is visible here already",
                "choose another",
            )
        code, type_ = t.visit(generator.iter)
        if not isinstance(type_, (ListOf, AnyType)):
            t.fail(generator.iter, "wrong-type", f"a list is needed here, not {type_}")
        t.locals[name] = type_.item if isinstance(type_, ListOf) else ANY
        names.append(name)
        conditions = "".join(f" if {t.truth(test)}" for test in generator.ifs)
        pieces.append(f" for v_{name} in b.loop({code}){conditions}")
    element, type_ = t.visit(node.elt)
    for name in names:
        del t.locals[name]
    return f"[{element}{''.join(pieces)}]", ListOf(type_)
