"""Contact debouncing: each collision of a vehicle is reported once, when it begins."""

from __future__ import annotations

_RELEASE = 20
"""Mission periods without contact after which the next one is a new collision: 0.5 s. A vehicle
that leans on a wall bounces off it and back again and again in less."""


class ContactDebouncer:
    """Turns the contacts of physics steps into collisions of mission periods."""

    def __init__(self) -> None:
        self.new: tuple[str, ...] = ()
        """Names of what the vehicle began to touch in the period that ended last."""
        self._touched: dict[str, None] = {}
        """Names of what it touched in this period, in the order of contact."""
        self._periods_left: dict[str, int] = {}
        """For how many more periods a contact with that name is no new collision."""

    def add(self, names: tuple[str, ...]) -> None:
        """Take in the names of what is in contact after a physics step."""
        self._touched.update(dict.fromkeys(names))

    def end_period(self) -> None:
        """End a mission period: :attr:`new` is then its collisions."""
        if not self._touched and not self._periods_left:
            self.new = ()
            return
        self.new = tuple(name for name in self._touched if name not in self._periods_left)
        running = {name: left - 1 for name, left in self._periods_left.items() if left > 1}
        self._periods_left = running | dict.fromkeys(self._touched, _RELEASE)
        self._touched = {}
