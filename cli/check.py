"""drone-cli check: find every mistake in missions without flying them."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import Any

import click

from cli import missions
from cli.fleet import faults_of_fleet
from cli.options import MissionName
from cli.prepare import prepare
from fsm.reader import FLEET
from vencejo.errors import Fault, UserError


@click.command()
@click.argument("missions_", metavar="MISSION...", nargs=-1, required=True, type=MissionName())
@click.option("--world", metavar="NAME|FILE", help="Check against another world.")
@click.option("--strict", is_flag=True, help="Count warnings as errors.")
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def check(missions_: tuple[str, ...], world: str | None, strict: bool, as_json: bool) -> None:
    """Check MISSIONs: files, or names as for `run`.

    All mistakes of a file are reported at once, with file:line:column and a hint. Exit code: 0
    all may fly, 2 at least one may not.
    """
    reports = [_report(mission, world) for mission in missions_]
    wrong = [
        report
        for report in reports
        if any(fault.severity == "error" or strict for fault in report["faults"])
    ]
    if as_json:
        shown = [{**r, "faults": [_shown(f) for f in r["faults"]]} for r in reports]
        click.echo(json.dumps(shown, ensure_ascii=False))
    else:
        for report in reports:
            _print(report, report in wrong)
    sys.exit(2 if wrong else 0)


def _report(mission: str, world: str | None) -> dict[str, Any]:
    try:
        prepared = prepare(missions.find(mission), world)
    except UserError as error:
        if error.code == FLEET:
            return _fleet(mission, world)
        return {"mission": mission, "faults": list(error.faults)}
    graph = prepared.graph
    return {"mission": mission, "states": len(graph.nodes) - 1, "faults": list(graph.warnings)}


def _fleet(mission: str, world: str | None) -> dict[str, Any]:
    try:
        faults, states = faults_of_fleet(missions.find(mission), world)
    except UserError as error:
        return {"mission": mission, "faults": list(error.faults)}
    return {"mission": mission, "states": states, "fleet": True, "faults": faults}


def _shown(fault: Fault) -> dict[str, Any]:
    return {**asdict(fault), "where": str(fault.where) if fault.where else None}


def _print(report: dict[str, Any], wrong: bool) -> None:
    for fault in report["faults"]:
        click.echo(str(fault), err=True)
    if wrong:
        click.echo(f"{report['mission']}: {len(report['faults'])} to mend", err=True)
    else:
        what = "a fleet without mistakes" if "fleet" in report else "may fly"
        click.echo(f"{report['mission']}: {what}, {report['states']} states")
