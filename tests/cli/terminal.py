"""A terminal without a window: what is written to it can be read from its screen."""

from __future__ import annotations

from io import TextIOBase

import pyte
from rich.console import Console


class Terminal(TextIOBase):
    """A VT100 with a screen (pyte), as the file of a console."""

    def __init__(self, columns: int, rows: int) -> None:
        self.screen = pyte.Screen(columns, rows)
        # A terminal's driver makes a carriage return and a line feed of a line's end.
        self.screen.set_mode(pyte.modes.LNM)
        self._stream = pyte.Stream(self.screen)
        self.console = Console(
            file=self,  # type: ignore[arg-type]
            force_terminal=True,
            color_system="standard",
            width=columns,
            height=rows,
        )

        self.written = 0
        """The number of times that something was written."""

    def write(self, text: str) -> int:
        self.written += 1
        self._stream.feed(text)
        return len(text)

    def writable(self) -> bool:
        return True

    def resize(self, columns: int, rows: int) -> None:
        self.screen.resize(rows, columns)
        self.console.size = (columns, rows)  # type: ignore[assignment]

    @property
    def lines(self) -> list[str]:
        """The rows of the screen, without spaces at their ends."""
        return [line.rstrip() for line in self.screen.display]

    def row_of(self, text: str) -> int:
        """The first row in which a text stands."""
        found = [row for row, line in enumerate(self.lines) if text in line]
        assert found, f"'{text}' is not on the screen:\n" + "\n".join(self.lines)
        return found[0]

    def colors_of(self, text: str) -> set[str]:
        """The colours of a text where it stands first."""
        row = self.row_of(text)
        first = self.screen.display[row].index(text)
        return {self.screen.buffer[row][first + k].fg for k in range(len(text))}
