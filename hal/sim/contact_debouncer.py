"""Contact debouncing: each collision of a vehicle is reported once, when it begins."""

from __future__ import annotations

_RELEASE = 20
"""Release time of the debouncing in mission periods, 0.5 s: the time without contact after which
the next contact is a new collision. A vehicle pressed against a wall bounces more often."""


class ContactDebouncer:
    """Turns the contacts of physics steps into collisions of mission periods."""

    def __init__(self) -> None:
        self.new: tuple[str, ...] = ()
        """Names of the things that the vehicle began to touch in the last period."""
        self._touched: dict[str, None] = {}
        """Names of the things touched in this period, in the order of contact."""
        self._periods_left: dict[str, int] = {}
        """Name → number of further periods in which a contact is no new collision."""

    def add(self, names: tuple[str, ...]) -> None:
        """Add the names of the things in contact after a physics step."""
        self._touched.update(dict.fromkeys(names))

    def end_period(self) -> None:
        """End a mission period and set :attr:`new` to its collisions."""
        if not self._touched and not self._periods_left:
            self.new = ()
            return
        self.new = tuple(name for name in self._touched if name not in self._periods_left)
        running = {name: left - 1 for name, left in self._periods_left.items() if left > 1}
        self._periods_left = running | dict.fromkeys(self._touched, _RELEASE)
        self._touched = {}
