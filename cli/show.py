"""drone-cli show: a mission's graph as text, as a picture, or in another program's language."""

from __future__ import annotations

import importlib
from pathlib import Path

import click

from cli.options import MissionName, Word, WorldName, call_limit_option
from cli.output import write_file
from cli.user_code import user_code
from fsm import Graph
from runner import missions
from runner.fleets import PreparedFleet, prepare_any
from runner.preparation import Prepared
from vencejo.errors import UserError, Where, nearest

WRITERS = {
    "text": "fsm.drawing:write_text",
    "mermaid": "fsm.drawing:write_mermaid",
    "dot": "fsm.drawing:write_dot",
    "svg": "fsm.drawing:write_svg",
    "scxml": "fsm.scxml:write_scxml",
}


@click.command()
@click.argument("mission", type=MissionName())
@click.option(
    "--format",
    "format_",
    type=Word(list(WRITERS)),
    default="text",
    show_default=True,
    help="How to show it.",
)
@click.option(
    "--world", type=WorldName(), metavar="NAME|FILE", help="Check it against another world."
)
@click.option("--vehicle", metavar="NAME", help="Of a fleet, show the mission of this vehicle.")
@call_limit_option
@click.option("-o", "--output", metavar="FILE", help="Write to a file instead of the terminal.")
def show(
    mission: str,
    format_: str,
    world: str | None,
    vehicle: str | None,
    call_limit: float | None,
    output: str | None,
) -> None:
    """Show the graph of MISSION: a file, or a name as for `run`.

    text is an indented outline; svg a picture; mermaid and dot are for Mermaid and
    Graphviz; scxml is for other statechart tools. Of a fleet the outline shows the missions of all
    vehicles, everything else that of one.
    """
    with user_code(call_limit) as limit:
        prepared = prepare_any(missions.find(mission), world, calls=limit.calls)
    if isinstance(prepared, Prepared):
        if vehicle is not None:
            raise click.UsageError("--vehicle names one of a fleet, and this is a mission")
        text = _written(prepared.graph, format_)
    else:
        text = _of_fleet(prepared, vehicle, format_)
    if output is None:
        click.echo(text, nl=False)
    else:
        write_file(Path(output), text.encode())


def _of_fleet(fleet: PreparedFleet, vehicle: str | None, format_: str) -> str:
    fleet.require()
    graphs = {n: each.prepared.graph for n, each in fleet.assignments.items() if not each.stands}
    if vehicle is not None:
        if vehicle not in graphs:
            message = f"no vehicle of this fleet with a mission is called '{vehicle}'"
            hint = nearest(vehicle, graphs)
            raise UserError("unknown-vehicle", message, Where("--vehicle"), hint)
        return _written(graphs[vehicle], format_)
    if format_ != "text":
        message = f"a fleet has several missions, and {format_} shows one"
        hint = f"name a vehicle: --vehicle {next(iter(graphs))}"
        raise UserError("no-vehicle", message, hint=hint)
    return "\n".join(f"{name}\n{_written(graph, 'text')}" for name, graph in graphs.items())


def _written(graph: Graph, format_: str) -> str:
    module, _, name = WRITERS[format_].partition(":")
    write = getattr(importlib.import_module(module), name)
    if format_ == "scxml" and graph.source is None:
        raise UserError("is-scxml", "this is a document in SCXML already")
    # SCXML is written from what a person wrote, the rest from the graph it became.
    written: str = write(graph.source if format_ == "scxml" else graph)
    return written
