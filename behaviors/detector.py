"""Detectors: functions that find things in camera frames, and how a person's own are marked.

The built-in ones are in :mod:`behaviors.detectors`.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from behaviors.action import arguments_of
from fsm.host import Parameter
from hal.vehicle import Frame

BUILT_IN = ("fiducials", "color", "people")
"""The names of the built-in detectors."""
_MARK = "_vencejo_detector"
_WORD = re.compile(r"[A-Za-z0-9_-]+")
F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Sighting:
    """A thing in a picture. Raises ValueError for a kind or an id that names no photo."""

    kind: str
    """A word for things like it: ``person``; up to 32 letters, digits, _ and -."""
    pixel: tuple[float, float]
    """Where it is seen; a pixel's centre is a whole number."""
    height: float = 0.0
    """Of what is seen there above the ground, metres."""
    id: str = ""
    """What tells it from others of its kind, such as the number of a marker; empty for nothing.
    Of such a word up to 16 letters."""
    box: tuple[int, int, int, int] | None = None
    """Left, top, right and bottom of what is seen of it, pixels."""

    def __post_init__(self) -> None:
        require_word(self.kind)
        if self.id != "":
            require_word(self.id, "id", 16)


def require_word(given: object, name: str = "kind", most: int = 32) -> None:
    """Raises ValueError for what cannot be part of the name of a thing, and so of its photo."""
    if not (isinstance(given, str) and len(given) <= most and _WORD.fullmatch(given)):
        allowed = f"is a word of up to {most} letters, digits, _ and -"
        raise ValueError(f"the {name} of a thing {allowed}, not {given!r:.60}")


Detector = Callable[[Frame, float], Sequence[Sighting]]
"""Finds things in a frame above ground that is at a height, mission frame, metres."""


class OwnDetector(NamedTuple):
    """A person's function that finds things."""

    name: str
    function: Callable[..., Any] | None = None
    """None for one that is taken on trust, because its file must not be run."""
    parameters: Mapping[str, Parameter] = {}
    """Its settings."""
    help: str = ""


def detector(function: F) -> F:
    """Let missions name this function under ``detect``.

    It is called with each new frame of the camera and the height of the ground below, mission
    frame, metres: ``find_cars(frame, ground)``; and gives a list of :class:`Sighting`. Arguments
    after these two are the settings that a mission may give it, by name.
    """
    setattr(function, _MARK, True)
    return function


def is_detector(thing: object) -> bool:
    """Whether an object is a function marked with :func:`detector`."""
    return inspect.isfunction(thing) and hasattr(thing, _MARK)


def describe_detector(function: Callable[..., Any]) -> OwnDetector:
    """A marked function as missions know it.

    Raises TypeError for one that cannot be called with a frame and a height.
    """
    name = function.__name__
    if inspect.iscoroutinefunction(function) or inspect.isgeneratorfunction(function):
        raise TypeError(f"{name}: a detector returns a list: it is not `async`, and has no `yield`")
    try:
        inspect.signature(function).bind_partial(None, 0.0)
    except TypeError:
        raise TypeError(f"{name}: write `def {name}(frame, ground): …`") from None
    help_ = inspect.getdoc(function) or ""
    return OwnDetector(name, function, arguments_of(function, after=2), help_)
