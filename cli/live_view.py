"""The live view of a flight on a terminal: figures, the tree of states, a map, what happened."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from io import TextIOBase
from math import dist, pi
from operator import itemgetter
from typing import NamedTuple, TextIO

from rich.console import Console
from rich.text import Text

from behaviors import Pilot
from cli.narrator import Line, clock, height_of
from cli.screen import Picture, Screen
from cli.sketch import XY, Mark, Sketch
from cli.state_tree import draw_tree
from cli.vehicle_colors import legible
from cli.vehicle_rows import Watched, battery_style, end_of, vehicle_rows, where
from fsm.engine.instance import Record
from runner.by_vehicle import ALONE
from runner.course import one_line
from vencejo.geometry import Point
from worlds import World, outlines_of

REFRESH = 0.1
"""Seconds of wall time between two pictures, at least."""
SAMPLE = 0.1
"""Seconds of flight between two points of the path on the map."""
SHARE = 0.03
"""Share of the wall time that drawing may take: where it takes long, it is done less often."""
TWO_COLUMNS = 80
"""Columns of a terminal from which on the map stands beside the states."""
NEAR = 50.0
"""Metres about home within which things are on the map before the vehicle gets there."""
FAR = 1000.0
"""Metres about home within which named places are."""
BELOW = 6
"""Rows that the last picture leaves for the summary below it."""
RULED = 16
"""Rows of a picture from which on a rule stands above what happened."""
MIN_MAP = 5
"""Rows below which there is no map below the states."""
MAX_LINES = 100
"""Lines of each kind, and of a person's own output, that are kept."""
CLOCK = 9
"""Columns of the time before a line, and of the indent of its further rows."""
_ARROWS = "→↗↑↖←↙↓↘"


class _Told(NamedTuple):
    """A line with its number among all."""

    number: int
    time: str
    line: Line


class LiveView:
    """The flight redrawn in place as long as it lasts; use it in a ``with``.

    Of one vehicle the tree of its states is shown, of several a row for each; the map shows all, in
    the world frame as it was when the run began.
    """

    def __init__(
        self,
        console: Console,
        world: World | None,
        factor: float | None,
        wall: Callable[[], float] = time.monotonic,
        *,
        fleet: str = "",
        vehicles: Sequence[str] = (ALONE,),
    ) -> None:
        """``world``: with its outlines on the map; None for none.

        ``factor``: the speed of the run, times real time; None for as fast as it can. ``wall``
        gives the seconds of wall time. ``fleet`` and ``vehicles``: the names of several vehicles
        and of what joins them.
        """
        self._console = console
        self._screen = Screen(console)
        self._world = world
        self._factor = factor
        self._wall = wall
        self._fleet = fleet or "fleet"
        self._width = 0 if len(vehicles) == 1 else max(map(len, vehicles), default=0)
        """Columns of the vehicles' names; 0 where there is one, which needs none."""
        self._watched: dict[str, Watched] = {}
        self._sketch = Sketch()
        self._states: deque[_Told] = deque(maxlen=MAX_LINES)
        self._notes: deque[_Told] = deque(maxlen=MAX_LINES)
        self._told = 0
        self._began = 0.0, 0.0
        """Wall time and the vehicles' time at which the flight began."""
        self._next = 0.0
        """Wall time of the next picture."""
        self._captured = [_Captured(stream, self.note) for stream in (sys.stdout, sys.stderr)]
        self._capturing = ExitStack()

    def __enter__(self) -> LiveView:
        out, err = self._captured
        self._capturing.enter_context(redirect_stdout(out))
        self._capturing.enter_context(redirect_stderr(err))
        return self

    def __exit__(self, *exc: object) -> None:
        """Show how it ended, on the terminal as it was before."""
        self._capturing.close()
        self._screen.close()
        for captured in self._captured:
            captured.release()
        if self._watched:
            columns, rows = self._screen.size()
            self._console.size = (columns, rows)
            self._console.print(self.picture(columns, max(1, rows - BELOW)), end="")

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        """Show a period (see :class:`runner.loop.Watcher`)."""
        now = self._wall()
        watched = self._watched.get(pilot.vehicle.name) or self._begin(pilot, now)
        seen = pilot.channel.world
        watched.left_ground = watched.left_ground or seen.flying
        if seen.time >= watched.sampled + SAMPLE:
            watched.sampled = seen.time
            self._sketch.go(pilot.vehicle.name, _on_map(pilot, seen.position))
        if records or seen.events:
            self._tell(watched, records)
        if now >= self._next and not pilot.finished:
            self._screen.paint(self.picture(*self._screen.size()))
            done = self._wall()
            self._next = max(now + REFRESH, done + (done - now) / SHARE)

    def _begin(self, pilot: Pilot, now: float) -> Watched:
        """Begin to watch a vehicle; with the first one, set up the map."""
        if not self._watched:
            self._began = now, pilot.channel.now
            # A flight that is over before needs no screen of its own.
            self._next = now + REFRESH
            self._set_up(pilot)
        watched = self._watched[pilot.vehicle.name] = Watched(pilot)
        if self._width and pilot.vehicle.color is not None:
            watched.style = "bold #{:02x}{:02x}{:02x}".format(*legible(pilot.vehicle.color))
        self._sketch.include(_home(pilot))
        return watched

    def _set_up(self, pilot: Pilot) -> None:
        """Put on the map what is there before anything flies."""
        home = _home(pilot)
        for place in _places(pilot).values():
            if dist(place, home) < FAR:
                self._sketch.include(place)
        for road in self._world.roads if self._world else ():
            self._sketch.line(road.points)
        for thing in self._world.things if self._world else ():
            for outline in outlines_of(thing):
                if thing.motion is None:
                    self._sketch.line([*outline, outline[0]])
                if all(dist(corner, home) < NEAR for corner in outline):
                    for corner in outline:
                        self._sketch.include(corner)

    def _tell(self, watched: Watched, records: Sequence[Record]) -> None:
        for line in watched.narrator.tell(watched.pilot, records):
            watched.last = line.state or watched.last
            if line.kind == "collision":
                here = _on_map(watched.pilot, watched.pilot.channel.world.position)
                watched.collisions.append(here)
            if self._width:
                line = line._replace(
                    text=f"{watched.pilot.vehicle.name:{self._width}}  {line.text}"
                )
            self._keep(clock(watched.pilot.channel.now), line)

    def _keep(self, time: str, line: Line) -> None:
        self._told += 1
        lines = self._states if line.kind == "state" else self._notes
        lines.append(_Told(self._told, time, line))

    def note(self, text: str) -> None:
        """Show a line among the notes."""
        self._keep("", Line("note", text))

    # -- the picture ----------------------------------------------------------------------------

    def picture(self, columns: int, rows: int) -> Picture:
        """This moment in so many rows, each at most ``columns`` wide."""
        watched = list(self._watched.values())
        first = watched[0]
        if self._width:
            head = _flowed(self._figures_of_all(), columns)
        else:
            head = [*_flowed(self._figures(first.pilot), columns), where(first, columns)]
        # Afterwards the way to the end is of more interest than the states.
        share = 3 if all(each.pilot.outcome for each in watched) else 5
        told = max(3, min(10, (rows - len(head)) // share))
        rule = [Text("─" * columns, "dim")] if rows >= RULED else []
        body = rows - len(head) - len(rule) - told
        draw = self._beside if columns >= TWO_COLUMNS else self._below
        lines = [*head, *(draw(first, columns, body) if body > 0 else ()), *rule]
        lines += self._last(columns, told)
        for line in lines:
            line.truncate(columns, overflow="ellipsis")
        return Picture(lines[:rows])

    def _beside(self, first: Watched, columns: int, rows: int) -> list[Text]:
        """The states, and the map on their right."""
        left = min(60, columns * 2 // 5)
        tree = _filled(self._states_of(first, left, rows), rows)
        for line in tree:
            line.truncate(left, pad=True)
        map_ = self._map(first.pilot, columns - left - 2, rows)
        return [Text.assemble(a, "  ", b) for a, b in zip(tree, map_, strict=True)]

    def _below(self, first: Watched, columns: int, rows: int) -> list[Text]:
        """The states, and the map below them where there is room."""
        half = rows if rows < 2 * MIN_MAP else rows - max(MIN_MAP, rows // 2)
        tree = self._states_of(first, columns, half)
        rest = rows - len(tree)
        if rest < MIN_MAP:
            return _filled(tree, rows)
        return tree + self._map(first.pilot, columns, rest)

    def _states_of(self, first: Watched, columns: int, rows: int) -> list[Text]:
        """The tree of one vehicle's states, or a row for each of several vehicles."""
        if self._width:
            return vehicle_rows(list(self._watched.values()), self._width, columns, rows)
        return draw_tree(first.pilot.instance, first.last, columns, rows)

    def _map(self, pilot: Pilot, columns: int, rows: int) -> list[Text]:
        time = pilot.channel.world.time
        moving = [
            [*outline, outline[0]]
            for thing in (self._world.things if self._world else ())
            if thing.motion is not None
            for outline in outlines_of(thing, time)
        ]
        return self._sketch.draw(columns, rows, list(self._marks(pilot)), moving)

    def _marks(self, first: Pilot) -> Iterator[Mark]:
        for name, place in _places(first).items():
            yield Mark(place, "◦", "yellow", name)
        for name, watched in self._watched.items():
            yield Mark(_home(watched.pilot), "H", "bold green")
            for place in watched.collisions:
                yield Mark(place, "x", "bold red")
            seen = watched.pilot.channel.world
            arrow = _ARROWS[round(seen.yaw / (pi / 4)) % 8]
            label = name if self._width else ""
            yield Mark(_on_map(watched.pilot, seen.position), arrow, watched.style, label)

    def _last(self, columns: int, rows: int) -> list[Text]:
        """What happened last: states entered have at least half of the rows, if they need them."""
        states, notes = list(self._states), list(self._notes)
        chosen: list[tuple[int, list[Text]]] = []
        room = rows
        for lines, reserved in ((states, rows // 2), (notes, 0), (states, 0)):
            while lines and room > reserved:
                told = lines.pop()
                chosen.append((told.number, self._told_in(told, columns)))
                room -= len(chosen[-1][1])
        shown = [row for _, row_list in sorted(chosen, key=itemgetter(0)) for row in row_list]
        return _filled(shown[-rows:], rows)

    def _told_in(self, told: _Told, columns: int) -> list[Text]:
        """A line in rows of so many columns, three at most."""
        line = told.line
        text = one_line(line.text)
        if line.state:
            text = text.replace(line.state, end_of(line.state, max(8, columns // 2)), 1)
        style = "red" if line.kind == "collision" else ""
        wrapped = Text(text, style).wrap(self._console, max(10, columns - CLOCK))[:3]
        times = [told.time, *[""] * (len(wrapped) - 1)]
        return [
            Text.assemble((f"{time:>{CLOCK - 2}}  ", style or "dim"), row)
            for time, row in zip(times, wrapped, strict=True)
        ]

    def _figures(self, pilot: Pilot) -> Iterator[Text]:
        seen = pilot.channel.observation
        yield Text.assemble((f" {pilot.instance.graph.name} ", "bold reverse"))
        yield Text(clock(seen.time))
        if seen.authority != "mission":
            yield Text.assemble((f"commanded by: {seen.authority}", "bold red"))
        if seen.link != "alive":
            yield Text.assemble((f"link {seen.link}", "bold red"))
        yield Text(f"altitude {height_of(pilot):>6}")
        yield Text(f"speed {seen.velocity.norm():4.1f} m/s")
        yield Text.assemble("battery ", (f"{seen.battery:4.0%}", battery_style(seen.battery)))
        yield Text(self._pace(seen.time))

    def _figures_of_all(self) -> Iterator[Text]:
        seen = [each.pilot.channel.world for each in self._watched.values()]
        now = max(each.time for each in seen)
        yield Text.assemble((f" {self._fleet} ", "bold reverse"))
        yield Text(clock(now))
        yield Text(f"in the air {sum(each.flying for each in seen)} of {len(seen)}")
        yield Text(self._pace(now))

    def _pace(self, now: float) -> str:
        wall, began = self._began
        passed = self._wall() - wall
        pace = (now - began) / passed if passed > 0.5 else self._factor
        return f"{pace:.3g} × real time" if pace else "as fast as it can"


def _flowed(cells: Iterable[Text], columns: int) -> list[Text]:
    """Cells in rows, as many in each as there is room for."""
    rows: list[Text] = []
    for cell in cells:
        if rows and rows[-1].cell_len + 2 + cell.cell_len <= columns:
            rows[-1].append("  ").append(cell)
        else:
            rows.append(cell)
    return rows


def _filled(lines: list[Text], rows: int) -> list[Text]:
    """These lines with empty ones behind them."""
    return lines + [Text() for _ in range(rows - len(lines))]


def _on_map(pilot: Pilot, place: Point) -> XY:
    """A place of the present world frame in that of the beginning."""
    x, y, _ = place.minus(pilot.channel.frame.origin_shift)
    return x, y


def _home(pilot: Pilot) -> XY:
    return _on_map(pilot, pilot.channel.frame.origin)


def _places(pilot: Pilot) -> dict[str, XY]:
    return {name: _on_map(pilot, place) for name, place in pilot.channel.frame.places.items()}


class _Captured(TextIOBase):
    """Keeps what a person's own code prints until the screen, where it would be lost, is closed."""

    def __init__(self, stream: TextIO, note: Callable[[str], None]) -> None:
        """``note`` is called with each line."""
        self._stream = stream
        self._note = note
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._rest = ""

    def write(self, text: str) -> int:
        *lines, self._rest = (self._rest + text).split("\n")
        for line in lines:
            self._lines.append(line)
            self._note(line)
        return len(text)

    def writable(self) -> bool:
        return True

    def release(self) -> None:
        """Print it."""
        if self._rest:
            self.write("\n")
        for line in self._lines:
            print(line, file=self._stream)
