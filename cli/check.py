"""drone-cli check: find every mistake in missions without flying them."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

import click

from behaviors import Calls
from cli.fixes import fix_of
from cli.options import (
    SIMULATOR,
    Length,
    LimitSettings,
    MissionName,
    WorldName,
    call_limit_option,
    engine_option,
    limit_option,
    model_option,
    noise_option,
    physics_option,
    wind_option,
)
from cli.output import echo_json
from cli.user_code import user_code
from fsm import Graph
from hal import VehicleModel, backend_capabilities, flight_model
from runner import missions
from runner.by_vehicle import ALONE
from runner.call_limit import CallLimit
from runner.fleets import PreparedFleet, check_ways, prepare_any
from runner.geometry import CLEARANCE, Findings
from runner.plan import Assignment, Plan, with_model
from runner.trial_flights import Trial, fly_trials
from runner.vehicle_models import (
    faults_of_models,
    flight_of,
    missing_capabilities,
    models_of,
)
from vencejo.errors import Fault, UserError, Where


@dataclass(frozen=True)
class Report:
    """The faults of one mission, or of one fleet."""

    mission: str
    faults: tuple[Fault, ...]
    graphs: tuple[Graph, ...] = ()
    """The graph of a mission without errors; the graphs of a fleet's missions that have none."""
    fleet: bool = False
    plan: Plan | None = None
    """The plan to fly it, of what has no errors."""
    findings: Findings | None = None
    """What was found of where it flies."""
    trials: tuple[Trial, ...] = ()
    """Its trial flights."""

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
@model_option("Check that this model of vehicle can do what is needed.")
@limit_option("Check against limits of flight, as for `run`. Repeatable.")
@click.option(
    "--clearance",
    type=Length(),
    default=f"{CLEARANCE:g}m",
    show_default=True,
    help="Warn of legs that pass nearer than this to a thing.",
)
@click.option(
    "--fly",
    "count",
    type=click.IntRange(1, 10_000),
    metavar="N",
    help="Fly it N times in the simulator, with the seeds 0 to N-1, and tell what was measured.",
)
@engine_option
@physics_option
@noise_option("Disturb the commands of these flights, as for `run`.")
@wind_option("Let a wind blow on these flights, as for `run`.")
@click.option("--strict", is_flag=True, help="Count warnings as errors.")
@click.option("--no-code", is_flag=True, help="Do not run the Python files that missions use.")
@call_limit_option
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def check(
    missions_: tuple[str, ...],
    world: str | None,
    backend: str | None,
    model: str | None,
    limit_settings: LimitSettings,
    clearance: float,
    count: int | None,
    engine: str | None,
    physics: str,
    noise: float,
    wind: str | None,
    strict: bool,
    no_code: bool,
    call_limit: float | None,
    as_json: bool,
) -> None:
    """Check MISSIONs: files, or names as for `run`.

    All mistakes of a file are reported at once, with file:line:column and a hint, the errors
    before the warnings; under GitHub Actions as annotations too. With --no-code a mission's own
    behaviours are taken on trust. Exit code: 0 all may fly, 2 at least one may not; with --fly 1
    when all may but a flight did not end in `done`.
    """
    asked = _Asked(world, backend, model, limit_settings, clearance, not no_code)
    flight = flight_model(backend or SIMULATOR, model)
    limit_settings.terms(flight)  # refuses wrong limits before any mission is read
    with _no_garbage(), user_code(call_limit) as limit:
        reports = [_report(mission, asked, limit.calls) for mission in missions_]
    if count is not None:
        if no_code:
            raise click.UsageError("--fly runs the Python that missions use; leave --no-code out")
        own = {"engine": engine, "physics": physics, "noise": noise, "wind": wind}
        with user_code(call_limit) as limit:
            reports = [_flown(r, count, own, limit_settings, limit) for r in reports]
    if as_json:
        echo_json([_shown(report) for report in reports])
    else:
        for report in reports:
            _print(report, strict)
    if any(report.wrong(strict) for report in reports):
        sys.exit(2)
    sys.exit(int(not all(trial.success for report in reports for trial in report.trials)))


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


def _flown(
    report: Report,
    count: int,
    own: Mapping[str, object],
    limit_settings: LimitSettings,
    limit: CallLimit,
) -> Report:
    """The report with trial flights of a mission without errors."""
    if report.plan is None or report.of("error"):
        return report
    plan = replace(
        report.plan,
        settings=own,
        profile=limit_settings.profile,
        limits=limit_settings.limits,
    )
    return replace(report, trials=tuple(fly_trials(plan, range(count), limit)))


@dataclass(frozen=True)
class _Asked:
    """What missions are checked against."""

    world: str | None
    backend: str | None
    model: str | None
    limit_settings: LimitSettings
    clearance: float
    code: bool
    """Whether the Python files that missions use are run."""


def _report(mission: str, asked: _Asked, calls: Calls) -> Report:
    try:
        prepared = prepare_any(missions.find(mission), asked.world, code=asked.code, calls=calls)
    except UserError as error:
        return Report(mission, error.faults)
    if isinstance(prepared, PreparedFleet):
        return _fleet_report(mission, prepared, asked, calls)
    plan = Plan(with_model({ALONE: Assignment(prepared)}, asked.model, Where("--model")))
    try:
        findings = _looked(plan.assignments, asked, calls)
    except UserError as error:
        return Report(mission, error.faults)
    graph = prepared.graph
    told = (*graph.warnings, *findings.faults)
    return Report(mission, told, (graph,), plan=plan, findings=findings)


def _fleet_report(mission: str, fleet: PreparedFleet, asked: _Asked, calls: Calls) -> Report:
    assignments = with_model(fleet.assignments, asked.model, Where("--model"))
    try:
        findings = _looked(assignments, asked, calls)
    except UserError as error:
        return Report(mission, (*fleet.faults, *error.faults), fleet=True)
    return Report(
        mission,
        tuple(dict.fromkeys((*fleet.faults, *findings.faults))),
        tuple(each.prepared.graph for each in assignments.values() if not each.stands),
        fleet=True,
        plan=Plan(assignments, fleet=fleet.fleet) if fleet.may_fly else None,
        findings=findings,
    )


def _looked(assignments: Mapping[str, Assignment], asked: _Asked, calls: Calls) -> Findings:
    """What is found of where vehicles fly, and of what their models can do. Raises UserError."""
    backend = asked.backend or SIMULATOR
    models = models_of(backend, assignments)
    terms = {
        name: asked.limit_settings.terms(flight_of(backend, model), asked.clearance)
        for name, model in models.items()
    }
    faults = list(faults_of_models(assignments, models))
    for name, model in models.items():
        lacking = _lacking(assignments[name].prepared.graph, backend, model)
        # Without a word on what flies, any vehicle may.
        if asked.backend is None and assignments[name].model_word is None:
            lacking = (replace(fault, severity="warning") for fault in lacking)
        faults += lacking
    found = check_ways(assignments, terms, calls)
    return replace(found, faults=(*faults, *found.faults))


def _lacking(graph: Graph, backend: str, model: VehicleModel | None) -> Iterator[Fault]:
    """Faults for what a mission needs and a backend's vehicle does not offer."""
    if model is None:
        who, offered = f"the backend '{backend}'", backend_capabilities(backend)
    else:
        who, offered = f"the model '{model.name}' of the backend '{backend}'", model.capabilities
    yield from missing_capabilities(graph, offered, who)


def _shown(report: Report) -> dict[str, Any]:
    found: dict[str, Any] = {"mission": report.mission}
    if report.graphs or report.fleet:
        found["states"] = report.states
    if report.fleet:
        found["fleet"] = True
    faults = [_told(fault) for fault in report.faults]
    if report.findings is not None:
        found["unknown"] = list(report.findings.unknown)
        found["moving"] = list(report.findings.moving)
        found["complete"] = report.findings.complete
    if report.plan is not None and report.trials:
        from cli.trials import trials_fields

        found |= trials_fields(report.plan, report.trials)
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
        what = "the fleet may fly" if report.fleet else "may fly"
        states = f"{report.states} state{'s'[: report.states != 1]}"
        click.echo(f"{report.mission}: {what}, {states}{counts and f', {counts}'}")
    if report.findings is not None:
        for note in _notes(report.findings):
            click.echo(f"  {note}")
    if report.plan is not None and report.trials:
        from cli.trials import trials_lines

        for line in trials_lines(report.plan, report.trials):
            click.echo(f"  {line}")


def _notes(findings: Findings) -> Iterator[str]:
    """What the check could not look at, for people."""
    if findings.unknown:
        fly = "flies" if len(findings.unknown) == 1 else "fly"
        yield f"known in flight only: where {_joined(findings.unknown)} {fly}, and from there on"
    if findings.moving:
        come = "comes" if len(findings.moving) == 1 else "come"
        yield f"known in flight only: how near {_joined(findings.moving)} {come}, moving"
    if not findings.complete:
        yield "not looked at: some ways through this mission, which has more than are followed"


def _joined(names: Sequence[str], most: int = 8) -> str:
    """``'a', 'b' and 'c'``; of many the first."""
    shown = [f"'{name}'" for name in names[:most]]
    if len(names) > most:
        shown.append(f"{len(names) - most} more")
    return " and ".join([", ".join(shown[:-1]), shown[-1]]) if len(shown) > 1 else shown[0]


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
