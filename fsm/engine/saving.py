"""Saving a running graph at the end of a mission period, and going on with it later.

A saved instance is a map that JSON can hold: the fields of its :class:`fsm.engine.state.State`,
each under its own name and in the form that FORMS gives it. States are written by their paths.
Host values are not in it, as the host gives new ones every period, nor are records nobody has taken
yet. Times are those of the vehicle's clock, which must have gone on.
"""

from __future__ import annotations

import json
import os
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

from fsm.chart.configuration import mask_of
from fsm.chart.executable import EXTERNAL, Origin
from fsm.chart.graph import Graph, Node
from fsm.engine.events import Delayed, DelayedEvents, Event
from fsm.engine.history import Memory
from fsm.engine.instance import Instance
from fsm.engine.shared import shared_by
from fsm.engine.state import Running, State
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.scope import FIRST_HOST_SLOT, TIME_SLOT
from fsm.host import Host
from fsm.values.packing import pack, unpack
from vencejo.errors import UserError, Where

FORMAT = "vencejo.saved"
VERSION = 2
"""The version of the form of saved runs; it goes up when earlier saves cannot be read any more."""

_DEEPEST = 800
"""Levels of lists and maps in a save, at most: no interpreter's own limit is lower."""
TORN = (LookupError, TypeError, ValueError, AttributeError, RecursionError)
"""The exceptions raised by reading a save that is damaged."""

Saved = dict[str, Any]


def save(instance: Instance) -> Saved:
    """The state of an instance at the end of a period, to resume from; changes nothing.

    Raises UserError (``unsavable``) when a behaviour keeps or publishes what JSON cannot hold.
    """
    graph, state = instance.graph, instance.state
    return {
        "format": FORMAT,
        "version": VERSION,
        "mission": graph.name,
        "digest": shared_by(graph).digest,
        **{name: form.write(graph, getattr(state, name)) for name, form in FORMS.items()},
        "running": {graph.nodes[i].path: _activity(each) for i, each in state.running.items()},
    }


def restore(graph: Graph, host: Host, saved: Mapping[str, Any]) -> Instance:
    """An instance that goes on where ``saved`` ends; running behaviours are resumed at once.

    Raises UserError for a save of another graph or version, or one that is not whole.
    """
    instance = Instance(graph, host)
    load(instance, saved)
    return instance


def load(instance: Instance, saved: Mapping[str, Any]) -> None:
    """Make an instance that has not begun go on where ``saved`` ends (see :func:`restore`)."""
    graph = instance.graph
    _refuse_other(graph, saved)
    try:
        state = State(**{name: form.read(graph, saved[name]) for name, form in FORMS.items()})
        running = [(graph.by_path[path], unpack(kept)) for path, kept in saved["running"].items()]
    except TORN as error:
        raise UserError(
            "torn-save",
            f"this save of '{graph.name}' is not whole: {type(error).__name__}: {error}",
            hint="use an earlier one, or start the mission anew",
        ) from None
    instance.go_on_from(state)
    # Last of all: behaviours may post events as soon as they are resumed.
    for node, kept in running:
        state.running[node.index] = begun = Running(None, kept is None)
        if kept is not None and node.invocation:
            begun.activity = instance.host.resume(node.invocation.behavior, node.path, kept)


def _activity(running: Running) -> Any:
    """The values from which the host resumes a behaviour; None for one that has ended."""
    return pack(running.activity.saved()) if running.activity and not running.ended else None


def _refuse_other(graph: Graph, saved: Mapping[str, Any]) -> None:
    if saved.get("format") != FORMAT:
        raise UserError(
            "not-a-save", "this is no saved mission", hint="name a file that write_saved has made"
        )
    version = saved.get("version")
    if version != VERSION:
        earlier = isinstance(version, int) and version < VERSION
        raise UserError(
            "other-version",
            f"the mission was saved by {'an earlier' if earlier else 'another'} version of "
            f"vencejo, in form {version}; this one reads form {VERSION}",
            hint="go on with the version that saved it, or start the mission anew",
        )
    if saved.get("digest") != shared_by(graph).digest:
        name = saved.get("mission")
        other = f"'{name}'" if name != graph.name else f"another text of '{name}'"
        raise UserError(
            "other-mission",
            f"{other} was saved, not this '{graph.name}'",
            hint="a saved run goes on only with the very mission it was saved from",
        )


# -- the form of each field ---------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Form:
    """The form of one field of the state in JSON: functions that write and read it."""

    write: Callable[[Graph, Any], Any]
    read: Callable[[Graph, Any], Any]


def _by_state(write: Callable[[Any], Any], read: Callable[[Node, Any], Any]) -> Form:
    """The form of a map by state indices: a map by paths."""
    return Form(
        lambda graph, found: {graph.nodes[index].path: write(v) for index, v in found.items()},
        lambda graph, saved: {
            graph.by_path[path].index: read(graph.by_path[path], v) for path, v in saved.items()
        },
    )


def _first_own_slot(graph: Graph) -> int:
    """The first slot after the time, the configuration and the host's values."""
    return FIRST_HOST_SLOT + len(graph.vocabulary.names)


def _write_values(graph: Graph, values: list[Any]) -> list[Any]:
    return [pack(value) for value in (values[TIME_SLOT], *values[_first_own_slot(graph) :])]


def _read_values(graph: Graph, saved: list[Any]) -> list[Any]:
    first = _first_own_slot(graph)
    time, *own = (unpack(value) for value in saved)
    if first + len(own) != graph.slots:
        raise ValueError(f"{len(own)} values instead of {graph.slots - first}")
    values = [None] * first + own
    values[TIME_SLOT] = float(time)
    return values


def _paths(nodes: Iterable[Node]) -> list[str]:
    return [node.path for node in nodes]


def _nodes(graph: Graph, paths: Iterable[str]) -> tuple[Node, ...]:
    return tuple(graph.by_path[path] for path in paths)


def _write_memories(graph: Graph, memories: Mapping[int, Memory]) -> Any:
    return {
        graph.nodes[index].path: {
            "states": _paths(memory.states),
            "kept": _paths(memory.kept),
            "progress": {graph.nodes[i].path: pack(p) for i, p in memory.progress.items()},
            "data": [[slot, pack(value)] for slot, value in memory.data.items()],
        }
        for index, memory in memories.items()
    }


def _read_memories(graph: Graph, saved: Mapping[str, Any]) -> dict[int, Memory]:
    return {
        graph.by_path[path].index: Memory(
            _nodes(graph, memory["states"]),
            _nodes(graph, memory["kept"]),
            {graph.by_path[state].index: unpack(p) for state, p in memory["progress"].items()},
            {slot: unpack(value) for slot, value in memory["data"]},
        )
        for path, memory in saved.items()
    }


def _write_event(event: Event) -> list[Any]:
    owner = None if event.owner is None else event.owner.path
    return [event.name, pack(event.fields), owner, event.entry, list(astuple(event.origin))]


def _read_event(graph: Graph, saved: list[Any]) -> Event:
    name, fields, owner, entry, *origin = saved
    node = None if owner is None else graph.by_path[owner]
    # Saves of the first form 2 know nothing of origins.
    return Event(name, unpack(fields), node, entry, Origin(*origin[0]) if origin else EXTERNAL)


_PLAIN = Form(lambda graph, value: pack(value), lambda graph, saved: unpack(saved))
_EVENTS = Form(
    lambda graph, events: [_write_event(event) for event in events],
    lambda graph, saved: deque(_read_event(graph, event) for event in saved),
)
FORMS: Mapping[str, Form] = {
    "values": Form(_write_values, _read_values),
    "configuration": Form(
        lambda graph, configuration: _paths(configuration.states),
        lambda graph, saved: shared_by(graph).configurations[mask_of(_nodes(graph, saved))],
    ),
    "entries": _by_state(int, lambda node, number: int(number)),
    "entry_count": Form(lambda graph, count: count, lambda graph, saved: int(saved)),
    "resumed": _by_state(pack, lambda node, progress: unpack(progress)),
    "finished": Form(
        lambda graph, finished: _paths(graph.nodes[index] for index in sorted(finished)),
        lambda graph, saved: {node.index for node in _nodes(graph, saved)},
    ),
    "conditions": _by_state(
        lambda conditions: [[c.since, sorted(c.due), sorted(c.spent)] for c in conditions],
        lambda node, saved: [
            Armed(when, since, set(due), set(spent))
            for when, (since, due, spent) in zip(node.whens, saved, strict=True)
        ],
    ),
    "timers": _by_state(
        lambda timers: [timer.due for timer in timers],
        lambda node, saved: [
            Timer(after, due) for after, due in zip(node.afters, saved, strict=True)
        ],
    ),
    "memories": Form(_write_memories, _read_memories),
    "urgent": _EVENTS,
    "external": _EVENTS,
    "internal": _EVENTS,
    "delayed": Form(
        lambda graph, delayed: [[s.due, s.id, _write_event(s.event), s.to] for s in delayed],
        lambda graph, saved: DelayedEvents(
            Delayed(due, id_, _read_event(graph, event), to) for due, id_, event, to in saved
        ),
    ),
    "broken": Form(
        lambda graph, broken: sorted([w.file, w.line, w.column, what] for w, what in broken),
        lambda graph, saved: {
            (Where(file, line, column), what) for file, line, column, what in saved
        },
    ),
    "reactions": Form(
        lambda graph, reactions: [[name, pack(fields)] for name, fields in reactions],
        lambda graph, saved: [(name, unpack(fields)) for name, fields in saved],
    ),
    "suspended_at": _PLAIN,
    "outcome": _PLAIN,
    "output": _PLAIN,
}
"""The form of each field of the state. Only ``running`` is not among them: behaviours are the
host's, which resumes them when all else is in place."""


# -- files --------------------------------------------------------------------------------------


def write_saved(path: Path, saved: Mapping[str, Any]) -> None:
    """Write a save so that at every moment ``path`` holds a whole one, the last or this.

    It is written beside ``path``, forced to the disk and renamed. Raises UserError.
    """
    beside = path.with_name(f".{path.name}.part")
    text = json.dumps(saved, allow_nan=False, separators=(",", ":"))
    try:
        with beside.open("w", encoding="utf-8") as file:
            file.write(text + "\n")
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        reason = error.strerror or str(error)
        raise UserError(
            "cannot-save", f"cannot save the mission: {reason}", Where(str(path))
        ) from None


def _sync_folder(folder: Path) -> None:
    """A rename is on the disk once its folder is."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _is_deeper(value: object, levels: int) -> bool:
    """Whether lists and maps are nested in a value by more levels than that."""
    inside = [value]
    while inside and levels >= 0:
        inside = [
            part
            for each in inside
            if isinstance(each, (list, dict))
            for part in (each.values() if isinstance(each, dict) else each)
        ]
        levels -= 1
    return bool(inside)


def read_saved(path: Path) -> Saved:
    """Read what :func:`write_saved` wrote. Raises UserError when it is not there or not whole."""
    place = Where(str(path))
    try:
        saved = json.loads(path.read_bytes())
    except FileNotFoundError:
        raise UserError("no-such-file", f"there is no file '{path}'", place) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError("unreadable", f"cannot read '{path}': {reason}", place) from None
    except (ValueError, RecursionError):
        saved = None
    if not isinstance(saved, dict) or _is_deeper(saved, _DEEPEST):
        raise UserError(
            "torn-save",
            "this is no whole saved mission",
            place,
            "it was cut off or is another file: use an earlier one, or start the mission anew",
        )
    return saved
