"""A small map of a path in a terminal: eight dots to a character (Unicode braille)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
MIN_SPAN = 6.0
"""The map never shows less than this, metres: standing still is not zoomed in on."""

XY = tuple[float, float]


class Sketch:
    """Collects places over the ground and draws them from above, north up."""

    def __init__(self, columns: int, rows: int) -> None:
        self.columns = columns
        self.rows = rows
        self.path: list[XY] = []
        self._low = [0.0, 0.0]
        self._high = [0.0, 0.0]

    def add(self, place: XY) -> None:
        """Go on to a place; one within a few centimetres of the last is left out."""
        if self.path and max(abs(place[i] - self.path[-1][i]) for i in (0, 1)) < 0.05:
            return
        self.path.append(place)
        self.include([place])

    def include(self, places: Iterable[XY]) -> None:
        """Make the map large enough for these places too."""
        for place in places:
            for axis in (0, 1):
                self._low[axis] = min(self._low[axis], place[axis])
                self._high[axis] = max(self._high[axis], place[axis])

    def draw(self, marks: Mapping[str, Sequence[XY]]) -> list[str]:
        """Lines of text; ``marks`` are letters to set at places, the last one on top."""
        width, height = self.columns * 2 - 1, self.rows * 4 - 1
        span = max(
            MIN_SPAN,
            (self._high[0] - self._low[0]) * 1.1,
            (self._high[1] - self._low[1]) * 1.1 * width / height,
        )
        scale = width / span
        middle = [(self._low[axis] + self._high[axis]) / 2 for axis in (0, 1)]

        def dot(place: XY) -> tuple[int, int]:
            x = round(width / 2 + (place[0] - middle[0]) * scale)
            y = round(height / 2 - (place[1] - middle[1]) * scale)
            return min(max(x, 0), width), min(max(y, 0), height)

        cells = [[0] * self.columns for _ in range(self.rows)]
        for place in self.path:
            x, y = dot(place)
            cells[y // 4][x // 2] |= _DOTS[y % 4][x % 2]
        lines = [[chr(0x2800 + cell) if cell else " " for cell in row] for row in cells]
        for letter, places in marks.items():
            for place in places:
                x, y = dot(place)
                lines[y // 4][x // 2] = letter
        return ["".join(line) for line in lines]
