"""What a behaviour's class must have for its calls to reach it, checked before anything flies."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from behaviors.behavior import Behavior


class Flaw(NamedTuple):
    """A mistake in a behaviour's class."""

    line: int
    """Of the file that the class stands in."""
    message: str
    hint: str


class _Method(NamedTuple):
    """A method as it is called."""

    arguments: tuple[str, ...]
    """Without ``self``."""
    written: str


METHODS: Mapping[str, _Method] = MappingProxyType(
    {
        "__init__": _Method(("params",), "def __init__(self, params): super().__init__(params)"),
        "start": _Method(("flight", "progress"), "def start(self, flight, progress=None): …"),
        "step": _Method(("flight",), "def step(self, flight): …"),
        "progress": _Method((), "def progress(self): …"),
        "stop": _Method(("flight",), "def stop(self, flight): …"),
    }
)


def flaws_of(behavior: type[Behavior]) -> Iterator[Flaw]:
    """The mistakes in a behaviour's class."""
    name = behavior.__name__
    if behavior.step is Behavior.step:
        yield Flaw(
            _line_of_class(behavior),
            f"'{name}' has no `step`",
            f"write `{METHODS['step'].written}`, which is called in every period; the name of a "
            "class that others build on begins with `_`",
        )
    for word, method in METHODS.items():
        function = getattr(behavior, word)
        message = _mistake_in(function, ("self", *method.arguments))
        if message:
            yield Flaw(
                _line_of_function(function, behavior),
                f"`{word}` of '{name}' {message}",
                f"write `{method.written}`",
            )
    message = _mistake_in_plan(behavior.plan)
    if message:
        yield Flaw(
            _line_of_function(behavior.plan, behavior),
            f"`plan` of '{name}' {message}",
            "write `@classmethod`, and under it `def plan(cls, params, start): …`",
        )
    for word in ("controls", "requires"):
        value = getattr(behavior, word)
        if isinstance(value, str) or not all(isinstance(each, str) for each in value):
            yield Flaw(
                _line_of_class(behavior),
                f"`{word}` of '{name}' is {value!r:.40}, not some words",
                f'write `{word} = ("motion",)` or `{word} = ()`',
            )


def _mistake_in_plan(plan: Any) -> str:
    """What keeps the plan of a class from being asked for; empty for nothing."""
    if callable(plan) and not inspect.ismethod(plan):
        return "is no class method: it is asked of the class, before there is a behaviour"
    return _mistake_in(plan, ("params", "start"))


def _mistake_in(function: Any, arguments: tuple[str, ...]) -> str:
    """What keeps a function from being called with these arguments; empty for nothing."""
    if not callable(function):
        return "is no method"
    if inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function):
        return "has a `yield` in it, so that a call of it does nothing"
    if inspect.iscoroutinefunction(function):
        return "is `async`, so that a call of it does nothing"
    return _misfit(function, arguments)


def _misfit(function: Callable[..., Any], arguments: tuple[str, ...]) -> str:
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return ""  # it is none of Python's own, and shows no signature
    for count in range(len(arguments) + 1):
        try:
            signature.bind_partial(*arguments[:count])
        except TypeError:
            return f"does not take the argument `{arguments[count - 1]}`"
    try:
        signature.bind(*arguments)
    except TypeError as error:
        return f"cannot be called with {', '.join(arguments)}: {error}"
    return ""


def _line_of_function(function: Any, behavior: type[Behavior]) -> int:
    code = getattr(function, "__code__", None)
    return code.co_firstlineno if code else _line_of_class(behavior)


def _line_of_class(behavior: type[Behavior]) -> int:
    try:
        return inspect.getsourcelines(behavior)[1]
    except (OSError, TypeError):
        return 1
