"""The mean of a value over the last periods."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence


class MovingAverage:
    """The mean of the last values of a number; so many as it begins with."""

    __slots__ = ("_sum", "_values", "change", "mean")

    def __init__(self, values: Iterable[float]) -> None:
        self._values = deque(values)
        self._sum = sum(self._values)
        self.mean = self._sum / len(self._values)
        self.change = 0.0
        """The newest value less the one that the last ``push`` dropped."""

    def push(self, value: float) -> float:
        """Take the next value, drop the oldest, and return the new mean."""
        values = self._values
        self.change = change = value - values.popleft()
        values.append(value)
        self._sum = total = self._sum + change
        self.mean = mean = total / len(values)
        return mean

    def progress(self) -> list[float]:
        """Its state, as JSON: the sum of the values, as it was rounded, and the values."""
        return [self._sum, *self._values]

    @classmethod
    def resumed(cls, progress: Sequence[float]) -> MovingAverage:
        """Continue from the progress of another one."""
        average = cls(progress[1:])
        average._sum = progress[0]
        return average
