"""Behaviours that give the vehicle one order and wait: takeoff, land, return_home."""

from __future__ import annotations

from behaviors.flight import Flight
from fsm.vocabulary import Outcome
from hal.vehicle import Order


class Waiting:
    """An order that was given, and how long its behaviour waits for it."""

    def __init__(self, order: Order, now: float, timeout: float) -> None:
        self.order = order
        self.deadline = now + timeout

    def step(self, flight: Flight) -> Outcome | str | None:
        """``done``, or ``failed`` with the vehicle's reason or because time is up."""
        order = self.order
        if order.state == "done":
            return "done"
        if order.state == "refused":
            return Outcome("failed", {"reason": f"{order.verb} refused: {order.reason}"})
        if flight.now >= self.deadline:
            return Outcome("failed", {"reason": f"{order.verb} took too long"})
        return None
