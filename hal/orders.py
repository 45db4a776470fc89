"""The orders that a vehicle is carrying out."""

from __future__ import annotations

from hal.vehicle import Order


class Orders:
    """What is under way, by verb. A new order takes the place of those before it."""

    def __init__(self) -> None:
        self._under_way: dict[str, Order] = {}

    def get(self, verb: str) -> Order | None:
        """The order of that verb, if it is under way."""
        return self._under_way.get(verb)

    def begin(self, verb: str) -> Order:
        """Accept a new order."""
        self.end(f"ended by: {verb}")
        order = self._under_way[verb] = Order(verb, "accepted")
        return order

    def end(self, reason: str = "") -> None:
        """All that is under way is done or, with a reason, refused."""
        for order in self._under_way.values():
            order.state, order.reason = ("refused", reason) if reason else ("done", "")
        self._under_way.clear()
