"""Saving a running graph at the end of a mission period, and going on with it later.

A saved instance is a map that JSON can hold: everything the next period depends on except the
graph and the host. Host values are not in it, as the host gives new ones every period, nor are
records nobody has taken yet. Times are those of the vehicle's clock, which must have gone on.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fsm.chart.graph import Graph, Node
from fsm.engine.events import Event
from fsm.engine.history import Memory
from fsm.engine.instance import Instance
from fsm.engine.microstep import Running
from fsm.engine.outbox import Delayed
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.scope import FIRST_HOST_SLOT, TIME_SLOT
from fsm.host import Host
from fsm.values.packing import pack, unpack
from vencejo.errors import UserError, Where

FORMAT = "vencejo.saved"
VERSION = 1
"""Of the form of saved runs; one more whenever an older one cannot be read any more."""

TORN = (LookupError, TypeError, ValueError, AttributeError, RecursionError)
"""What reading a save raises that is not as it was written."""

Saved = dict[str, Any]


def save(instance: Instance) -> Saved:
    """Everything needed to go on later. Only at the end of a period; changes nothing.

    Raises UserError (``unsavable``) when a behaviour keeps or publishes what JSON cannot hold.
    """
    graph = instance.graph
    nodes = graph.nodes
    return {
        "format": FORMAT,
        "version": VERSION,
        "mission": graph.name,
        "digest": graph.digest,
        "time": instance.now,
        "suspended_at": instance.suspended_at,
        "outcome": instance.outcome,
        "output": pack(instance.output),
        "active": _paths(instance.active),
        "slots": [pack(value) for value in instance.slots[_first_own_slot(graph) :]],
        "entries": {nodes[index].path: number for index, number in instance._entries.items()},
        "entry_count": instance._entry_count,
        "finished": _paths(nodes[index] for index in sorted(instance._finished)),
        "conditions": {
            nodes[index].path: [[a.since, sorted(a.due), sorted(a.spent)] for a in armed]
            for index, armed in instance._conditions.items()
        },
        "timers": {
            nodes[index].path: [timer.due for timer in timers]
            for index, timers in instance._timers.items()
        },
        "running": {
            nodes[index].path: pack(running.activity.saved())
            if running.activity and not running.ended
            else None
            for index, running in instance._running.items()
        },
        "resumed": {nodes[index].path: pack(p) for index, p in instance._resumed.items()},
        "memories": {
            nodes[index].path: {
                "states": _paths(memory.states),
                "kept": _paths(memory.kept),
                "progress": {nodes[i].path: pack(p) for i, p in memory.progress.items()},
                "data": [[slot, pack(value)] for slot, value in memory.data.items()],
            }
            for index, memory in instance._memories.items()
        },
        "broken": sorted([w.file, w.line, w.column, what] for w, what in instance._broken),
        "urgent": [_event(event) for event in instance._urgent],
        "external": [_event(event) for event in instance._external],
        "internal": [_event(event) for event in instance._internal],
        "delayed": [[sent.due, sent.id, _event(sent.event), sent.to] for sent in instance._delayed],
        "reactions": [[name, pack(fields)] for name, fields in instance.reactions],
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
    graph, host = instance.graph, instance.host
    _refuse_other(graph, saved)
    try:
        _fill(instance, saved)
        running = {
            graph.by_path[path].index: (graph.by_path[path], unpack(kept))
            for path, kept in saved["running"].items()
        }
    except TORN as error:
        raise UserError(
            "torn-save",
            f"this save of '{graph.name}' is not whole: {type(error).__name__}: {error}",
            hint="use an earlier one, or start the mission anew",
        ) from None
    for index, (node, kept) in running.items():
        instance._running[index] = begun = Running(None, kept is None)
        if kept is not None and node.invocation:
            begun.activity = host.resume(node.invocation.behavior, node.path, kept)


def _refuse_other(graph: Graph, saved: Mapping[str, Any]) -> None:
    if saved.get("format") != FORMAT:
        raise UserError(
            "not-a-save", "this is no saved mission", hint="name a file that write_saved has made"
        )
    if saved.get("version") != VERSION:
        raise UserError(
            "other-version",
            f"the mission was saved in form {saved.get('version')}, and this program reads "
            f"form {VERSION}",
            hint="go on with the version of vencejo that saved it",
        )
    if saved.get("digest") != graph.digest:
        name = saved.get("mission")
        other = f"'{name}'" if name != graph.name else f"another text of '{name}'"
        raise UserError(
            "other-mission",
            f"{other} was saved, not this '{graph.name}'",
            hint="a saved run goes on only with the very mission it was saved from",
        )


def _fill(instance: Instance, saved: Mapping[str, Any]) -> None:
    graph = instance.graph
    by_path, first = graph.by_path, _first_own_slot(graph)
    slots = [unpack(value) for value in saved["slots"]]
    if first + len(slots) != graph.slots:
        raise ValueError(f"{len(slots)} values instead of {graph.slots - first}")
    instance.slots[first:] = slots
    instance.slots[TIME_SLOT] = float(saved["time"])
    instance.suspended_at = saved["suspended_at"]
    instance.outcome, instance.output = saved["outcome"], unpack(saved["output"])
    instance._settle(sum(by_path[path].mask for path in saved["active"]))
    for path, number in saved["entries"].items():
        instance._entries[by_path[path].index] = number
    instance._entry_count = int(saved["entry_count"])
    instance._finished.update(by_path[path].index for path in saved["finished"])
    for path, conditions in saved["conditions"].items():
        instance._conditions[by_path[path].index] = [
            Armed(when, since, set(due), set(spent))
            for when, (since, due, spent) in zip(by_path[path].whens, conditions, strict=True)
        ]
    for path, times in saved["timers"].items():
        instance._timers[by_path[path].index] = [
            Timer(after, due) for after, due in zip(by_path[path].afters, times, strict=True)
        ]
    for path, progress in saved["resumed"].items():
        instance._resumed[by_path[path].index] = unpack(progress)
    for path, memory in saved["memories"].items():
        instance._memories[by_path[path].index] = Memory(
            tuple(by_path[state] for state in memory["states"]),
            tuple(by_path[state] for state in memory["kept"]),
            {by_path[state].index: unpack(p) for state, p in memory["progress"].items()},
            {slot: unpack(value) for slot, value in memory["data"]},
        )
    instance._broken.update(
        (Where(file, line, column), what) for file, line, column, what in saved["broken"]
    )
    for queue, events in (
        (instance._urgent, saved["urgent"]),
        (instance._external, saved["external"]),
        (instance._internal, saved["internal"]),
    ):
        queue.extend(_event_of(event, by_path) for event in events)
    instance._delayed[:] = [
        Delayed(due, id_, _event_of(event, by_path), to) for due, id_, event, to in saved["delayed"]
    ]
    instance.reactions = [(name, unpack(fields)) for name, fields in saved["reactions"]]


def _first_own_slot(graph: Graph) -> int:
    """Before it lie the time, the configuration and the host's values."""
    return FIRST_HOST_SLOT + len(graph.vocabulary.names)


def _paths(nodes: Iterable[Node]) -> list[str]:
    return [node.path for node in nodes]


def _event(event: Event) -> list[Any]:
    owner = None if event.owner is None else event.owner.path
    return [event.name, pack(event.fields), owner, event.entry]


def _event_of(packed: list[Any], by_path: Mapping[str, Node]) -> Event:
    name, fields, owner, entry = packed
    return Event(name, unpack(fields), None if owner is None else by_path[owner], entry)


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


def read_saved(path: Path) -> Saved:
    """What :func:`write_saved` wrote. Raises UserError when it is not there or not whole."""
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
    if not isinstance(saved, dict):
        raise UserError(
            "torn-save",
            "this is no whole saved mission",
            place,
            "it was cut off or is another file: use an earlier one, or start the mission anew",
        )
    return saved
