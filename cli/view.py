"""A flight in plain lines, and its summary, for people."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import click

from behaviors import Pilot
from cli.narrator import Line, Narrator, behavior_of, clock, height_of
from cli.output import Output
from fsm.engine.instance import Record
from fsm.values.functions import as_text
from runner.by_vehicle import ALONE


class PlainView:
    """One line for every state entered, with its cause, and for everything noteworthy."""

    def __init__(
        self, out: Output, vehicles: Sequence[str] = (ALONE,), *, colored: bool = False
    ) -> None:
        """``vehicles``: the names of all; of several each line has that of its own."""
        self._out = out
        self._colored = colored
        width = max(map(len, vehicles), default=0)
        alone = len(vehicles) == 1
        self._names = {name: "" if alone else f"{name:{width}}  " for name in vehicles}
        self._narrators: defaultdict[str, Narrator] = defaultdict(Narrator)

    def note(self, text: str) -> None:
        """Show a line among the notes."""
        print(f"{'':>8}    {text}", file=self._out, flush=True)

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        """Show a period (see :class:`runner.loop.Watcher`)."""
        for line in self._narrators[pilot.vehicle.name].tell(pilot, records):
            name = self._names[pilot.vehicle.name]
            text = f"{clock(pilot.channel.now):>8}  {name}{_told(line, pilot)}"
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


def show_summary(
    summary: Mapping[str, Any], files: Iterable[str] = (), *, colored: bool = False
) -> None:
    """Print the end of a run for a person; its ``files`` and the run folder come last."""
    pace = (
        f"{summary['mission_time_s']:.1f} s flown in {_rounded(summary['wall_time_s'])} s"
        f" ({_rounded(summary['realtime_factor'])} × real time)"
    )
    if "vehicles" in summary:
        until = summary["settings"].get("until", "") if summary.get("ended_by_until") else ""
        lines = _of_fleet(summary, pace, until)
        for name, flown in summary["vehicles"].items():
            lines += _of_vehicle(flown, name, until, colored)
    else:
        sign, end = _end(summary, success=summary["success"])
        lines = [f"{sign} {summary['mission']} {end}", f"  {pace}, {_figures(summary)}"]
        lines += _details(summary, colored)
    lines += files
    if summary["run_folder"]:
        lines.append(f"run folder: {summary['run_folder']}")
    click.echo("\n".join(lines), color=colored)


def _of_fleet(summary: Mapping[str, Any], pace: str, until: str) -> list[str]:
    """The lines on all vehicles together; ``until``: the condition that ended their flight."""
    name = summary.get("fleet") or "the vehicles"
    ended = f"ended: until {until}" if until else "ended"
    lines = [f"{'✔' if summary['success'] else '✘'} {name} {ended}", f"  {pace}"]
    nearest = min(summary.get("separation", ()), key=_distance, default=None)
    if nearest is not None:
        pair, moment = " and ".join(nearest["vehicles"]), clock(nearest["t"])
        lines.append(f"  nearest: {pair}, {nearest['distance_m']:.2f} m at {moment}")
    if "referee" in summary:
        lines.append(_judged(summary["referee"]))
    return lines


def _judged(verdict: Mapping[str, Any]) -> str:
    """The line of the referee."""
    one, other = verdict["between"]
    near, whole, losses = verdict["time_near_s"], verdict["time_s"], verdict["losses"]
    share = f" ({near / whole:.0%})" if whole else ""
    return (
        f"  referee: {one} within {verdict['near_m']:g} m of {other} for {near:.1f} s of "
        f"{whole:.1f} s{share}, {verdict['mean_distance_m']:.2f} m on average; "
        f"lost it {losses} {'time' if losses == 1 else 'times'}"
    )


def _distance(pair: Mapping[str, Any]) -> float:
    distance: float = pair["distance_m"]
    return distance


def _of_vehicle(flown: Mapping[str, Any], name: str, until: str, colored: bool) -> list[str]:
    """The lines on one vehicle of several; why all of them have ended is not said again."""
    if flown["reason"] == f"until {until}":
        flown = {**flown, "reason": None}
    if flown["mission"] is None:
        return [f"  – {name} stood" if not flown["left_ground"] else f"  – {name}"]
    sign, end = _end(flown, success=flown["outcome"] == "done")
    lines = [f"{sign} {name} ({flown['mission']}) {end}", f"  {_figures(flown)}"]
    return [f"  {line}" for line in (*lines, *_details(flown, colored))]


def _end(flown: Mapping[str, Any], *, success: bool) -> tuple[str, str]:
    """A sign for how a vehicle's flight ended, and the end in words."""
    sign = "✘" if not success else "✔" if flown["left_ground"] else "–"
    stayed = "" if flown["left_ground"] else ", never left the ground"
    reason = f" — {flown['reason']}" if flown["reason"] else ""
    return sign, f"ended in '{flown['outcome']}'{stayed}{reason}"


def _figures(flown: Mapping[str, Any]) -> str:
    model = f", {flown['model']}" if "model" in flown else ""
    return (
        f"{flown['distance_m']:.1f} m, up to {flown['max_altitude_m']:.1f} m, "
        f"battery {flown['battery_left']:.0%}{model}"
    )


def _details(flown: Mapping[str, Any], colored: bool) -> list[str]:
    """Lines on what is not the same in every flight."""
    lines = []
    if flown["collisions"]:
        collided = f"  collided with {_counted(flown['collisions'])}"
        lines.append(click.style(collided, fg="red") if colored else collided)
    if flown["output"]:
        lines.append(f"  output: {as_text(flown['output'])}")
    return lines


def _rounded(number: float) -> str:
    """A number to two figures or to whole ones: 0.066, 9.5, 289."""
    return f"{number:.0f}" if number >= 10 else f"{number:.2g}"


def _counted(collisions: Mapping[str, int]) -> str:
    """Things with the number of collisions: ``wall, crate (2 times)``."""
    return ", ".join(
        thing if count == 1 else f"{thing} ({count} times)" for thing, count in collisions.items()
    )
