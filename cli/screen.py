"""The whole of a terminal, to be painted again and again.

It is the terminal's alternate screen, so that what stood there comes back afterwards. Each picture
covers every cell, whatever the terminal has made of the last one when its size was changed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, RenderResult
from rich.control import Control
from rich.segment import ControlType
from rich.text import Text


@dataclass(frozen=True)
class Picture:
    """Rows that are shown as they are; rich would take long to look where to wrap them."""

    rows: Sequence[Text]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for row in self.rows:
            # Assembled anew, since the style of a whole text is otherwise not rendered.
            yield from Text.assemble(row).render(console, end="\n")


class Screen:
    """Paints on the terminal of a console from the first picture until it is closed."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._open = False

    def size(self) -> tuple[int, int]:
        """Columns and rows at this moment."""
        with suppress(OSError, ValueError):
            # Not the console's own size, which is that of standard input's terminal.
            columns, rows = os.get_terminal_size(self._console.file.fileno())
            if columns and rows:
                return columns, rows
        return self._console.size

    def paint(self, picture: Picture) -> None:
        """Show a picture of the present size."""
        console = self._console
        console.size = self.size()
        if not self._open:
            self._open = True
            console.set_alt_screen(True)
            console.show_cursor(False)
        console.update_screen(picture)

    def close(self) -> None:
        """Give the terminal back as it was; closing again does nothing."""
        if self._open:
            self._open = False
            # Terminals without an alternate screen keep the last picture otherwise.
            self._console.control(Control(ControlType.CLEAR, ControlType.HOME))
            self._console.set_alt_screen(False)
            self._console.show_cursor(True)
