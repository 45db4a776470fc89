"""Functions that a mission may `call`: Python beside it, prompt and never motion."""

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

    Its arguments, which need names, are what a mission gives: `call: {leds: {color: red}}`. It
    must return at once; what it returns is not used, and what it raises is `error.execution`.
    """
    setattr(function, _MARK, True)
    return function


def is_action(thing: object) -> bool:
    """Whether something was marked with :func:`action`."""
    return inspect.isfunction(thing) and hasattr(thing, _MARK)


def describe_action(function: Callable[..., Any]) -> Function:
    """An action as the checker sees it. Raises TypeError for arguments that have no name."""
    hints = typing.get_type_hints(function)
    parameters = {}
    for name, declared in inspect.signature(function).parameters.items():
        if declared.kind not in (declared.POSITIONAL_OR_KEYWORD, declared.KEYWORD_ONLY):
            raise TypeError(f"{function.__name__}: arguments of an action need names: {declared}")
        required = declared.default is declared.empty
        default = None if required else declared.default
        parameters[name] = Parameter(name, type_of(hints.get(name, Any)), default, required)
    help_ = inspect.getdoc(function) or ""
    return Function(function.__name__, help_, parameters, function)
