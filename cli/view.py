"""A flight in plain lines, and its summary, for people."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import click

from behaviors import Pilot
from cli.narrator import Line, Narrator, behavior_of, clock, height_of
from cli.output import Output
from fsm.engine.instance import Record
from fsm.values.functions import as_text


class PlainView:
    """One line for every state entered, with its cause, and for everything noteworthy."""

    def __init__(self, out: Output, *, colored: bool = False) -> None:
        self._out = out
        self._colored = colored
        self._narrators: defaultdict[str, Narrator] = defaultdict(Narrator)

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        """Show a period (see :class:`runner.loop.Watcher`)."""
        for line in self._narrators[pilot.vehicle.name].tell(pilot, records):
            text = f"{clock(pilot.channel.now):>8}  {_told(line, pilot)}"
            if line.kind == "collision" and self._colored:
                text = click.style(text, fg="red")
            print(text, file=self._out, flush=True)


def _told(line: Line, pilot: Pilot) -> str:
    if line.kind != "state":
        return f"  {line.text}"
    behavior = behavior_of(pilot.instance.graph, line.state)
    battery = f"battery {pilot.channel.observation.battery:.0%}"
    figures = [behavior, f"altitude {height_of(pilot)}", battery]
    return f"{line.text}  {', '.join(filter(None, figures))}"


def show_summary(summary: Mapping[str, Any], *, colored: bool = False) -> None:
    """Print the end of a run for a person; the run folder comes last."""
    good = "✘" if not summary["success"] else "✔" if summary["left_ground"] else "–"
    stayed = "" if summary["left_ground"] else ", never left the ground"
    reason = f" — {summary['reason']}" if summary["reason"] else ""
    lines = [
        f"{good} {summary['mission']} ended in '{summary['outcome']}'{stayed}{reason}",
        f"  {summary['mission_time_s']:.1f} s flown in {_rounded(summary['wall_time_s'])} s"
        f" ({_rounded(summary['realtime_factor'])} × real time), {summary['distance_m']:.1f} m,"
        f" up to {summary['max_altitude_m']:.1f} m, battery {summary['battery_left']:.0%}",
    ]
    if summary["collisions"]:
        collided = f"  collided with {_counted(summary['collisions'])}"
        lines.append(click.style(collided, fg="red") if colored else collided)
    if summary["output"]:
        lines.append(f"  output: {as_text(summary['output'])}")
    if summary["run_folder"]:
        lines.append(f"run folder: {summary['run_folder']}")
    click.echo("\n".join(lines), color=colored)


def _rounded(number: float) -> str:
    """A number to two figures or to whole ones: 0.066, 9.5, 289."""
    return f"{number:.0f}" if number >= 10 else f"{number:.2g}"


def _counted(collisions: Mapping[str, int]) -> str:
    """Things with the number of collisions: ``wall, crate (2 times)``."""
    return ", ".join(
        thing if count == 1 else f"{thing} ({count} times)" for thing, count in collisions.items()
    )
