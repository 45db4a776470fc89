"""Behaviours that give the vehicle one order and wait: takeoff, land, return_home and others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.flight import Flight
from fsm.host import Outcome
from hal.orders import Order

EPSILON = 1e-9
"""Seconds that a sum of times may be off."""


class Waiting:
    """An order that was given, and how long its behaviour waits for it."""

    def __init__(
        self, order: Order, now: float, timeout: float, progress: Mapping[str, Any] | None = None
    ) -> None:
        self.order = order
        self.timeout = timeout
        self.started = now - (progress or {}).get("waited", 0.0)
        self.waited = now - self.started

    def progress(self) -> dict[str, Any]:
        """How long it has waited; the order itself is given again, which changes nothing."""
        return {"waited": self.waited}

    def step(self, flight: Flight) -> Outcome | str | None:
        """``done``, or ``failed``: refused by the vehicle, lost on the way, or time is up."""
        order = self.order
        self.waited = flight.now - self.started
        if order.state == "done":
            return "done"
        if order.ended:
            return Outcome("failed", {"reason": f"{order.verb} {order.state}: {order.reason}"})
        if self.waited >= self.timeout - EPSILON:
            return Outcome("failed", {"reason": f"{order.verb} took too long"})
        return None
