"""Functions in Python beside a mission that it may `call`; they return at once and move nothing."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Callable
from typing import Any, TypeVar

from behaviors.params import type_of
from fsm.host import Function, Parameter

F = TypeVar("F", bound=Callable[..., Any])
_MARK = "_vencejo_action"


def action(function: F) -> F:
    """Let missions `call` this function by its name.

    A mission gives its arguments by name: `call: {leds: {color: red}}`. The function must return
    at once; its result is ignored, and an exception becomes `error.execution`.
    """
    setattr(function, _MARK, True)
    return function


def is_action(thing: object) -> bool:
    """Whether an object is a function marked with :func:`action`."""
    return inspect.isfunction(thing) and hasattr(thing, _MARK)


def describe_action(function: Callable[..., Any]) -> Function:
    """The checker's view of an action.

    Raises TypeError for an argument that has no name, and for a function whose call does nothing.
    """
    if inspect.iscoroutinefunction(function) or inspect.isgeneratorfunction(function):
        raise TypeError(f"{function.__name__}: an action is neither `async` nor has it a `yield`")
    parameters = arguments_of(function)
    help_ = inspect.getdoc(function) or ""
    return Function(function.__name__, help_, parameters, function)


def arguments_of(function: Callable[..., Any], after: int = 0) -> dict[str, Parameter]:
    """The arguments of a person's function by name, but for the first ``after`` ones.

    Raises TypeError for one that has no name.
    """
    hints = typing.get_type_hints(function)
    parameters = {}
    for name, declared in [*inspect.signature(function).parameters.items()][after:]:
        if declared.kind not in (declared.POSITIONAL_OR_KEYWORD, declared.KEYWORD_ONLY):
            raise TypeError(f"{function.__name__}: its arguments need names: {declared}")
        required = declared.default is declared.empty
        default = None if required else declared.default
        parameters[name] = Parameter(name, type_of(hints.get(name, Any)), default, required)
    return parameters
