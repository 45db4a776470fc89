"""Contact debouncing: each collision of a vehicle is reported once, when it begins."""

from __future__ import annotations

_RELEASE = 20
"""Release time of the debouncing in mission periods, 0.5 s: the time without contact after which
the next contact is a new one. A vehicle pressed against a wall bounces more often."""


class ContactDebouncer:
    """Turns the touches of physics steps into collisions of mission periods."""

    def __init__(self) -> None:
        self.new: tuple[str, ...] = ()
        """Names of the things that the vehicle began to touch, by a hit, in the last period."""
        self._touched: dict[str, bool] = {}
        """Name of each thing touched in this period, in the order of contact → whether by a hit."""
        self._periods_left: dict[str, int] = {}
        """Name → number of further periods in which a touch is no new contact."""

    def add(self, name: str, hit: bool) -> None:
        """Add the touch of a thing in a physics step: a hit, or what the vehicle stands on."""
        self._touched[name] = hit or self._touched.get(name, False)

    def end_period(self) -> None:
        """End a mission period and set :attr:`new` to its collisions."""
        touched, left = self._touched, self._periods_left
        if not touched and not left:
            self.new = ()
            return
        self.new = tuple(name for name, hit in touched.items() if hit and name not in left)
        running = {name: periods - 1 for name, periods in left.items() if periods > 1}
        self._periods_left = running | dict.fromkeys(touched, _RELEASE)
        self._touched = {}
