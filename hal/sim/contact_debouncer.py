"""Collisions of a vehicle: each touch once, when it begins."""

from __future__ import annotations

_PARTED = 20
"""Mission periods without contact after which the next one is a new touch: 0.5 s. What leans on a
wall trembles there."""


class Bumps:
    """Keeps what is being touched, beside what carries the vehicle."""

    def __init__(self) -> None:
        self.new: tuple[str, ...] = ()
        """What was first touched in the period that ended last."""
        self._felt: dict[str, None] = {}
        """In order; a set has none."""
        self._left: dict[str, int] = {}
        """How long each touch would still count as the same one, in periods."""

    def feel(self, names: tuple[str, ...]) -> None:
        """Take in what is being touched after a physics step."""
        self._felt.update(dict.fromkeys(names))

    def end_period(self) -> None:
        if not self._felt and not self._left:
            self.new = ()
            return
        self.new = tuple(name for name in self._felt if name not in self._left)
        kept = {name: left - 1 for name, left in self._left.items() if left > 1}
        self._left = kept | dict.fromkeys(self._felt, _PARTED)
        self._felt = {}
