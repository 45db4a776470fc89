"""drone-cli show: a mission's graph as text, as a picture, or in another program's language."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from pathlib import Path

import click
from click.core import ParameterSource

from behaviors import Calls
from cli.options import (
    MissionName,
    Word,
    WorldName,
    assignments,
    call_limit_option,
    complete_parameter,
)
from cli.output import write_file
from cli.user_code import user_code
from fsm import Graph, parse_parameters
from runner import missions
from runner.by_vehicle import ALONE
from runner.fleets import PreparedFleet, plans_of, prepare_any, with_parameters
from runner.geometry import Terms
from runner.plan import Assignment
from runner.preparation import Prepared
from runner.vehicle_models import flight_of, models_of
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
@click.option(
    "--plan",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Draw where it may fly, over its world from above, into FILE.png instead.",
)
@click.option(
    "-p",
    "--parameter",
    "parameters",
    multiple=True,
    callback=assignments,
    shell_complete=complete_parameter,
    metavar="NAME=VALUE",
    help="A parameter of the mission for --plan, as for `run`. Repeatable.",
)
@call_limit_option
@click.option("-o", "--output", metavar="FILE", help="Write to a file instead of the terminal.")
def show(
    mission: str,
    format_: str,
    world: str | None,
    vehicle: str | None,
    plan: Path | None,
    parameters: dict[str, str],
    call_limit: float | None,
    output: str | None,
) -> None:
    """Show the graph of MISSION: a file, or a name as for `run`.

    text is an indented outline; svg a picture; mermaid and dot are for Mermaid and
    Graphviz; scxml is for other statechart tools. Of a fleet the outline shows the missions of all
    vehicles, everything else that of one.

    --plan draws every leg, point, route and area that is known before the flight, and names what is
    known in flight only; of a fleet those of all vehicles, or of the one that --vehicle names.
    """
    _refuse_beside_plan(plan, parameters, output)
    with user_code(call_limit) as limit:
        prepared = prepare_any(missions.find(mission), world, calls=limit.calls)
        picture = _drawn(prepared, vehicle, parameters, limit.calls) if plan else b""
    if plan is not None:
        write_file(plan, picture)
        click.echo(plan)
        return
    if isinstance(prepared, Prepared):
        _refuse_vehicle(vehicle)
        text = _written(prepared.graph, format_)
    else:
        text = _of_fleet(prepared, vehicle, format_)
    if output is None:
        click.echo(text, nl=False)
    else:
        write_file(Path(output), text.encode())


def _refuse_beside_plan(
    plan: Path | None, parameters: Mapping[str, str], output: str | None
) -> None:
    if plan is None:
        if parameters:
            raise click.UsageError("-p is for where a mission flies: --plan FILE.png")
        return
    if (
        output is not None
        or click.get_current_context().get_parameter_source("format_")
        is not ParameterSource.DEFAULT
    ):
        raise click.UsageError("--plan draws a picture of its own: leave out --format and -o")
    if plan.suffix.lower() != ".png":
        hint = f"--plan {plan.with_suffix('.png')}"
        raise UserError("bad-usage", f"'{plan}' does not end in .png", hint=hint)


def _drawn(
    prepared: Prepared | PreparedFleet,
    vehicle: str | None,
    parameters: Mapping[str, str],
    calls: Calls,
) -> bytes:
    """The picture of where a mission or a fleet may fly, as PNG. Raises UserError."""
    from cli.plot.plan import Planned, draw_plan

    if isinstance(prepared, Prepared):
        _refuse_vehicle(vehicle)
        values = parse_parameters(prepared.graph, parameters)
        flown: Mapping[str, Assignment] = {ALONE: Assignment(prepared, values)}
        name, world = prepared.graph.name, prepared.world
    else:
        prepared.require()
        flown = with_parameters(prepared.assignments, parameters)
        chosen = _graphs(prepared, vehicle)
        flown = {member: each for member, each in flown.items() if member in chosen}
        name, world = prepared.spec.name, next(iter(flown.values())).prepared.world
    models = models_of("sim", flown)
    terms = {member: Terms(flight_of("sim", model)) for member, model in models.items()}
    plans = plans_of(flown, terms, calls)
    faults = [fault for each in plans.values() for fault in each.paths.faults]
    errors = [fault for fault in faults if fault.severity == "error"]
    if errors:
        raise UserError.of(dict.fromkeys(errors))
    for fault in dict.fromkeys(faults):
        click.echo(str(fault), err=True)
    alone = isinstance(prepared, Prepared)
    vehicles = [
        Planned("" if alone else member, flown[member].prepared.graph, each, flown[member].color)
        for member, each in plans.items()
    ]
    return draw_plan(f"{name} in {world.name}", world, vehicles)


def _refuse_vehicle(vehicle: str | None) -> None:
    if vehicle is not None:
        raise click.UsageError("--vehicle names one of a fleet, and this is a mission")


def _graphs(fleet: PreparedFleet, vehicle: str | None) -> dict[str, Graph]:
    """The missions of a fleet by vehicle, or that of one. Raises UserError for none of these."""
    graphs = {n: each.prepared.graph for n, each in fleet.assignments.items() if not each.stands}
    if vehicle is None:
        return graphs
    if vehicle not in graphs:
        message = f"no vehicle of this fleet with a mission is called '{vehicle}'"
        raise UserError("unknown-vehicle", message, Where("--vehicle"), nearest(vehicle, graphs))
    return {vehicle: graphs[vehicle]}


def _of_fleet(fleet: PreparedFleet, vehicle: str | None, format_: str) -> str:
    fleet.require()
    graphs = _graphs(fleet, vehicle)
    if vehicle is not None:
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
