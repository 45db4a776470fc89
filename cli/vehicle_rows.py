"""How each vehicle of a run does, in a row of the live view."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

from rich.text import Text

from behaviors import Pilot
from cli.narrator import Narrator, height_of
from cli.sketch import XY
from cli.state_tree import time_in_state
from runner.course import one_line

MAX_COLLISIONS = 100
"""Places of collisions that are kept of a vehicle."""
_FIGURES = 23
"""Columns of altitude, speed and battery."""


@dataclass
class Watched:
    """One vehicle with what the view has noticed of it."""

    pilot: Pilot
    narrator: Narrator = field(default_factory=Narrator)
    collisions: deque[XY] = field(default_factory=lambda: deque(maxlen=MAX_COLLISIONS))
    """The places of its last collisions on the map."""
    last: str = ""
    """The state entered last."""
    left_ground: bool = False
    """Whether it was off the ground at any time."""
    style: str = "bold magenta"
    """Of its name and its arrow on the map."""
    sampled: float = -inf
    """When the last point of its path was taken."""


def vehicle_rows(vehicles: Sequence[Watched], width: int, columns: int, rows: int) -> list[Text]:
    """At most so many rows of so many columns, one for each vehicle, whose names take ``width``;
    where there are more vehicles, the last row says how many.
    """
    shown = vehicles if len(vehicles) <= rows else vehicles[: max(0, rows - 1)]
    lines = [_row(each, width, columns) for each in shown]
    if len(shown) < len(vehicles) and rows > 0:
        lines.append(Text(f"⋮ {len(vehicles) - len(shown)} more", "dim"))
    return lines


def _row(watched: Watched, width: int, columns: int) -> Text:
    """Its name, its states, and, where there is room, its figures."""
    pilot = watched.pilot
    name = Text(f"{pilot.vehicle.name:{width}}  ", watched.style)
    room = columns - width - 2 - _FIGURES
    if room < 12:
        return Text.assemble(name, where(watched, columns - width - 2))
    states = where(watched, room + 3)  # it leaves room for 1000 s; most states last less
    states.truncate(room, overflow="ellipsis", pad=True)
    seen = pilot.channel.observation
    figures = f"{height_of(pilot):>7} {seen.velocity.norm():4.1f} m/s "
    battery = (f"{seen.battery:4.0%}", battery_style(seen.battery))
    return Text.assemble(name, states, figures, battery)


def where(watched: Watched, columns: int) -> Text:
    """The active states and for how long; after the mission, how it ended."""
    pilot, instance = watched.pilot, watched.pilot.instance
    if pilot.outcome is not None:
        why = f" ({one_line(pilot.reason)})" if pilot.reason else ""
        if pilot.outcome != "done":
            sign, style = "✘", "bold red"
        elif watched.left_ground:
            sign, style = "✔", "bold green"
        else:
            sign, style = "–", "bold yellow"
            why += ", never left the ground"
        landing = "" if pilot.finished else ", landing"
        return Text(f"{sign} ended in '{pilot.outcome}'{why}{landing}", style)
    leaves = [node for node in instance.active if not node.children]
    room = columns // max(1, len(leaves)) - len("▶  1000.0 s")
    states = [
        f"{end_of(node.path, max(8, room))} {time_in_state(instance, node):.1f} s"
        for node in leaves
    ]
    halted = " (standing still)" if instance.suspended_at is not None else ""
    return Text(f"▶ {', '.join(states)}{halted}", "bold green")


def end_of(path: str, length: int) -> str:
    """A path, or where it is longer the end of it: that says most."""
    return path if len(path) <= length else f"…{path[1 - length :]}"


def battery_style(level: float) -> str:
    return "green" if level > 0.3 else "yellow" if level > 0.15 else "bold red"
