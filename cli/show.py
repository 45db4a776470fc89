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
from runner.preparation import prepare
from vencejo.errors import UserError

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
@call_limit_option
@click.option("-o", "--output", metavar="FILE", help="Write to a file instead of the terminal.")
def show(
    mission: str, format_: str, world: str | None, call_limit: float | None, output: str | None
) -> None:
    """Show the graph of MISSION: a file, or a name as for `run`.

    text is an indented outline; svg a picture; mermaid and dot are for Mermaid and
    Graphviz; scxml is for other statechart tools.
    """
    with user_code(call_limit) as limit:
        graph = prepare(missions.find(mission), world, calls=limit.calls).graph
    text = _written(graph, format_)
    if output is None:
        click.echo(text, nl=False)
    else:
        write_file(Path(output), text.encode())


def _written(graph: Graph, format_: str) -> str:
    module, _, name = WRITERS[format_].partition(":")
    write = getattr(importlib.import_module(module), name)
    if format_ == "scxml" and graph.source is None:
        raise UserError("is-scxml", "this is a document in SCXML already")
    # SCXML is written from what a person wrote, the rest from the graph it became.
    written: str = write(graph.source if format_ == "scxml" else graph)
    return written
