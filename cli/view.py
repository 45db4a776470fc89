"""Views of a flight: a live one on a terminal, plain lines everywhere else."""

from __future__ import annotations

import time
from collections.abc import Sequence

import click
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from behaviors import Pilot
from cli.output import Output
from cli.sketch import Sketch
from fsm import Graph, Node
from fsm.engine.instance import Record
from fsm.values.functions import as_text
from vencejo.geometry import Point

REFRESH = 0.1
"""Seconds of wall time between two pictures of the live view."""
MAX_TREE_LINES = 18


def clock(seconds: float) -> str:
    """Minutes and seconds: ``1:23.4``."""
    minutes, rest = divmod(seconds, 60)
    return f"{int(minutes)}:{rest:04.1f}"


def note(kind: str, fields: dict[str, object]) -> str | None:
    """A record as one line for a person, or None when it is not worth one."""
    match kind:
        case "log":
            return str(fields["text"])
        case "error":
            return f"error: {fields['message']} ({fields['where']})"
        case "reaction":
            return f"nobody handles {fields['event']}: landing"
        case "landing":
            return "landing past the mission"
        case "event" if fields["name"] == "failed":
            failed = fields.get("fields")
            reason = failed.get("reason") if isinstance(failed, dict) else ""
            return f"{fields['state']} failed: {reason}"
        case _:
            return None


class PlainView:
    """One line for every state entered and everything noteworthy."""

    def __init__(self, out: Output) -> None:
        self._out = out

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        seen = pilot.channel.observation
        leaves = set(pilot.instance.paths())
        for kind, fields in records:
            if kind == "enter" and fields["state"] in leaves:
                doing = ""
                node = pilot.instance.graph.by_path[fields["state"]]
                if node.invocation:
                    doing = f"  ({node.invocation.behavior.name})"
                self._say(seen.time, f"→ {fields['state']}{doing}  {_figures(pilot)}")
            text = note(kind, fields)
            if text:
                self._say(seen.time, f"  {text}")

    def _say(self, time_: float, text: str) -> None:
        print(f"{clock(time_):>8}  {text}", file=self._out, flush=True)


def _height(pilot: Pilot) -> str:
    # Adding zero turns the -0.0 of a vehicle at rest into 0.0.
    return f"{round(pilot.channel.observation.position.z, 1) + 0.0:.1f} m"


def _figures(pilot: Pilot) -> str:
    seen = pilot.channel.observation
    return f"altitude {_height(pilot)}, battery {seen.battery:.0%}"


class LiveView:
    """The state tree, figures and a map, redrawn in place; use it in a ``with``."""

    def __init__(self, graph: Graph, console: Console, factor: float | None) -> None:
        self._graph = graph
        self._factor = factor
        self._sketch = Sketch(columns=min(44, max(20, console.width - 46)), rows=14)
        self._places: list[Point] = []
        self._notes: list[str] = []
        self._drawn = 0.0
        self._wall: float | None = None
        self._live = Live(console=console, auto_refresh=False, transient=False)

    def __enter__(self) -> LiveView:
        self._live.__enter__()
        return self

    def __exit__(self, *exc: object) -> None:
        self._live.stop()

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        if self._wall is None:
            self._wall = time.monotonic()
            frame = pilot.channel.frame
            self._places = [frame.from_world(place) for place in frame.places.values()]
            self._sketch.include((place.x, place.y) for place in self._places)
        here = pilot.channel.observation.position
        self._sketch.add((here.x, here.y))
        for kind, fields in records:
            text = note(kind, fields)
            if text:
                self._notes.append(f"{clock(pilot.channel.now)}  {text}")
        now = time.monotonic()
        if now - self._drawn >= REFRESH or pilot.finished:
            self._drawn = now
            self._live.update(self.picture(pilot, now - self._wall), refresh=True)

    def picture(self, pilot: Pilot, wall: float) -> RenderableType:
        """The view of this moment, ``wall`` seconds after the first."""
        seen = pilot.channel.observation
        pace = seen.time / wall if wall > 0.5 else self._factor
        head = Text.assemble(
            (f" {self._graph.name} ", "bold reverse"),
            f"  {clock(seen.time)}   altitude {_height(pilot):>7}   battery ",
            (f"{seen.battery:4.0%}", _battery_style(seen.battery)),
            f"   {f'{pace:.3g} × real time' if pace else 'as fast as it can'}",
        )
        body = Table.grid(expand=False, padding=(0, 1))
        body.add_column(width=38)
        body.add_column()
        tree = Group(*self._tree(pilot))
        marks = {
            "·": [(p.x, p.y) for p in self._places],
            "H": [(0.0, 0.0)],
            "✈": [(seen.position.x, seen.position.y)],
        }
        map_ = Panel(
            Text("\n".join(self._sketch.draw(marks))), title="from above, north up", padding=0
        )
        body.add_row(tree, map_)
        notes = [Text(line, overflow="ellipsis", no_wrap=True) for line in self._notes[-3:]]
        return Group(head, body, *notes)

    def _tree(self, pilot: Pilot) -> list[Text]:
        """The states with the active path; where there are many, those around it."""
        active = {node.index for node in pilot.instance.active}
        lines = []
        for node in self._graph.nodes[1:]:
            beside = node.parent is not None and node.parent.index in active
            if node.type != "history" and (len(self._graph.nodes) <= MAX_TREE_LINES or beside):
                lines.append(_branch(node, node.index in active))
        return lines[:MAX_TREE_LINES]


def _branch(node: Node, active: bool) -> Text:
    indent = "  " * (len(node.ancestors) - 1)
    doing = f"  {node.invocation.behavior.name}" if node.invocation else ""
    if doing.strip() == node.local_name:
        doing = ""
    mark, style = ("▶", "bold green") if active else ("·", "dim")
    return Text.assemble((f"{indent}{mark} {node.local_name}", style), (doing, "dim italic"))


def _battery_style(level: float) -> str:
    return "green" if level > 0.3 else "yellow" if level > 0.15 else "bold red"


def show_summary(summary: dict[str, object]) -> None:
    """Print the end of a run for a person; the run folder comes last."""
    good = "✘" if not summary["success"] else "✔" if summary["left_ground"] else "–"
    reason = f" — {summary['reason']}" if summary["reason"] else ""
    if not summary["left_ground"]:
        reason += " — but it never left the ground"
    lines = [
        f"{good} {summary['mission']} ended in '{summary['outcome']}'{reason}",
        f"  {summary['mission_time_s']} s flown in {summary['wall_time_s']} s"
        f" ({summary['realtime_factor']} × real time), {summary['distance_m']} m,"
        f" up to {summary['max_altitude_m']} m, battery {float(str(summary['battery_left'])):.0%}",
    ]
    if summary["output"]:
        lines.append(f"  output: {as_text(summary['output'])}")
    if summary["run_folder"]:
        lines.append(f"run folder: {summary['run_folder']}")
    click.echo("\n".join(lines))
