"""Suspending a running graph and going on with it later, as if no time had passed for it.

Behaviours are stopped with their progress and start with it again, as after a history state;
timers, delayed sends, lasting conditions and `time_in_state` stand still meanwhile.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fsm.vocabulary import Reaction

if TYPE_CHECKING:
    from fsm.machine import Instance

WAKING: tuple[Reaction, ...] = ("resume", "land")
"""Urgent events with these reactions end a suspension: the operator gives the vehicle back, or
something happened that cannot wait for that."""


def stop_behaviors(instance: Instance) -> None:
    """Stop what is at work; it goes on from its progress when it is started again."""
    for node in reversed(instance.active):
        running = instance._running.get(node.index)
        if running is None or running.ended or running.activity is None:
            continue
        progress = running.activity.progress()
        if progress is not None:
            instance._resumed[node.index] = progress
        instance.record("stop", state=node.path)
        running.activity.stop()
        del instance._running[node.index]


def shift_clocks(instance: Instance, seconds: float) -> None:
    """Move everything that waits, or was counted from, a time."""
    for node in instance.active:
        instance.slots[node.entered_slot] += seconds
        for timer in instance._timers.get(node.index, ()):
            if timer.due is not None:
                timer.due += seconds
        for condition in instance._conditions.get(node.index, ()):
            if condition.since is not None:
                condition.since += seconds
    for sent in instance._delayed:
        sent.due += seconds
