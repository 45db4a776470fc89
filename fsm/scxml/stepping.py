"""Runs SCXML documents in their own time: the clock jumps from one event to the next."""

from __future__ import annotations

from fsm.engine.instance import Instance
from fsm.engine.waiting import EPSILON

MAX_PERIODS = 10_000


def advance(instance: Instance, now: float) -> None:
    """Process all posted events, and the sent ones that are due up to ``now`` seconds, in order.

    Raises RuntimeError after MAX_PERIODS: the document then sends itself events for ever.
    """
    if not instance.ended:
        instance.period(_earliest(instance, now))
    for _ in range(MAX_PERIODS):
        due = instance.next_due()
        if due is None or due > now + EPSILON:
            if not instance.ended and instance.now < now:
                instance.period(now)
            return
        instance.period(_earliest(instance, now))
    raise RuntimeError(f"more than {MAX_PERIODS} periods without coming to rest")


def _earliest(instance: Instance, now: float) -> float:
    due = instance.next_due()
    return max(instance.now, now if due is None else min(due, now))
