"""drone-cli check: find every mistake in missions without flying them."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

import click

from behaviors import Calls
from cli.fixes import fix_of
from cli.options import MissionName, WorldName, call_limit_option
from cli.output import echo_json
from cli.user_code import user_code
from fsm import Graph
from fsm.language.reader import FLEET
from hal import backend_capabilities
from runner import missions
from runner.preparation import check_fleet_file, prepare
from vencejo.errors import Fault, UserError


@dataclass(frozen=True)
class Report:
    """The faults of one mission, or of one fleet."""

    mission: str
    faults: tuple[Fault, ...]
    graphs: tuple[Graph, ...] = ()
    """The graph of a mission without errors; the graphs of a fleet's missions that have none."""
    fleet: bool = False

    @property
    def states(self) -> int:
        return sum(len(graph.nodes) - 1 for graph in self.graphs)

    def of(self, severity: str) -> list[Fault]:
        return [fault for fault in self.faults if fault.severity == severity]

    def wrong(self, strict: bool) -> bool:
        return bool(self.faults if strict else self.of("error"))

    def counts(self) -> str:
        """``2 errors, 1 warning``; empty when there are none."""
        numbers = {word: len(self.of(word)) for word in ("error", "warning")}
        return ", ".join(f"{n} {word}{'s'[: n > 1]}" for word, n in numbers.items() if n)


@click.command()
@click.argument("missions_", metavar="MISSION...", nargs=-1, required=True, type=MissionName())
@click.option("--world", type=WorldName(), metavar="NAME|FILE", help="Check against another world.")
@click.option("--backend", metavar="NAME", help="Check that this backend can do what is needed.")
@click.option("--strict", is_flag=True, help="Count warnings as errors.")
@click.option("--no-code", is_flag=True, help="Do not run the Python files that missions use.")
@call_limit_option
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def check(
    missions_: tuple[str, ...],
    world: str | None,
    backend: str | None,
    strict: bool,
    no_code: bool,
    call_limit: float | None,
    as_json: bool,
) -> None:
    """Check MISSIONs: files, or names as for `run`.

    All mistakes of a file are reported at once, with file:line:column and a hint, the errors
    before the warnings; under GitHub Actions as annotations too. With --no-code a mission's own
    behaviours are taken on trust. Exit code: 0 all may fly, 2 at least one may not.
    """
    with _no_garbage(), user_code(call_limit) as limit:
        reports = [_report(mission, world, not no_code, limit.calls) for mission in missions_]
    if backend is not None:
        offered = backend_capabilities(backend)
        reports = [_compared(report, backend, offered) for report in reports]
    if as_json:
        echo_json([_shown(report) for report in reports])
    else:
        for report in reports:
            _print(report, strict)
    sys.exit(2 if any(report.wrong(strict) for report in reports) else 0)


@contextmanager
def _no_garbage() -> Iterator[None]:
    """Look for no garbage meanwhile: a graph stays, and going through a large one again and again
    would be a third of a check's time.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _report(mission: str, world: str | None, code: bool, calls: Calls) -> Report:
    try:
        graph = prepare(missions.find(mission), world, code=code, calls=calls).graph
    except UserError as error:
        if error.code != FLEET:
            return Report(mission, error.faults)
    else:
        return Report(mission, graph.warnings, (graph,))
    try:
        faults, graphs = check_fleet_file(missions.find(mission), world, code=code, calls=calls)
    except UserError as error:
        return Report(mission, error.faults)
    return Report(mission, tuple(faults), tuple(graphs), fleet=True)


def _compared(report: Report, backend: str, offered: frozenset[str]) -> Report:
    """The report, with a fault for each capability that the backend lacks."""
    missing = [fault for graph in report.graphs for fault in _missing(graph, backend, offered)]
    return replace(report, faults=(*missing, *report.faults))


def _missing(graph: Graph, backend: str, offered: frozenset[str]) -> list[Fault]:
    """Faults for the capabilities that behaviours need and a backend does not offer."""
    return [
        Fault(
            "missing-capability",
            f"'{node.invocation.behavior.name if node.invocation else node.path}' needs "
            f"'{capability}', which the backend '{backend}' does not offer",
            node.where,
            f"it offers: {', '.join(sorted(offered))}",
        )
        for capability, node in graph.required().items()
        if capability not in offered
    ]


def _shown(report: Report) -> dict[str, Any]:
    found: dict[str, Any] = {"mission": report.mission}
    if report.graphs or report.fleet:
        found["states"] = report.states
    if report.fleet:
        found["fleet"] = True
    faults = [_told(fault) for fault in report.faults]
    errors, warnings = len(report.of("error")), len(report.of("warning"))
    return {**found, "errors": errors, "warnings": warnings, "faults": faults}


def _told(fault: Fault) -> dict[str, Any]:
    fix = fix_of(fault)
    where = str(fault.where) if fault.where else None
    return {**asdict(fault), "where": where, "fix": asdict(fix) if fix else None}


def _print(report: Report, strict: bool) -> None:
    for severity in ("error", "warning"):
        for fault in report.of(severity):
            click.echo(str(fault), err=True)
            if os.environ.get("GITHUB_ACTIONS") == "true":
                click.echo(annotation(fault, "error" if strict else severity))
    counts = report.counts()
    if report.wrong(strict):
        click.echo(f"{report.mission}: {counts}", err=True)
    else:
        what = "a fleet without mistakes" if report.fleet else "may fly"
        states = f"{report.states} state{'s'[: report.states != 1]}"
        click.echo(f"{report.mission}: {what}, {states}{counts and f', {counts}'}")


def annotation(fault: Fault, severity: str) -> str:
    """A fault as a workflow command of GitHub Actions, which shows it beside the line."""
    where = fault.where
    fields = {"title": fault.code}
    if where is not None:
        fields = {"file": where.file, **fields}
    if where is not None and where.line:
        fields |= {"line": str(where.line), "col": str(where.column)}
    shown = ",".join(
        f"{name}={_escaped(value).replace(':', '%3A').replace(',', '%2C')}"
        for name, value in fields.items()
    )
    hint = f"\nhint: {fault.hint}" if fault.hint else ""
    return f"::{severity} {shown}::{_escaped(fault.message + hint)}"


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
