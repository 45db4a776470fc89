"""The order that takeoff, land, return_home and others give the vehicle and wait for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.flight import Flight
from fsm.host import Outcome
from hal.orders import Order

EPSILON = 1e-9
"""Rounding errors of a sum of times are smaller than this, seconds."""


class PendingOrder:
    """An order that a behaviour waits for, with a timeout in seconds."""

    def __init__(
        self, order: Order, now: float, timeout: float, progress: Mapping[str, Any] | None = None
    ) -> None:
        self.order = order
        self.timeout = timeout
        self.started = now - (progress or {}).get("waited", 0.0)
        self.waited = now - self.started

    def progress(self) -> dict[str, Any]:
        """The seconds waited, as JSON; to give the order again on resuming changes nothing."""
        return {"waited": self.waited}

    def step(self, flight: Flight) -> Outcome | str | None:
        """The outcome: ``done``, or ``failed`` if refused, lost or too slow; None before."""
        order = self.order
        if order.state == "done":
            return "done"
        if order.ended:
            return Outcome("failed", {"reason": f"{order.verb} {order.state}: {order.reason}"})
        return self.too_slow(flight)

    def too_slow(self, flight: Flight) -> Outcome | None:
        """The outcome ``failed`` once the timeout is over."""
        self.waited = flight.now - self.started
        if self.waited >= self.timeout - EPSILON:
            return Outcome("failed", {"reason": f"{self.order.verb} took too long"})
        return None
