"""Behaviours by name: those installed, and those in Python files beside a mission."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import TypeGuard

from behaviors.action import describe_action, is_action
from behaviors.behavior import Behavior, describe
from behaviors.calls import Calls, CodeFailed
from behaviors.detector import BUILT_IN, OwnDetector, describe_detector, is_detector
from behaviors.host_functions import HOST_FUNCTIONS
from fsm.host import BehaviorInfo, Function
from vencejo.errors import Fault, UserError, Where
from vencejo.files import file_inside, nearest_file
from vencejo.nodes import Scalar
from vencejo.plugins import plugins

GROUP = "vencejo.behaviors"


class Registry(Mapping[str, BehaviorInfo]):
    """Behaviours by name; an installed one is imported when it is first looked up.

    One that cannot be imported raises UserError (``broken-code``).
    """

    def __init__(
        self,
        own: Mapping[str, BehaviorInfo] | None = None,
        calls: Calls | None = None,
        detectors: Mapping[str, OwnDetector] | None = None,
    ) -> None:
        """``own`` and ``detectors`` are those of the mission's own files."""
        self._detectors = detectors or {}
        self._points = plugins(GROUP)
        self._known: dict[str, BehaviorInfo] = dict(own or {})
        self._calls = calls or Calls()

    def __getitem__(self, name: str) -> BehaviorInfo:
        if name not in self._known:
            self._known[name] = self._load(self._points[name])
        return self._known[name]

    def _load(self, point: EntryPoint) -> BehaviorInfo:
        try:
            return self._calls.run(lambda: describe(self._bound(point.load()), point.name))
        except CodeFailed as error:
            raise UserError(
                "broken-code",
                f"the installed behaviour '{point.name}' cannot be loaded: {error.message}",
                error.where,
                f"it is {point.value} of {point.dist.name if point.dist else 'no package'}",
            ) from None

    def _bound(self, behavior: type[Behavior]) -> type[Behavior]:
        """A behaviour that knows the mission's own detectors."""
        if not self._detectors:
            return behavior
        known = {"detectors": self._detectors, "__doc__": behavior.__doc__}
        return type(behavior.__name__, (behavior,), known)

    def __contains__(self, name: object) -> bool:
        return name in self._known or name in self._points

    def __iter__(self) -> Iterator[str]:
        return iter(sorted({*self._points, *self._known}))

    def __len__(self) -> int:
        return len({*self._points, *self._known})


Own = dict[str, BehaviorInfo | Function | OwnDetector]
"""Behaviours, functions and detectors of a mission's own Python files, by name."""


def load_all(files: Iterable[tuple[Scalar, Path]], calls: Calls | None = None) -> Own:
    """Load the behaviours and functions in the Python files that missions name under ``uses``.

    ``files``: each name with the folder that it is relative to. The files are run, each once, as
    ``calls``; they must lie inside their folder. Raises UserError.
    """
    found: Own = {}
    seen: set[Path] = set()
    calls = calls or Calls()
    taken = {*Registry(), *HOST_FUNCTIONS, *BUILT_IN}
    for scalar, folder in files:
        path = path_of(scalar, folder)
        if path in seen:
            continue
        seen.add(path)
        for info in _contents(scalar, path, calls):
            what = "behaviour" if isinstance(info, BehaviorInfo) else "function"
            if info.name in taken or info.name in found:
                raise UserError(
                    "name-taken",
                    f"'{scalar.text}' has a {what} '{info.name}', but there is one already",
                    scalar.where,
                    "give the class another name, or set its `name`"
                    if what == "behaviour"
                    else "give the function another name",
                )
            found[info.name] = info
    return found


def path_of(scalar: Scalar, folder: Path) -> Path:
    """The file that a mission names under ``uses``. Raises UserError when it may not be used."""
    name, where = scalar.text, scalar.where
    path = file_inside(folder, scalar, "Python that a mission uses")
    if not path.is_file():
        files = [str(file.relative_to(folder)) for file in folder.glob("*.py")]
        hint = nearest_file(
            name, files, None if files else "no Python file lies beside the mission"
        )
        raise UserError("no-such-file", f"there is no file '{name}'", where, hint)
    return path


def _contents(
    scalar: Scalar, path: Path, calls: Calls
) -> list[BehaviorInfo | Function | OwnDetector]:
    name, where = scalar.text, scalar.where
    module_name = f"_vencejo_uses_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}_{path.stem}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise UserError("not-python", f"'{name}' is no Python file", where, "its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        found = calls.run(_run, module, spec.loader.exec_module, name)
    except CodeFailed as error:
        sys.modules.pop(module_name, None)
        if isinstance(error.cause, _Flawed):
            raise UserError.of(error.cause.faults) from None
        raise UserError(
            "broken-code",
            f"'{name}' cannot be loaded: {error.message}",
            Where(name, _line_in(error.cause, path), 1),
            f"named under `uses` at {where}",
        ) from None
    if not found:
        hint = "write `class Circle(Behavior): …`, with `from behaviors import Behavior`"
        raise UserError("no-behaviour", f"there is no behaviour in '{name}'", where, hint)
    return found


class _Flawed(UserError):
    """The classes of a file have flaws."""


def _run(
    module: ModuleType, execute: Callable[[ModuleType], None], name: str
) -> list[BehaviorInfo | Function | OwnDetector]:
    """Run a person's file, and look at what it defines. Raises _Flawed, and anything else."""
    # Most missions have no Python beside them: what looks at it is imported when there is some.
    from behaviors.declaration import flaws_of

    execute(module)
    # A class with two names in its file is one behaviour.
    own = dict.fromkeys(thing for thing in vars(module).values() if _is_own(thing, module))
    flaws = [
        Fault("bad-behaviour", flaw.message, Where(name, flaw.line, 1), flaw.hint)
        for behavior in own
        for flaw in flaws_of(behavior)
    ]
    if flaws:
        raise _Flawed.of(flaws)
    things = [
        thing
        for thing in dict.fromkeys(filter(inspect.isfunction, vars(module).values()))
        if thing.__module__ == module.__name__
    ]
    return [
        *map(describe, own),
        *map(describe_action, filter(is_action, things)),
        *map(describe_detector, filter(is_detector, things)),
    ]


def _is_own(thing: object, module: ModuleType) -> TypeGuard[type[Behavior]]:
    """Whether an object is a public behaviour class defined in this very file."""
    return (
        isinstance(thing, type)
        and issubclass(thing, Behavior)
        and thing.__module__ == module.__name__
        and not thing.__name__.startswith("_")
    )


def _line_in(error: BaseException | None, path: Path) -> int:
    """The line of the user's file that an error comes from."""
    if error is None:
        return 1
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return error.lineno or 1
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    return next((line for line in reversed(lines) if line), 1)
