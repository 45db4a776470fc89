"""The small changes that the mutation bench makes in a module, found on its syntax tree.

Code that no test should have to check is not changed: docstrings, annotations, imports, `__all__`
and other dunder names, blocks for type checkers, assertions, and prose (help and hints of errors);
nor are changes made that fail wherever they run, such as `-` between texts. Inside f-strings
nothing is changed, as Python 3.11 gives no positions there.
"""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

COMPARISONS: Mapping[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
"""The neighbour at the boundary first, then the opposite."""

ARITHMETIC: Mapping[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Div,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitOr: ast.BitAnd,
    ast.BitAnd: ast.BitOr,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}

TYPE_CALLS = {"cast", "TypeVar", "NewType", "ParamSpec", "NamedTuple"}
SYMMETRIC_CALLS = {"min", "max", "hypot", "isclose", "isinstance", "issubclass", *TYPE_CALLS}
PROSE_KEYWORDS = {"help", "short_help", "hint", "description", "metavar", "epilog"}
PROSE = re.compile(r"[A-Za-z]{2,}[^\w\s]* +[^\w\s]*[A-Za-z]{2,}")

OptionalArguments = Mapping[str, frozenset[str]]
"""Name of a function or class → its parameters that have a default, wherever it is defined."""


@dataclass(frozen=True)
class Mutation:
    """One change of a module's source text; lines keep their numbers."""

    line: int
    end_line: int
    column: int
    statement: int
    """First line of the statement or clause that it stands in."""
    at_import: bool
    """True when it is executed at the import of the module, rather than by a call."""
    before: str
    after: str
    span: tuple[int, int]
    """Bytes of the UTF-8 source that `replacement` replaces."""
    replacement: str

    def apply(self, source: str) -> str:
        """The source text with this change made."""
        text, (start, end) = source.encode(), self.span
        return (text[:start] + self.replacement.encode() + text[end:]).decode()

    def __str__(self) -> str:
        return f"{self.before} → {self.after}"


def mutations(source: str, optional: OptionalArguments | None = None) -> list[Mutation]:
    """Every change of a module that the bench knows, in the order of the text.

    Keyword arguments are dropped only from calls of what `optional` lists, where they may be.
    """
    finder = _Finder(source, optional or {})
    finder.visit(ast.parse(source))
    return sorted(finder.found, key=lambda mutation: mutation.span)


def optional_arguments(sources: Iterable[str]) -> OptionalArguments:
    """Parameters with a default of all functions and dataclasses defined in these modules.

    Calls are matched by name alone: of definitions with one name, what all have in common counts.
    """
    found: dict[str, frozenset[str]] = {}
    for source in sources:
        for node in ast.walk(ast.parse(source)):
            for name, parameters in _defaults(node):
                found[name] = found.get(name, parameters) & parameters
    return found


def _defaults(node: ast.AST) -> Iterator[tuple[str, frozenset[str]]]:
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        if node.name != "__init__":
            yield node.name, _with_default(node.args)
    elif isinstance(node, ast.ClassDef):
        fields = frozenset(
            child.target.id
            for child in node.body
            if isinstance(child, ast.AnnAssign)
            and isinstance(child.target, ast.Name)
            and child.value is not None
        )
        for child in node.body:
            if isinstance(child, ast.FunctionDef) and child.name == "__init__":
                fields = _with_default(child.args)
        yield node.name, fields


def _with_default(arguments: ast.arguments) -> frozenset[str]:
    positional = [*arguments.posonlyargs, *arguments.args]
    last = positional[len(positional) - len(arguments.defaults) :]
    keyword = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    return frozenset([*(a.arg for a in last), *(a.arg for a, default in keyword if default)])


# The changes of each kind of node.


def _changed(node: Any, **fields: Any) -> Any:
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other


def _compare(node: ast.Compare) -> Iterator[ast.AST]:
    for index, operator in enumerate(node.ops):
        for other in COMPARISONS[type(operator)]:
            yield _changed(node, ops=[*node.ops[:index], other(), *node.ops[index + 1 :]])


def _arithmetic(node: ast.BinOp | ast.AugAssign) -> Iterator[ast.AST]:
    operands = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.value,)
    is_type = isinstance(node.op, ast.BitOr) and any(map(_is_type, operands))
    if type(node.op) in ARITHMETIC and not is_type and not any(map(_is_sequence, operands)):
        yield _changed(node, op=ARITHMETIC[type(node.op)]())


def _is_sequence(node: ast.expr) -> bool:
    text = isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
    return text or isinstance(node, ast.JoinedStr | ast.List | ast.Tuple | ast.ListComp)


def _is_type(node: ast.expr) -> bool:
    """Whether an operand of `|` looks like a type, so that the union is one of types."""
    if isinstance(node, ast.Constant):
        return node.value is None
    if isinstance(node, ast.Subscript):
        return _is_type(node.value)
    if isinstance(node, ast.BinOp):
        return _is_type(node.left) or _is_type(node.right)
    name = _name(node)
    builtin = name in {"int", "str", "float", "bool", "bytes", "list", "tuple", "dict", "set"}
    return builtin or (name[:1].isupper() and not name.isupper())


def _name(node: ast.AST) -> str:
    """The last part of a name, or an empty text."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _boolean(node: ast.BoolOp) -> Iterator[ast.AST]:
    yield _changed(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())


def _unary(node: ast.UnaryOp) -> Iterator[ast.AST]:
    number = isinstance(node.operand, ast.Constant)
    if isinstance(node.op, ast.Not) or (isinstance(node.op, ast.USub) and not number):
        yield node.operand


def _constant(node: ast.Constant) -> Iterator[ast.AST]:
    match node.value:
        case bool():
            yield ast.Constant(not node.value)
        case int() | float() if node.value + 1 != node.value:
            yield ast.Constant(node.value + 1)
        case str() if node.value and not PROSE.search(node.value):
            yield ast.Constant("mutant")


def _call(node: ast.Call, optional: OptionalArguments) -> Iterator[ast.AST]:
    if _name(node.func) not in SYMMETRIC_CALLS:
        for index, (one, two) in enumerate(pairwise(node.args)):
            if type(one) is type(two) and _swappable(one) and ast.dump(one) != ast.dump(two):
                arguments = [*node.args[:index], two, one, *node.args[index + 2 :]]
                yield _changed(node, args=arguments)
    for keyword in node.keywords:
        if keyword.arg in optional.get(_name(node.func), ()):
            yield _changed(node, keywords=[k for k in node.keywords if k is not keyword])


def _swappable(node: ast.expr) -> bool:
    return not isinstance(node, ast.Starred | ast.Constant)


def _return(node: ast.Return) -> Iterator[ast.AST]:
    if node.value is not None and not _is_none(node.value):
        yield ast.Return(ast.Constant(None))


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _assigned(node: ast.Assign) -> Iterator[ast.AST]:
    """Deleted, unless it is a plain name, which would be a NameError at its first use."""
    if isinstance(node.targets[0], ast.Attribute | ast.Subscript):
        yield ast.Pass()


def _expression(node: ast.Expr) -> Iterator[ast.AST]:
    if isinstance(node.value, ast.Call):
        yield ast.Pass()


def _deleted(node: ast.stmt) -> Iterator[ast.AST]:
    yield ast.Pass()


def _augmented(node: ast.AugAssign) -> Iterator[ast.AST]:
    yield from _arithmetic(node)
    yield ast.Pass()


CHANGES: Mapping[type[ast.AST], Callable[[Any], Iterator[ast.AST]]] = {
    ast.Compare: _compare,
    ast.BinOp: _arithmetic,
    ast.BoolOp: _boolean,
    ast.UnaryOp: _unary,
    ast.Constant: _constant,
    ast.Return: _return,
    ast.Assign: _assigned,
    ast.AugAssign: _augmented,
    ast.Expr: _expression,
    ast.Raise: _deleted,
    ast.Delete: _deleted,
    ast.Break: _deleted,
    ast.Continue: _deleted,
}


def _conditions(node: ast.AST) -> Iterable[ast.expr]:
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        return (node.test,)
    return node.ifs if isinstance(node, ast.comprehension) else ()


def _has_opposite(node: ast.expr) -> bool:
    """Whether another mutation of this condition is its negation."""
    if isinstance(node, ast.Compare):
        return len(node.ops) == 1
    return isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)


class _Finder(ast.NodeVisitor):
    """Walks over a module and notes each change, where it is and when it is executed."""

    def __init__(self, source: str, optional: OptionalArguments) -> None:
        lines = source.encode().splitlines(keepends=True)
        self.starts = [0, *accumulate(map(len, lines))]
        self.optional = optional
        self.found: list[Mutation] = []
        self.statement = 1
        self.at_import = True

    def visit(self, node: ast.AST) -> None:
        if _is_excluded(node):
            return
        around = self.statement
        if isinstance(node, ast.stmt | ast.excepthandler):
            self.statement = node.lineno
        if type(node) in CHANGES:
            self.note(node, CHANGES[type(node)](node))
        if isinstance(node, ast.Call):
            self.note(node, _call(node, self.optional))
        for condition in _conditions(node):
            if not _has_opposite(condition):
                self.note(condition, [ast.UnaryOp(ast.Not(), condition)])
        super().visit(node)
        self.statement = around

    def visit_all(self, nodes: Iterable[ast.AST]) -> None:
        for node in nodes:
            self.visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        self.visit_all(node.decorator_list)
        self.visit_all([*node.args.defaults, *filter(None, node.args.kw_defaults)])
        around, self.at_import = self.at_import, False
        self.visit_all(node.body)
        self.at_import = around

    visit_AsyncFunctionDef = visit_FunctionDef  # noqa: N815 (the name is ast's)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None and _name(node.annotation) != "TypeAlias":
            self.visit(node.value)

    def visit_Call(self, node: ast.Call) -> None:
        name = _name(node.func)
        if name == "zip":  # its `strict` is an assertion
            self.visit_all(node.args)
        elif name in TYPE_CALLS:
            self.visit_all(node.args[1:])
        else:
            self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        if _name(node.value) != "Literal":
            self.generic_visit(node)

    def note(self, node: Any, others: Iterable[ast.AST]) -> None:
        start = self.starts[node.lineno - 1] + node.col_offset
        end = self.starts[node.end_lineno - 1] + node.end_col_offset
        for other in others:
            after = ast.unparse(ast.fix_missing_locations(copy.deepcopy(other)))
            mutation = Mutation(
                node.lineno,
                node.end_lineno,
                node.col_offset + 1,
                self.statement,
                self.at_import,
                ast.unparse(node),
                after,
                (start, end),
                _spliced(other, after, node.end_lineno - node.lineno),
            )
            self.found.append(mutation)


def _spliced(node: ast.AST, text: str, lines: int) -> str:
    """Source of a node that takes up as many more lines as the one it replaces did."""
    if isinstance(node, ast.Constant) and not lines:
        return text
    return f"({text}{chr(10) * lines})" if isinstance(node, ast.expr) else text + "\n" * lines


def _is_excluded(node: ast.AST) -> bool:
    match node:
        case (
            ast.Import()
            | ast.ImportFrom()
            | ast.Assert()
            | ast.JoinedStr()
            | ast.Expr(value=ast.Constant())
            | ast.If(test=ast.Name(id="TYPE_CHECKING") | ast.Compare(left=ast.Name(id="__name__")))
        ):
            return True
        case ast.Assign(targets=[ast.Name(id=name)]):
            return name.startswith("__")
        case ast.keyword(arg=name):
            return name in PROSE_KEYWORDS
    return False
